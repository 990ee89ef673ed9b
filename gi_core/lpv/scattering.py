# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a homogeneous medium scatters once towards the camera: of lamps, with shadows, and of the volume's light.

The medium fills the scene's bounds, or the settings' box. Along a ray points are drawn by what the medium takes, so
that each counts alike: even light L from all around gives albedo · L · (1 − e^(−σ d)) without noise. The phase function
is that of Henyey & Greenstein (1941), whose bands fall as gˡ. What reaches a point from a lamp is dimmed on its way
too, what reaches it from surfaces is not: the volume knows how much there is, not how far it has come.
"""

from collections.abc import Iterator

import numpy as np

from .. import sh, tiles
from ..lights import towards
from ..sampling import hash01, r2_sequence, rotated
from ..scene import Camera
from ..surfels import camera_rays
from ..trace import FAR, Tracer
from ..vectors import dot, lit
from .grid import box
from .lookup import coefficients
from .settings import LpvSettings
from .volume import Volume

# Points in the medium worked on at once by a thread.
_POINTS = 1 << 14

_BAND = np.repeat(np.arange(3), (1, 3, 5))


def scattered(
    tracer: Tracer, camera: Camera, subpixels: int, rows: slice, volume: Volume, settings: LpvSettings
) -> Iterator[float]:
    """What rays through some rows of subpixels meet in the medium before they end.

    A generator of progress; returns radiance (2, n, 3) of lamps and of the volume [W/(m²·sr)], and the share of what
    lies behind that comes through (n,), float32.
    """
    origins, directions = camera_rays(camera, subpixels, rows)
    n, first = len(origins), rows.start * camera.resolution[0] * subpixels
    radiance, through = np.zeros((2, n, 3), np.float32), np.ones(n, np.float32)
    low, high = box(settings.box) if settings.box else tracer.geometry.bounds

    def tile(part: slice):
        start, ahead = origins[part], directions[part]
        near, far = crossing(start, ahead, low, high)
        far = np.minimum(far, tracer.closest(start, ahead).distance)
        depth = np.maximum(far - near, 0)
        taken = -np.expm1(-settings.fog_density * depth)
        through[part] = 1 - taken
        place = np.arange(part.start, part.stop) + first
        # Strata of equal weight, each at the same place in its own.
        u = (np.arange(settings.fog_steps) + hash01(place, settings.seed)[:, None]) / settings.fog_steps
        t = near[:, None] - np.log1p(-u * taken[:, None]) / np.float32(settings.fog_density)
        row = np.repeat(np.arange(len(start)), settings.fog_steps)
        points = (start[row] + t.reshape(-1, 1) * ahead[row]).astype(np.float32)
        inside = np.flatnonzero(taken[row] > 0)
        index = place[row] * settings.fog_steps + np.arange(len(row)) % settings.fog_steps
        share = (settings.fog_albedo / settings.fog_steps) * taken[row[inside], None]
        for k, light in enumerate((
            _of_lamps(tracer, points[inside], ahead[row[inside]], index[inside], (low, high), settings),
            _of_volume(tracer, points[inside], ahead[row[inside]], volume, settings),
        )):  # fmt: skip
            values = np.zeros((len(row), 3), np.float32)
            values[inside] = share * light
            radiance[k, part] = values.reshape(len(start), -1, 3).sum(1)

    yield from tiles.run(tile, tiles.slices(n, _POINTS // settings.fog_steps))
    return radiance, through


def phase(cosine: np.ndarray, g: float) -> np.ndarray:
    """Share of light that goes on into each direction, by the cosine to where it went before: (n,) -> (n,) [1/sr]."""
    return ((1 - g * g) / (4 * np.pi) / (1 + g * g - 2 * g * cosine) ** 1.5).astype(np.float32)


def crossing(origins, directions, low, high) -> tuple[np.ndarray, np.ndarray]:
    """Where rays enter a box, or start in it, and leave it: (n, 3), (n, 3) -> (n,), (n,) [m]; equal where they miss."""
    with np.errstate(divide="ignore", invalid="ignore"):
        a, b = (low - origins) / directions, (high - origins) / directions
    # A ray within a face's plane: 0 / 0, and that face does not count.
    near = np.where(np.isnan(a) | np.isnan(b), -np.inf, np.minimum(a, b)).max(-1)
    far = np.where(np.isnan(a) | np.isnan(b), np.inf, np.maximum(a, b)).min(-1)
    near = np.maximum(near, 0)
    met = far > near
    return np.where(met, near, 0).astype(np.float32), np.where(met, far, 0).astype(np.float32)


def _of_lamps(tracer, points, ahead, index, bounds, settings) -> np.ndarray:
    """Radiance that points scatter of lamps towards where rays come from, over albedo: (n, 3) float32."""
    total = np.zeros((len(points), 3), np.float32)
    for k, light in enumerate(tracer.geometry.scene.lights):
        u = rotated(r2_sequence(1), index, settings.seed * 1024 + 512 + k)[:, 0]
        arrival = towards(light, points, u)
        row = np.flatnonzero(lit(arrival.irradiance))
        direction = arrival.direction[row]
        value = arrival.irradiance[row] * phase(dot(direction, ahead[row]), settings.fog_anisotropy)[:, None]
        if light.shadow:
            far = np.minimum(arrival.distance[row] * np.float32(1 - 1e-4), FAR)
            value *= tracer.transmittance(points[row], direction, far)[:, None]
        _, way = crossing(points[row], direction, *bounds)
        total[row] += value * np.exp(-settings.fog_density * np.minimum(way, arrival.distance[row]))[:, None]
    return total


def _of_volume(tracer, points, ahead, volume, settings) -> np.ndarray:
    """Radiance that points scatter of the volume's light, over albedo: (n, 3) float32."""
    if not volume.levels:
        return np.zeros((len(points), 3), np.float32)
    found = coefficients(tracer, volume.levels, settings, points)
    k = found.shape[1]
    # Irradiance over the normal is radiance with its bands weakened; the phase function weakens them by gˡ.
    factor = np.float32(settings.fog_anisotropy) ** _BAND[:k] / sh.COSINE[:k]
    return np.maximum(sh.evaluate(found * factor[:, None], ahead), 0) * np.float32(settings.intensity)
