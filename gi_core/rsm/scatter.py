# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that has no map: sent on from points on surfaces, and into the scene from the sky."""

import numpy as np

from .. import environment as beyond
from ..sampling import cosine_hemisphere, disk, frame, hash01
from ..scene import Environment
from ..vectors import normalize
from ..vpls import Vpls
from .views import Rays


def _no_rays() -> Rays:
    empty = np.zeros((0, 3), np.float32)
    return Rays(empty, empty, empty, empty[:, 0], empty[:, 0])


def scattered(lights: Vpls, surface: float, seed: int) -> Rays:
    """One ray from each light, cosine-distributed, with all of its flux: light that goes on to the next bounce.

    surface: area of the scene [m²]; a ray's hit stands for its even share of it, which bounds the light's near field.
    """
    n = len(lights)
    if not n:
        return _no_rays()
    # Neighbours in the list are neighbours in space: one sequence over the list spreads their directions.
    index = np.arange(n)
    u = np.stack([hash01(index, seed * 2 + k) for k in (0, 1)], -1)
    direction = cosine_hemisphere(lights.normal, u).astype(np.float32)
    return Rays(lights.origin, direction, lights.flux, np.full(n, surface / n, np.float32), np.zeros(n, np.float32))


def sky_rays(environment: Environment, bounds: np.ndarray, n: int, seed: int) -> Rays:
    """n rays that fill a scene from all around with the environment's light; none where it is black.

    bounds: (2, 3) corners of the scene. Directions are even over the sphere, starts even over the scene's disk across
        them.
    """
    if beyond.is_black(environment):
        return _no_rays()
    random = [hash01(np.arange(n), seed * 4 + k) for k in range(4)]
    z, phi = 2 * random[0] - 1, 2 * np.pi * random[1]
    across = np.sqrt(np.maximum(1 - z * z, 0))
    direction = normalize(np.stack([across * np.cos(phi), across * np.sin(phi), z], -1))
    center, radius = bounds.mean(0), np.linalg.norm(bounds[1] - bounds[0]) / 2
    local = disk(np.stack(random[2:], -1)) * radius
    x, y = frame(direction)
    origin = center - radius * direction + local[:, :1] * x + local[:, 1:] * y
    section = np.pi * radius**2
    flux = beyond.radiance(environment, -direction) * np.float32(4 * np.pi * section / n)
    spread = np.full(n, section / n, np.float32)
    return Rays(origin.astype(np.float32), direction.astype(np.float32), flux.astype(np.float32), spread, 0 * spread)
