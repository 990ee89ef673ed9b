# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light that has no map: sent on from points on surfaces, and what the sky lights."""

from collections.abc import Iterator

import numpy as np

from .. import environment as beyond
from .. import tiles
from ..direct import from_environment
from ..emitters import strewn
from ..sampling import Samples, cosine_hemisphere, hash01
from ..surfels import at
from ..trace import Tracer
from ..vpls import Vpls
from .views import Rays

# Rays to the sky from each point that stands for what it lights, and points worked on at once by a thread.
_SKY_RAYS, _POINTS = Samples(4), 1 << 13


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


def skylit(tracer: Tracer, n: int, seed: int) -> Iterator[float]:
    """Light of the sky that surfaces reflect, as n points all over them, on both sides; none where the sky is black.

    Not by rays from the sky: in a closed room nearly all of them would be lost on its outside. A generator of progress;
    returns the Vpls.
    """
    geometry = tracer.geometry
    if beyond.is_black(tracer.sky.environment) or not geometry.area > 0:
        return Vpls.concatenate([])
    triangle, weights, area = strewn(geometry, np.ones(len(geometry.triangles)), n // 2)
    place = np.arange(2 * len(triangle))
    points = at(geometry, np.tile(triangle, 2), np.tile(weights, (2, 1)), place, reflecting=True)
    points = points.turned(place >= len(triangle))
    area = np.tile(area, 2)
    solid = area * np.tile(geometry.alpha(triangle, weights), 2)
    flux = np.zeros_like(points.albedo)
    skies = [sky for sky in (tracer.sky, tracer.suns) if sky]

    def tile(part: slice):
        here = points[part]
        for k, sky in enumerate(skies):
            flux[part] += here.albedo * from_environment(tracer, here, sky, _SKY_RAYS, 2 * seed + k) * solid[part, None]

    yield from tiles.run(tile, tiles.slices(len(points), _POINTS))
    return Vpls(points.position, points.origin, points.face, flux, area)
