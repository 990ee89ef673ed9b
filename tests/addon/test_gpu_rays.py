# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays on the graphics card: as the definition has them, and as Embree does."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon import preflight
from gi_bake.addon.read.images import ImageReader
from gi_bake.gi_core import rsm
from gi_bake.gi_core.bvh import build
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_rays import GpuRays, gpu_rays
from gi_bake.gi_core.kernels.rays import closest, occluded
from gi_bake.gi_core.kernels.vpl_shadowed import shadowed
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.scene import ColorSource, Material, Mesh
from gi_bake.gi_core.surfels import camera_rays, from_camera
from gi_bake.gi_core.tiles import finish
from gi_bake.gi_core.trace import FAR, Tracer
from gi_bake.tests import shapes


def unit(v):
    return (v / np.linalg.norm(v, axis=-1, keepdims=True)).astype(np.float32)


def soup(n, seed):
    """Triangles of all sizes about the unit cube."""
    rng = np.random.default_rng(seed)
    corners = rng.random((n, 1, 3)) + 10.0 ** rng.uniform(-2.5, -0.5, (n, 1, 1)) * rng.normal(size=(n, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * n, dtype=np.int32).reshape(-1, 3)


def rays(n, seed, low=-0.5, high=1.5):
    rng = np.random.default_rng(seed)
    origins, directions = rng.uniform(low, high, (n, 3)).astype(np.float32), rng.normal(size=(n, 3))
    # Some along axes, where boxes divide by zero.
    along = n // 8
    directions[:along] = np.eye(3)[np.arange(along) % 3] * rng.choice([-1, 1], (along, 1))
    return origins, unit(directions), rng.uniform(0.01, 2, n).astype(np.float32)


@pytest.mark.parametrize("n", [0, 1, 64, 65, 1000])
@pytest.mark.parametrize("triangles", [1, 3, 200])
def test_the_definition(gpu, same, n, triangles):
    bvh = build(*soup(triangles, n))
    origins, directions, far = rays(n, 3)
    same(occluded, origins, directions, far, bvh)
    same(closest, origins, directions, far, bvh)


@pytest.mark.parametrize("samples, n", [(1, 1), (7, 65), (3, 0)])
def test_shadowed_lights(gpu, same, samples, n):
    rng = np.random.default_rng(n)
    bvh = build(*soup(60, 4))
    picked = np.stack([rng.integers(0, 30, (samples, n)), rng.random((samples, n)).round()], -1).astype(np.float32)
    same(shadowed, picked, rays(n, 5)[0], rays(n, 6)[1], rays(30, 7)[0], bvh)


def as_embree(gpu, geometry, origins, directions, far):
    """Equal hits of 9999 of 10000 rays, their distances and weights to 1e-4."""
    tracer, card = Tracer(geometry), GpuRays(geometry, gpu)
    assert tracer.on_card is None
    hits = tracer.closest(origins, directions)
    triangle, weights, distance = card.closest(origins, directions, np.full(len(origins), FAR))
    agree = triangle == hits.triangle
    # Two triangles that meet in an edge are both right there.
    near = ~agree & (triangle >= 0) & (hits.triangle >= 0) & np.isclose(distance, hits.distance, rtol=1e-5)
    assert np.mean(agree | near) >= 0.9999 and np.mean(agree) >= 0.999
    hit = agree & (triangle >= 0)
    assert hit.mean() > 0.2
    np.testing.assert_allclose(distance[hit], hits.distance[hit], rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(np.quantile(np.abs(weights[hit] - hits.weights[hit]).max(-1), 0.999), 0, atol=1e-3)
    blocked = tracer.occluded(origins, directions, far)
    assert np.mean(card.occluded(origins, directions, far) == blocked) >= 0.9999
    assert 0.01 < blocked.mean() < 0.999


def test_a_soup_of_triangles_as_embree(gpu):
    vertices, triangles = soup(20_000, 1)
    n = len(triangles)
    mesh = Mesh("soup", vertices, triangles, np.zeros((n, 3, 3), np.float32), np.zeros(n, np.int32))
    as_embree(gpu, Geometry(shapes.scene([mesh])), *rays(40_000, 2))


def read(name, sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    _, core = preflight.inspected(bpy.context.scene, bpy.context.view_layer, ImageReader())
    return core


@pytest.mark.parametrize("name", ["cornell", "sunlit_room", "corridor", "emissive"])
def test_a_scene_as_embree(gpu, sample, name):
    core = read(name, sample)
    geometry = Geometry(core)
    origins, directions = camera_rays(replace(core.camera, resolution=(160, 120)))
    # From all over the scene too, in all directions.
    low, high = geometry.bounds
    more = rays(20_000, 5)
    more_origins = low + (high - low) * (more[0] + 0.5) / 2
    far = np.concatenate([np.full(len(origins), FAR), more[2] * np.linalg.norm(high - low) / 4]).astype(np.float32)
    origins = np.concatenate([origins, more_origins.astype(np.float32)])
    as_embree(gpu, geometry, origins, np.concatenate([directions, more[1]]), far)


def test_nothing_slips_between_triangles(gpu):
    """A plate of many triangles, hit on its vertices and edges."""
    k = 16
    x, y = np.meshgrid(np.linspace(-1, 1, k + 1), np.linspace(-1, 1, k + 1))
    vertices = np.stack([x, y, 0 * x], -1).reshape(-1, 3).astype(np.float32)
    i = np.arange((k + 1) ** 2).reshape(k + 1, k + 1)
    a, b, c, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    bvh = build(vertices, np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]))
    inner = vertices[np.abs(vertices[:, :2]).max(-1) < 1]
    middle = (inner + np.roll(inner, 1, 0)) / 2
    targets = np.concatenate([inner, middle[np.abs(middle[:, :2]).max(-1) < 1]])
    eye = np.float32([0.3, -0.2, 1.7])
    d = targets - eye
    far = np.full(len(d), 10, np.float32)
    start = np.broadcast_to(eye, d.shape)
    assert gpu.numpy(gpu.run(occluded, start, unit(d), far, bvh)).all()


def test_the_light_of_a_scene_with_all_rays_on_the_card(gpu, sample, monkeypatch):
    core = read("cornell", sample)
    tracer = Tracer(Geometry(core))
    here = from_camera(tracer, replace(core.camera, resolution=(40, 40)))
    settings = RsmSettings(samples=16, map_resolution=32, bound="disc")
    lighting = finish(rsm.emit(tracer, here, settings))
    expected = finish(rsm.indirect(tracer, here, lighting, settings))
    tracer.device, tracer.on_card = gpu, GpuRays(tracer.geometry, gpu)
    monkeypatch.delattr(Tracer, "connected")  # no ray goes back to the processor
    found = finish(rsm.indirect(tracer, here, lighting, settings))
    assert expected.mean() > 0.01
    assert np.mean((found - expected) ** 2 / (expected**2 + expected.mean() ** 2)) < 1e-5


class Card:
    """A graphics card that is one."""

    software = False


def test_surfaces_with_an_alpha_stay_with_embree(caplog):
    scene = shapes.scene([shapes.plate(0, 1)], material=replace(shapes.matte(), alpha=ColorSource(np.full(3, 0.5))))
    assert isinstance(scene.materials[0], Material)
    with caplog.at_level("INFO"):
        assert gpu_rays(Geometry(scene), Card()) is None
    assert "alpha" in caplog.text


def test_a_driver_in_software_leaves_rays_to_embree(gpu):
    if gpu.software:
        assert gpu_rays(Geometry(shapes.scene([shapes.plate(0, 1)])), gpu) is None


def test_the_main_thread_asks_the_card_and_others_embree(gpu, monkeypatch):
    tracer = shapes.tracer([shapes.plate(0, 1)])
    card = GpuRays(tracer.geometry, gpu)
    monkeypatch.setattr("gi_bake.gi_core.trace.gpu_rays", lambda geometry, device: card)
    monkeypatch.setattr("gi_bake.gi_core.trace._WORTH", 100)
    asked = []
    for name in ("closest", "occluded"):
        query = getattr(card, name)
        monkeypatch.setattr(card, name, lambda *a, name=name, query=query: asked.append(name) or query(*a))
    origins, directions, far = rays(100, 1)
    here = tracer.closest(origins, directions), tracer.occluded(origins, directions, far)
    assert asked == ["closest", "occluded"]
    with ThreadPoolExecutor(1) as pool:
        there = pool.submit(tracer.closest, origins, directions), pool.submit(tracer.occluded, origins, directions, far)
        there = [future.result() for future in there]
    tracer.closest(origins[:99], directions[:99])
    assert len(asked) == 2
    assert np.array_equal(here[0].triangle, there[0].triangle) and np.array_equal(here[1], there[1])
    assert np.allclose(here[0].distance, there[0].distance) and here[0].weights.shape == (100, 3)
