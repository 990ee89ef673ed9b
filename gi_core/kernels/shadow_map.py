# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which points a lamp's shadow map shows in light (Williams 1978, "Casting Curved Shadows on Curved Surfaces").

The four nearest texels are asked and their answers mixed (Reeves, Salesin & Cook 1987). So that a surface does not
shade itself, points are moved along their normal before, by as many texels as it is slanted (Holbert 2011, "Saying
Goodbye to Shadow Acne"): just as far as takes a plane from under its own texels.
"""

import numpy as np

from ..vectors import dot, length

# Texels from a point to the farthest of its four, across the light.
_TEXELS = np.float32(2**0.5)

# Distances that differ by less, as a share, are equal.
_EQUAL = np.float32(1e-4)


def shadow_map(lit, position, face, distance, grid, margin: float) -> np.ndarray:
    """The share of light that arrives at points: (n,) float32, 0…1.

    lit: (n,) of an earlier map, −1 where that did not show the point; it stays where it did. position, face: (n, 3)
    float32, face normals of either side. distance: (w · h,) float32 along the rays of a Grid's pixels [m], from its
    origin or its plane. margin: how far off the map points are still looked up, at its rim, as a share of its side.
    """
    inverse, origin = _numbers(grid)
    parallel = grid.kind == "ORTHOGRAPHIC"
    away = position - origin
    depth = away @ inverse[:, 2]
    direction = np.broadcast_to(grid.axes[2].astype(np.float32), away.shape)
    if not parallel:
        direction = away / np.maximum(length(away), 1e-20)[:, None]
    cosine = dot(face, direction)
    slant = np.sqrt(np.maximum(1 - cosine**2, 0))
    texel = _texel(grid) * (1 if parallel else np.maximum(depth, 0))
    away = away - face * (np.sign(cosine) * _TEXELS * texel * slant)[:, None]
    local = away @ inverse
    far = local[:, 2] if parallel else length(away)
    with np.errstate(divide="ignore", invalid="ignore"):
        plane = local[:, :2] if parallel else local[:, :2] / local[:, 2:]
    left, right, bottom, top = grid.window
    w, h = grid.size
    s, t = (plane[:, 0] - left) / (right - left), (plane[:, 1] - bottom) / (top - bottom)
    inside = (local[:, 2] > 0) & (np.maximum(np.abs(s - 0.5), np.abs(t - 0.5)) <= 0.5 + margin) & (lit < 0)
    here = np.flatnonzero(inside)
    x, y, far = s[here] * w - 0.5, t[here] * h - 0.5, far[here]
    column, row = np.floor(x), np.floor(y)
    share = np.zeros(len(here), np.float32)
    for dx in (0, 1):
        for dy in (0, 1):
            i, j = (np.clip(a, 0, n - 1).astype(np.int64) for a, n in ((column + dx, w), (row + dy, h)))
            weight = np.abs(1 - dx - (x - column)) * np.abs(1 - dy - (y - row))
            share += weight * (far <= distance[j * w + i] * (1 + _EQUAL))
    out = lit.copy()
    out[here] = share
    return out


def shadow_map_on_gpu(gpu, lit, position, face, distance, grid, margin):
    inverse, origin = _numbers(grid)
    left, right, bottom, top = grid.window
    out = gpu.empty((len(lit),), 1)
    frame = np.concatenate([inverse.T, grid.axes[2:], origin[None]]).astype(np.float32)
    inputs = {"lit": (lit, 1), "position": (position, 3), "face": (face, 3), "distance_of": (distance, 1),
              "frame": (frame, 3)}  # fmt: skip
    floats = {"left": left, "right": right, "bottom": bottom, "top": top, "margin": margin, "texel": _texel(grid)}
    integers = {"parallel": grid.kind == "ORTHOGRAPHIC", "columns": grid.size[0], "rows": grid.size[1]}
    gpu.dispatch("shadow_map", len(lit), inputs, {"share": out}, integers=integers, floats=floats, steps=8)
    return out


def _numbers(grid) -> tuple[np.ndarray, np.ndarray]:
    """World to view, and where the view is: (3, 3), (3,) float32."""
    return np.linalg.inv(grid.axes).astype(np.float32), grid.origin.astype(np.float32)


def _texel(grid) -> np.float32:
    """Side of a texel, at forward = 1 of a perspective map [m]."""
    left, right, bottom, top = grid.window
    return np.float32(max((right - left) / grid.size[0], (top - bottom) / grid.size[1]))
