# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the volume to points: which cells count, and how much."""

from collections.abc import Iterator

import numpy as np

from .. import sh
from ..device import NUMPY, Device
from ..kernels.lpv_received import received
from ..kernels.lpv_trilinear import corners, mixed, trilinear
from ..sampling import cosine_hemisphere, r2_sequence
from ..surfels import Surfels
from ..trace import Tracer
from ..vectors import dot, normalize
from .grid import Grid
from .settings import LpvSettings
from .volume import Level, Volume

_POINTS = 1 << 13

# A cell whose middle is hidden counts this little, so that where all are hidden they count alike.
_HIDDEN = np.float32(1e-4)

# From which light is looked at where relief hides some of it.
_DIRECTIONS = 32

# How far along the normal the volume's change is looked at [cells].
_STEP = 0.2


def weights(tracer: Tracer | None, grid: Grid, points: np.ndarray, face=None) -> tuple[np.ndarray, np.ndarray]:
    """The cells around points and how much they count: (n, 3) [m] -> (n, 8) places in C order, (n, 8) float32, sum 1.

    tracer: rays find out which cells' middles a point sees; None takes all. face: (n, 3) unit, the side of its surface
    that a point looks to; what lies behind is not seen.
    """
    cells, weight = corners(grid.local(points), grid.shape)
    if tracer is not None:
        middle = grid.centres(cells)
        seen = np.ones(weight.shape, bool)
        if face is not None:
            seen = dot(middle - points[:, None], face[:, None]) > 0
        row, column = np.nonzero(seen & (weight > 0))
        seen[row, column] = tracer.connected(points[row], middle[row, column])
        weight *= np.where(seen, 1, _HIDDEN)
        weight /= np.maximum(weight.sum(-1, keepdims=True), 1e-20)
    return grid.flat(cells), weight


def around(grid: Grid, points: np.ndarray) -> np.ndarray:
    """The cells that points within a grid look at: (n, 3) [m] -> places in C order, ascending."""
    looked_at = np.zeros(grid.size, bool)
    local = grid.local(points)
    local = local[np.all((local >= 0) & (local <= np.array(grid.shape)), -1)]
    looked_at[grid.flat(corners(local, grid.shape)[0])] = True
    return np.flatnonzero(looked_at)


def _share(grid: Grid, points: np.ndarray, width: float) -> np.ndarray:
    """How much of a grid's light counts at points: 1 inside, 0 outside, between over `width` cells: (n,) float32."""
    local = grid.local(points)
    depth = np.min(np.minimum(local, np.array(grid.shape, np.float32) - local), -1)
    return np.clip(depth / max(width, 1e-6), 0, 1).astype(np.float32)


def coefficients(
    tracer, levels: tuple[Level, ...], settings: LpvSettings, points, face=None, device: Device = NUMPY
) -> np.ndarray:
    """Irradiance over the normal at points, all at once: (n, 3) -> (n, k, 3) float32 [W/m²], on the device."""
    out, left = None, np.ones(len(points), np.float32)
    for k, level in enumerate(levels):
        last = k == len(levels) - 1
        share = np.ones_like(left) if last and not settings.fade else (
            _share(level.grid, points, settings.fade if last else settings.blend))  # fmt: skip
        if _sees(settings):
            out = np.zeros((len(points), *level.irradiance.shape[1:]), np.float32) if out is None else out
            row = np.flatnonzero(share * left)
            index, weight = weights(tracer, level.grid, points[row], None if face is None else face[row])
            out[row] += mixed(level.irradiance, index, weight * (share * left)[row, None])
        else:
            local = level.grid.local(points)
            out = device.run(trilinear, level.irradiance, local, level.grid.shape, share * left, out)
        left = left * (1 - share)
    return out


def _sees(settings: LpvSettings) -> bool:
    """Whether rays find out which cells a point sees."""
    return settings.visibility and settings.propagation == "hierarchical"


def indirect(tracer: Tracer, surfels: Surfels, volume: Volume, settings: LpvSettings) -> Iterator[float]:
    """Irradiance from the volume at surfels. A generator of progress; returns (n, 3) float32 [W/m²]."""
    if not volume.levels:
        return np.zeros((len(surfels), 3), np.float32)
    # Rays need the processor's threads.
    device = NUMPY if _sees(settings) else tracer.device

    def tile(part: slice):
        here, ahead = surfels[part], None
        found = coefficients(tracer, volume.levels, settings, here.origin, here.face, device)
        factor = np.full(len(here), settings.intensity, np.float32)
        if settings.derivative_damping:
            step = np.float32(_STEP * volume.levels[0].grid.cell) * here.smooth
            ahead = coefficients(tracer, volume.levels, settings, here.origin + step, here.face, device)
        if settings.directional_occlusion:
            far = settings.occlusion_radius * volume.levels[0].grid.cell
            factor *= 1 - np.float32(settings.directional_occlusion) * _hidden(tracer, here, device.numpy(found), far)
        light = device.run(received, found, here.normal, factor, ahead, settings.derivative_damping)
        return light if not here.is_bumpy else device.array(_on_relief(here, *map(device.numpy, (found, light))), 3)

    return device.numpy((yield from device.each(tile, len(surfels), _POINTS)))


def _on_relief(here: Surfels, found: np.ndarray, light: np.ndarray) -> np.ndarray:
    """Irradiance (n, 3), with less of it where a map turns normals: what is seen from there above the mesh's own plane,
    as far as it counts (`bump`), of all that the volume has around. found: (n, k, 3)."""
    row = np.flatnonzero(np.any(here.smooth != here.normal, -1))
    around, seen = np.zeros((2, len(row), 3), np.float32)
    for u in r2_sequence(_DIRECTIONS):
        direction = cosine_hemisphere(here.normal[row], np.broadcast_to(u, (len(row), 2)))
        there = np.maximum(sh.evaluate(found[row] / sh.COSINE[: found.shape[1], None], direction), 0)
        around += there
        seen += there * here.shadowing(row, direction)[:, None]
    light = light.copy()
    light[row] *= np.divide(seen, around, out=np.zeros_like(seen), where=around > 0)
    return light


def radiance(tracer: Tracer, surfels: Surfels, volume: Volume, settings: LpvSettings) -> np.ndarray:
    """Radiance of the volume over the direction that it comes from, at surfels: (n, k, 3) float32 [W/(m²·sr)].

    Irradiance over the normal is radiance with its bands weakened (Ramamoorthi & Hanrahan 2001).
    """
    if not volume.levels:
        return np.zeros((len(surfels), 4, 3), np.float32)
    found = coefficients(tracer, volume.levels, settings, surfels.origin, surfels.face)
    return found * (np.float32(settings.intensity) / sh.COSINE[: found.shape[1], None])


def _hidden(tracer: Tracer, here: Surfels, found: np.ndarray, far: float) -> np.ndarray:
    """Whether something near stands where most of a point's light comes from: (n,) float32, 0 or 1."""
    direction = normalize(sh.vector(found).mean(-1))
    looks = np.flatnonzero(dot(direction, here.face) > 0)
    hidden = np.zeros(len(here), np.float32)
    hidden[looks] = tracer.occluded(here.origin[looks], direction[looks], np.full(len(looks), far, np.float32))
    return hidden
