# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lattice of screen-space interpolation: which of its points a point of the image may be mixed of, and the mix.

The likeness of Dachsbacher & Stamminger 2005, §3.3, with a unit ℓ of its own; see `rsm.interpolation`.
"""

import numpy as np

from ..vectors import dot

_NORMAL, _POSITION, _ENOUGH = 1.0, 4.0, 3.0

# A lattice point that is less alike is on another surface: turned by 50°, or 1.7 cells away.
_ALIKE = 0.5

# What a point is.
ALONE, LATTICE, MIXED = range(3)


def agreeing(place, position, normal, span, rows, size: tuple[int, int], step: int, part: slice = slice(None)):
    """The lattice points around points of an image, and how much each may count.

    place: (n,) int64 row · width + column. position, normal: (n, 3) float32. span: (n,) ℓ [m].
    rows: (k,) int64, which point lies at the places from the image's row `place.min() // width // step · step` on, −1
        for none, see `rows_of`. size: (width, height) of the image. part: of the points, which are wanted.
    Returns neighbours (n, 4) int32, −1 for none, weights (n, 4) float32, and whether a point is ALONE, on the LATTICE,
    or MIXED (n,) int32.
    """
    first = first_row(place, size, step)
    around, bilinear = lattice(place[part] - first * size[0], (size[0], size[1] - first), step)
    row = np.where(around < len(rows), rows[np.minimum(around, len(rows) - 1)], -1)
    like = likeness(position[part], normal[part], position[row], normal[row], span[part])
    like = np.where(row >= 0, like, 0)
    kind = np.where(bilinear.max(-1) == 1, LATTICE, np.where(like.sum(-1) > _ENOUGH, MIXED, ALONE))
    return row.astype(np.int32), (bilinear * like).astype(np.float32), kind.astype(np.int32)


def agreeing_on_gpu(gpu, place, position, normal, span, rows, size, step: int, part: slice = slice(None)):
    n = len(place)
    first = first_row(place, size, step)
    pixel = np.stack([place % size[0], place // size[0] - first], -1)
    found = gpu.empty((n, 4), 4, np.int32), gpu.empty((n, 4), 4), gpu.empty((n,), 1, np.int32)
    gpu.dispatch(
        "lattice_agreeing", n,
        {"pixel": (pixel.astype(np.float32), 2), "position": (position, 3), "normal": (normal, 3), "span": (span, 1),
         "row_of_place": (rows, 1)},
        dict(zip(("neighbours", "weights", "kind"), found)),
        integers={"width": size[0], "height": size[1] - first, "step_": step, "places": len(rows)}, steps=4,
    )  # fmt: skip
    return found


def mixed(irradiance: np.ndarray, neighbours: np.ndarray, weights: np.ndarray, part: slice = slice(None)) -> np.ndarray:
    """Lattice points' light by their weights: (n, 3), (n, 4), (n, 4) -> (n, 3) float32. part: which are wanted."""
    weights = weights[part]
    total = np.einsum("nk,nkc->nc", weights, irradiance[neighbours[part]])
    return total / np.maximum(weights.sum(-1, keepdims=True), np.float32(1e-20))


def mixed_on_gpu(gpu, irradiance, neighbours, weights, part: slice = slice(None)):
    n = len(neighbours)
    result = gpu.empty((n, 3), 3)
    inputs = {"irradiance": (irradiance, 3), "neighbours": (neighbours, 4), "weights": (weights, 4)}
    gpu.dispatch("lattice_mixed", n, inputs, {"result": result}, steps=4)
    return result


def first_row(place: np.ndarray, size: tuple[int, int], step: int) -> int:
    """The row of the lattice at or below all places; lattices from there on are the same."""
    return int(place.min()) // size[0] // step * step if len(place) else 0


def rows_of(place: np.ndarray, size: tuple[int, int], step: int) -> np.ndarray:
    """Which point lies at each place from the first row on, −1 for none: (n,) -> (k,) int64."""
    place = place - first_row(place, size, step) * size[0]
    rows = np.full(place.max(initial=0) + 1, -1)
    rows[place] = np.arange(len(place))
    return rows


def lattice(place: np.ndarray, size: tuple[int, int], step: int) -> tuple[np.ndarray, np.ndarray]:
    """The four lattice points around points of an image, (n,) -> (n, 4), and their bilinear weights (n, 4) float32.

    The lattice takes every `step`-th row and column, and the last. A point of it has itself at weight one.
    """

    def around(x, n):
        low = x // step * step
        high = np.minimum(low + step, n - 1)
        return (low, high), (x - low) / np.maximum(high - low, 1)

    y, x = np.divmod(place, size[0])
    (rows, v), (columns, u) = around(y, size[1]), around(x, size[0])
    places = np.stack([row * size[0] + column for row in rows for column in columns], -1)
    return places, np.stack([b * a for b in (1 - v, v) for a in (1 - u, u)], -1).astype(np.float32)


def likeness(position, normal, lattice_position, lattice_normal, span: np.ndarray) -> np.ndarray:
    """How surely lattice points lie on the same surface: (n, 3) twice, (n, k, 3) twice, (n,) ℓ [m] -> (n, k) float32,
    0…1."""
    dn, dp = lattice_normal - normal[:, None], lattice_position - position[:, None]
    like = np.exp(-dot(dn, dn) / _NORMAL - dot(dp, dp) / (_POSITION * span[:, None] ** 2))
    return np.where(like < _ALIKE, 0, like)
