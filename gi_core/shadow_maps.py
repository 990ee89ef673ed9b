# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direct light of lamps by shadow maps: what a lamp sees is lit, up to the size of its map's texels.

A soft lamp is many hard ones, each with a map of its own, for all points alike (Heckbert & Herf 1997, "Simulating Soft
Shadows with Graphics Hardware"). Where there is a graphics card the maps are drawn and looked up there.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from . import direct, tiles
from .kernels.shadow_map import shadow_map
from .lights import points_on, towards
from .rsm.views import View, rays, views
from .sampling import frame, hash01, r2_sequence
from .scene import Light
from .surfels import TILE, Surfels
from .trace import Tracer
from .vectors import dot, length

# Points worked on at once by a thread.
_POINTS = 1 << 15

# What is nearer to a lamp does not shade, as a share of the scene's size: a mesh that the lamp lies in.
_NEAR = np.float32(1e-4)

_GOLDEN = (5**0.5 - 1) / 2


def lamps(tracer: Tracer, surfels: Surfels, samples: int, seed: int, resolution: int) -> Iterator[float]:
    """As `direct.lamps`, with shadows by maps of `resolution`² texels for each sample of a lamp; 0 for rays.

    A generator of progress; returns (n, 3) float32 [W/m²]. Shadows are off by a texel or two at their edges, and what
    is thinner than a texel may have none. Suns in the environment have theirs by rays.
    """
    if not resolution or not len(surfels) or not len(tracer.geometry.triangles):
        return (yield from direct.lamps(tracer, surfels, samples, seed))
    lights = tracer.geometry.scene.lights
    irradiance = yield from direct.lamps(tracer, surfels, samples, seed, [one for one in lights if not one.shadow])
    device = tracer.device
    points = device.array(surfels.position, 3), device.array(surfels.face, 3)
    for k, light in enumerate(lights):
        if light.shadow:
            irradiance += yield from _from_lamp(tracer, surfels, points, light, samples, seed * 1024 + k, resolution)
    return irradiance


def _from_lamp(tracer, surfels, points, light: Light, samples: int, seed: int, resolution: int) -> Iterator[float]:
    """Irradiance from one lamp. A generator of progress; returns (n, 3) float32 [W/m²]."""
    samples = 1 if direct.is_hard(light) else samples
    irradiance = np.zeros((len(surfels), 3), np.float32)
    u = (r2_sequence(samples) + hash01(np.arange(2), seed)) % 1
    depth = ((np.arange(samples) + 0.5) * _GOLDEN + hash01(2, seed)) % 1
    for k in range(samples):
        lit = yield from _lit(tracer, points, views(_hard(light, u[k], depth[k]), tracer.geometry.bounds, resolution))

        def tile(part: slice, u=u[k : k + 1], lit=lit):
            arrival = towards(light, surfels.position[part], np.broadcast_to(u, (part.stop - part.start, 2)))
            cosine = np.maximum(dot(surfels.normal[part], arrival.direction), 0) * lit[part]
            irradiance[part] += arrival.irradiance * (cosine / np.float32(samples))[:, None]

        yield from tiles.run(tile, tiles.slices(len(surfels), _POINTS))
    return irradiance


def _lit(tracer, points, maps: list[View]) -> Iterator[float]:
    """What maps show in light: a generator of progress; returns (n,) float32. What none shows is lit."""
    device, (position, face) = tracer.device, points
    n = len(position)
    lit = device.array(np.full(n, -1, np.float32), 1)
    # At the rim of a spot's cone a map may end a little early; the sides of a cube do not overlap.
    margin = 0.5 if len(maps) == 1 else 1e-5
    for view in maps:
        if view.grid is None:
            continue
        distance = yield from _distances(tracer, view)
        distance = device.array(distance, 1)

        def tile(part: slice, lit=lit, distance=distance, grid=view.grid):
            return device.run(shadow_map, lit[part], position[part], face[part], distance, grid, margin)

        lit = yield from device.each(tile, n, _POINTS)
    lit = device.numpy(lit)
    return np.where(lit < 0, np.float32(1), lit)


def _distances(tracer: Tracer, view: View) -> Iterator[float]:
    """How far from the lamp what each texel's middle shows is: a generator of progress; returns (k,) float32 [m]."""
    n = view.resolution
    middle = np.stack(np.meshgrid(np.arange(n), np.arange(n)), -1).reshape(-1, 2) / n + 0.5 / n
    through = rays(view, middle, np.full((n * n, 2), 0.5), np.full(n * n, 1 / n**2))
    # A sun's map starts hardly farther from the scene than that.
    size = length(np.ptp(tracer.geometry.bounds, 0)) if view.kind == "PERSPECTIVE" else 0
    near = _NEAR * np.float32(size)
    origins = through.origin + near * through.direction
    drawn = yield from tracer.drawn(replace(view.grid, reach=near), origins, through.direction)
    distance = np.zeros(n * n, np.float32)

    def tile(part: slice):
        solid = drawn and drawn[part]
        distance[part] = tracer.closest(origins[part], through.direction[part], solid=solid).distance + near

    yield from tiles.run(tile, tiles.slices(n * n, TILE))
    return distance


def _hard(light: Light, u: np.ndarray, depth: float) -> Light:
    """A hard lamp for one sample of a soft one: its points, seen from anywhere, are spread as the soft one's."""
    matrix = np.eye(4)
    if light.kind == "SUN":
        ahead = towards(light, np.zeros((1, 3), np.float32), u[None]).direction[0].astype(np.float64)
        matrix[:3, 0], matrix[:3, 1] = frame(ahead)
        matrix[:3, 2] = ahead
        return replace(light, angle=0.0, matrix=matrix)
    if light.kind == "AREA":
        matrix[:3, 3] = points_on(light, u[None])[0]
        return replace(light, kind="POINT", radius=0.0, matrix=matrix)
    # Density 1/√(R² − r²) in a ball looks from every side like an even disk.
    angle = np.linspace(0, np.pi / 2, 257)
    r = light.radius * np.sin(np.interp(depth, (angle - np.sin(angle) * np.cos(angle)) * 2 / np.pi, angle))
    z, phi = 1 - 2 * u[0], 2 * np.pi * u[1]
    ring = np.sqrt(max(0, 1 - z * z))
    matrix = light.matrix.copy()
    matrix[:3, 3] += r * np.array([ring * np.cos(phi), ring * np.sin(phi), z])
    return replace(light, radius=0.0, matrix=matrix)
