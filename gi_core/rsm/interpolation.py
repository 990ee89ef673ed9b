# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space interpolation: indirect light gathered at few pixels and mixed between them where that is safe.

As in Dachsbacher & Stamminger 2005: the points of a coarse lattice over the image gather first. Any other point takes
the bilinear mix of the four lattice points around it where these lie on the same surface: their likeness

    exp(−|Δn|² / 1.0) · exp(−|Δp|² / (4 ℓ²))

must sum to more than 3 of 4. Elsewhere it gathers for itself. The paper's Δp is in its scene's units; here the unit ℓ
is what the side of a lattice cell spans on the point's own surface, so that neither the scene's scale nor the distance
nor the slant changes what is reused. A flat surface comes to at least 3.16.
"""

import logging
from collections.abc import Iterator

import numpy as np

from .. import tiles
from ..sampling import Samples
from ..scene import Camera
from ..surfels import TILE, Surfels
from ..trace import Tracer
from ..vectors import dot, normalize
from . import Lighting, indirect
from .settings import RsmSettings

_LOG = logging.getLogger(__name__)

_NORMAL, _POSITION, _ENOUGH = 1.0, 4.0, 3.0

# A lattice point that is less alike is on another surface: turned by 50°, or 1.7 cells away.
_ALIKE = 0.5

# The slant beyond which a surface counts as no longer than this.
_MIN_COSINE = 0.1


def interpolated_indirect(
    tracer: Tracer,
    surfels: Surfels,
    lighting: Lighting,
    settings: RsmSettings,
    camera: Camera,
    subpixels: int,
    samples: Samples | None = None,
) -> Iterator[float]:
    """Irradiance from reflected light at what a camera sees, with `settings.interpolation` pixels to a lattice cell.

    surfels: of `surfels.from_camera`, of whole rows. samples: what one subpixel gathers, None for `settings.samples`; a
        lattice point stands for pixels and gathers as much as all subpixels of one.
    A generator of progress; returns (n, 3) float32 [W/m²] and the share of the surfels that took a mix, 0…1.
    """
    samples = samples or Samples(settings.samples)
    if settings.interpolation == 1 or not len(surfels):
        return (yield from indirect(tracer, surfels, lighting, settings, samples)), 0.0
    width, height = (n * subpixels for n in camera.resolution)
    step = settings.interpolation * subpixels
    # Of the places that the surfels span; around them there is nothing.
    low, high = surfels.place.min(), surfels.place.max()
    row_of_place = np.full(high - low + 3, -1)
    row_of_place[surfels.place - low + 1] = np.arange(len(surfels))
    span = step * spacing(surfels, camera, subpixels)

    on_lattice, mixed = np.zeros((2, len(surfels)), bool)
    neighbours = np.zeros((len(surfels), 4), np.int32)
    weight = np.zeros((len(surfels), 4), np.float32)
    irradiance = np.zeros((len(surfels), 3), np.float32)

    def choose(part: slice):
        place, bilinear = lattice(surfels.place[part], (width, height), step)
        row = row_of_place[np.clip(place - low + 1, 0, len(row_of_place) - 1)]
        position, normal = surfels.position[row], surfels.normal[row]
        like = np.where(row >= 0, likeness(surfels[part], position, normal, span[part]), 0)
        on_lattice[part] = bilinear.max(-1) == 1
        mixed[part] = ~on_lattice[part] & (like.sum(-1) > _ENOUGH)
        neighbours[part], weight[part] = row, bilinear * like

    def mix(part: slice):
        rows = np.flatnonzero(mixed[part]) + part.start
        total = np.einsum("nk,nkc->nc", weight[rows], irradiance[neighbours[rows]])
        irradiance[rows] = total / weight[rows].sum(-1, keepdims=True)

    parts = tiles.slices(len(surfels), TILE)
    yield from tiles.within(0, 0, tiles.run(choose, parts))
    alone = ~on_lattice & ~mixed
    finer = samples.part(subpixels**2)
    coarse = np.count_nonzero(on_lattice) * subpixels**2
    share = coarse / (coarse + np.count_nonzero(alone))
    work = indirect(tracer, surfels[on_lattice], lighting, settings, finer)
    irradiance[on_lattice] = yield from tiles.within(0, share, work)
    irradiance[alone] = yield from tiles.within(share, 1, indirect(tracer, surfels[alone], lighting, settings, samples))
    yield from tiles.within(1, 1, tiles.run(mix, parts))
    _LOG.info("interpolation: %.1f %% of the points reuse their neighbours' light", 100 * mixed.mean())
    return irradiance, float(mixed.mean())


def spacing(surfels: Surfels, camera: Camera, subpixels: int) -> np.ndarray:
    """How far subpixels are apart on the surfaces that a camera sees: (n,) float32 [m]."""
    left, right, bottom, top = camera.window
    one = max((right - left) / camera.resolution[0], (top - bottom) / camera.resolution[1]) / subpixels
    arm, ahead = surfels.position - camera.matrix[:3, 3], -camera.matrix[:3, 2]
    if camera.kind == "PERSPECTIVE":
        one, towards = one * (arm @ ahead), normalize(arm)
    else:
        towards = np.broadcast_to(ahead, arm.shape)
    return (one / np.maximum(np.abs(dot(towards, surfels.face)), _MIN_COSINE)).astype(np.float32)


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


def likeness(here: Surfels, position: np.ndarray, normal: np.ndarray, span: np.ndarray) -> np.ndarray:
    """How surely lattice points lie on the same surface: (n,) surfels, (n, k, 3) twice, (n,) ℓ [m] -> (n, k) float32,
    0…1."""
    dn, dp = normal - here.normal[:, None], position - here.position[:, None]
    like = np.exp(-dot(dn, dn) / _NORMAL - dot(dp, dp) / (_POSITION * span[:, None] ** 2))
    return np.where(like < _ALIKE, 0, like)
