# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What gpu.py times of gathering: lights, interpolation, and rays, by Embree where numpy is timed and in GLSL."""

from collections.abc import Callable, Iterator
from types import SimpleNamespace

import numpy as np
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.gathering import Every, Strided, gather
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_rays import GpuRays
from gi_bake.gi_core.kernels.lattice import agreeing, mixed, rows_of
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.scene import ColorSource, Instance, Material, Mesh, Scene
from gi_bake.gi_core.surfels import TILE, Surfels
from gi_bake.gi_core.trace import Tracer
from gi_bake.gi_core.vpls import Vpls

POINTS, RAYS = 1 << 16, 1 << 19

# By a device, work that ends where numpy is.
Works = dict[str, tuple[Callable[[object], Iterator[float]], float]]


def unit(rng, n: int) -> np.ndarray:
    v = rng.normal(size=(n, 3)).astype(np.float32)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def gathers() -> Works:
    """By what is timed: a function of a device, and texels that are read in all."""
    rng, points = np.random.default_rng(1), POINTS

    def some(n):
        return rng.uniform(-1, 1, (n, 3)).astype(np.float32), unit(rng, n)

    position, normal = some(points)
    here = Surfels(position, normal, normal, 0 * normal, 0 * normal, np.arange(points))

    def lights(n):
        position, axis = some(n)
        return Vpls(position, position, axis, rng.random((n, 3), np.float32), np.full(n, 1e-3, np.float32))

    def gathering(vpls, pattern, candidates=1):
        def work(device):
            tracer = SimpleNamespace(device=device, on_card=None)
            return gather(tracer, here, vpls, pattern, False, candidates=candidates)

        return work, 3 * points * pattern.lights

    few, cloud = lights(1024), lights(1 << 17)
    return {
        "all of 1024 lights": gathering(few, Every(len(few))),
        "flux, 64 samples": gathering(cloud, Strided.of(cloud, Samples(64), 1)),
        "flux, 64 samples of 4 candidates": gathering(cloud, Strided.of(cloud, Samples(64), 1, 4), 4),
    }


def interpolation(side: int) -> Callable[[object], Iterator[float]]:
    """Agreement with the lattice and the mix, at every pixel of a bumpy square."""
    rng = np.random.default_rng(2)
    n, size, step = side * side, (side, side), 4
    place = np.arange(n)
    position = np.stack([place % side, place // side, 0.1 * rng.random(n)], -1).astype(np.float32)
    normal = (unit(rng, n) * 0.1 + np.float32([0, 0, 1])).astype(np.float32)
    light, span = rng.random((n, 3), np.float32), np.full(n, step, np.float32)

    def work(device):
        points = place, device.array(position, 3), device.array(normal, 3), span, rows_of(place, size, step)
        found = yield from device.each(lambda part: device.run(agreeing, *points, size, step, part), n, TILE)
        return device.numpy((yield from device.each(lambda part: device.run(mixed, light, *found[:2], part), n, TILE)))

    return work


def shadow_rays(gpu) -> Callable[[object], Iterator[float]]:
    """Shadow rays all over a bumpy plate, by Embree on all cores and in GLSL."""
    k, n = 300, RAYS
    x, y = np.meshgrid(np.linspace(0, 1, k), np.linspace(0, 1, k))
    vertices = np.dstack([x, y, 0.1 * np.sin(40 * x) * np.cos(43 * y)]).reshape(-1, 3).astype(np.float32)
    i = np.arange(k * k).reshape(k, k)
    a, b, c, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int32)
    normals, slots = np.zeros((len(triangles), 3, 3), np.float32), np.zeros(len(triangles), np.int32)
    mesh = Mesh("bumps", vertices, triangles, normals, slots)
    white = Material("white", ColorSource(np.ones(3, np.float32)))
    geometry = Geometry(Scene((mesh,), (Instance("bumps", 0, np.eye(4), (0,)),), (white,)))
    tracer, card = Tracer(geometry), GpuRays(geometry, gpu)
    rng = np.random.default_rng(3)
    origins = rng.uniform((0, 0, -0.1), (1, 1, 0.3), (n, 3)).astype(np.float32)
    directions, far = unit(rng, n), np.ones(n, np.float32)

    def work(device):
        if device is NUMPY:
            return (yield from device.each(lambda p: tracer.transmittance(origins[p], directions[p], far[p]), n, TILE))
        yield 0.0
        return card.transmittance(origins, directions, far)

    return work


def gathering(gpu) -> Works:
    """All of it, as `gathers`."""
    works = {f"gather, {name}": work for name, work in gathers().items()}
    works["interpolation, agreement and mix, 512 × 512"] = interpolation(512), 0
    works["rays: Embree (for numpy), GLSL, 178 802 triangles, 2¹⁹ shadow rays"] = shadow_rays(gpu), 0
    return works
