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
from ..device import NUMPY
from ..kernels.lattice import ALONE, LATTICE, MIXED, agreeing, mixed, rows_of
from ..sampling import Samples
from ..scene import Camera
from ..surfels import TILE, Surfels
from ..trace import Tracer
from ..vectors import dot, normalize
from . import Lighting, indirect
from .settings import RsmSettings

_LOG = logging.getLogger(__name__)

# Places beyond are not exact in the single precision in which a graphics card counts them.
_DEVICE_PLACES = 1 << 24

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
    size, step = tuple(n * subpixels for n in camera.resolution), settings.interpolation * subpixels
    rows = rows_of(surfels.place, size, step)
    device = tracer.device if len(rows) < _DEVICE_PLACES else NUMPY
    span = step * spacing(surfels, camera, subpixels)
    points = surfels.place, device.array(surfels.position, 3), device.array(surfels.normal, 3), span
    rows_there = device.array(rows, 1)

    def choose(part: slice):
        return device.run(agreeing, *points, rows_there, size, step, part)

    n = len(surfels)
    neighbours, weights, kind = yield from tiles.within(0, 0, device.each(choose, n, TILE))
    kind = device.numpy(kind)
    on_lattice, alone, is_mixed = (kind == k for k in (LATTICE, ALONE, MIXED))
    irradiance = np.zeros((n, 3), np.float32)
    finer = samples.part(subpixels**2)
    coarse = np.count_nonzero(on_lattice) * subpixels**2
    share = coarse / (coarse + np.count_nonzero(alone))
    work = indirect(tracer, surfels[on_lattice], lighting, settings, finer)
    irradiance[on_lattice] = yield from tiles.within(0, share, work)
    irradiance[alone] = yield from tiles.within(share, 1, indirect(tracer, surfels[alone], lighting, settings, samples))
    light = device.array(irradiance, 3)
    work = device.each(lambda part: device.run(mixed, light, neighbours, weights, part), n, TILE)
    mix = yield from tiles.within(1, 1, work)
    irradiance[is_mixed] = device.numpy(mix)[is_mixed]
    _LOG.info("interpolation: %.1f %% of the points reuse their neighbours' light", 100 * is_mixed.mean())
    return irradiance, float(is_mixed.mean())


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
