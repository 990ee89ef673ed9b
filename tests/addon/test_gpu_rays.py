# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays on the graphics card: as the definition has them, and as Embree does."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon import preflight
from gi_bake.addon.read.images import ImageReader
from gi_bake.gi_core.bvh import build
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_raster import raster_of
from gi_bake.gi_core.gpu_rays import gpu_rays
from gi_bake.gi_core.kernels.rays import closest, through
from gi_bake.gi_core.kernels.veil import Veil, solid
from gi_bake.gi_core.kernels.vpl_shadowed import shadowed
from gi_bake.gi_core.scene import ColorSource, Mesh, Texture
from gi_bake.gi_core.surfels import camera_rays
from gi_bake.gi_core.texture import srgb_to_linear
from gi_bake.gi_core.tiles import finish, run, slices
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


def veils(n, seed):
    """Alphas of a few materials: none, a number, and textures of all kinds."""
    rng, textures = np.random.default_rng(seed), []
    for extension in ("REPEAT", "MIRROR", "EXTEND", "CLIP"):
        for interpolation in ("LINEAR", "CLOSEST"):
            bits = rng.integers(0, 256, (int(rng.integers(1, 60)), 37, 3), np.uint8)
            textures.append(Texture("", srgb_to_linear(bits / 255).astype(np.float32), extension, interpolation,
                                    bits if len(textures) % 3 else None))  # fmt: skip
    values = rng.random((10, 3), np.float32)
    sources = [ColorSource(values[0] * 0 + 1), ColorSource(values[1])]
    sources += [ColorSource(v, t) for v, t in zip(values[2:], textures)]
    uvs = rng.uniform(-2, 3, (n, 3, 2)).astype(np.float32)
    mesh = Mesh("", np.zeros((3 * n, 3), np.float32), np.arange(3 * n, dtype=np.int32).reshape(n, 3),
                np.zeros((n, 3, 3), np.float32), rng.integers(0, 10, n).astype(np.int32), {"": uvs})  # fmt: skip
    scene = shapes.scene([mesh])
    materials = tuple(replace(shapes.matte(), alpha=source) for source in sources)
    instances = (replace(scene.instances[0], materials=tuple(range(10))),)
    geometry = Geometry(replace(scene, materials=materials, instances=instances))
    veil = Veil.of(geometry, np.arange(n))
    k, w = np.repeat(np.arange(n), 20), rng.dirichlet((1, 1, 1), 20 * n).astype(np.float32)
    # The definition is the geometry's own.
    assert np.isclose(solid(veil, k, w[:, 1], w[:, 2]), geometry.alpha(k, w), atol=1e-3).mean() >= 0.999
    return veil


def mostly(gpu, kernel, *arguments):
    """The share of items for which the card finds what numpy does."""
    expected, found = kernel(*arguments), gpu.numpy(gpu.run(kernel, *arguments))
    assert found.shape == expected.shape
    return np.isclose(found, expected, rtol=1e-4, atol=1e-4).all(-1).mean() if len(found) else 1.0


@pytest.mark.parametrize("n", [0, 1, 64, 65, 1000])
@pytest.mark.parametrize("triangles", [1, 3, 200])
def test_the_definition(gpu, same, n, triangles):
    bvh = build(*soup(triangles, n))
    origins, directions, far = rays(n, 3)
    same(through, origins, directions, far, bvh)
    same(closest, origins, directions, far, bvh)
    bvh = replace(bvh, veil=veils(len(bvh.a), n))
    same(through, origins, directions, far, bvh)
    # Of one ray in a few hundred what is left is as much as it may be, but for rounding.
    agrees = mostly(gpu, closest, origins, directions, far, bvh, np.random.default_rng(n).random(n, np.float32))
    assert agrees >= 0.99


@pytest.mark.parametrize("samples, n", [(1, 1), (7, 65), (3, 0)])
def test_shadowed_lights(gpu, same, samples, n):
    rng = np.random.default_rng(n)
    bvh = build(*soup(60, 4))
    picked = np.stack([rng.integers(0, 30, (samples, n)), rng.random((samples, n)).round()], -1).astype(np.float32)
    same(shadowed, picked, rays(n, 5)[0], rays(n, 6)[1], rays(30, 7)[0], bvh)


@pytest.fixture
def card(gpu, monkeypatch):
    """The device, whose own work rays are."""
    monkeypatch.setattr(gpu, "traces", True)
    return gpu


def as_embree(card, geometry, origins, directions, far):
    """Equal hits of 9999 of 10000 rays, their distances and weights to 1e-4."""
    embree, tracer = Tracer(geometry), Tracer(geometry, card)
    assert embree.on_card is None and tracer.on_card
    expected, found = embree.closest(origins, directions), tracer.closest(origins, directions)
    agree = found.triangle == expected.triangle
    # Two triangles that meet in an edge are both right there.
    near = ~agree & (found.triangle >= 0) & (expected.triangle >= 0)
    near &= np.isclose(found.distance, expected.distance, rtol=1e-5)
    assert np.mean(agree | near) >= 0.9999 and np.mean(agree) >= 0.999
    hit = agree & (found.triangle >= 0)
    assert hit.mean() > 0.2
    np.testing.assert_allclose(found.distance[hit], expected.distance[hit], rtol=1e-4, atol=1e-5)
    wrong = np.abs(found.weights[hit] - expected.weights[hit]).max(-1)
    np.testing.assert_allclose(np.quantile(wrong, 0.999), 0, atol=1e-3)
    blocked = embree.occluded(origins, directions, far)
    assert np.mean(tracer.occluded(origins, directions, far) == blocked) >= 0.9999
    assert 0.01 < blocked.mean() < 0.999
    share = embree.transmittance(origins, directions, far)
    assert np.isclose(tracer.transmittance(origins, directions, far), share, atol=1e-4).mean() >= 0.9999
    return share


def test_a_soup_of_triangles_as_embree(card):
    vertices, triangles = soup(20_000, 1)
    n = len(triangles)
    mesh = Mesh("soup", vertices, triangles, np.zeros((n, 3, 3), np.float32), np.zeros(n, np.int32))
    as_embree(card, Geometry(shapes.scene([mesh])), *rays(40_000, 2))


def read(name, sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    _, core = preflight.inspected(bpy.context.scene, bpy.context.view_layer, ImageReader())
    return core


@pytest.mark.parametrize("name", ["cornell", "sunlit_room", "corridor", "emissive"])
def test_a_scene_as_embree(card, sample, name):
    core = read(name, sample)
    geometry = Geometry(core)
    origins, directions = camera_rays(replace(core.camera, resolution=(160, 120)))
    # From all over the scene too, in all directions.
    low, high = geometry.bounds
    more = rays(20_000, 5)
    more_origins = low + (high - low) * (more[0] + 0.5) / 2
    far = np.concatenate([np.full(len(origins), FAR), more[2] * np.linalg.norm(high - low) / 4]).astype(np.float32)
    origins = np.concatenate([origins, more_origins.astype(np.float32)])
    as_embree(card, geometry, origins, np.concatenate([directions, more[1]]), far)


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
    assert not gpu.numpy(gpu.run(through, start, unit(d), far, bvh)).any()


def test_surfaces_with_an_alpha_as_embree(card):
    """Sheets over each other: of a number, of textures, one that casts no shadow, in a box that stops everything."""
    rng = np.random.default_rng(1)
    bits = rng.integers(0, 256, (9, 13, 3), np.uint8)
    smooth = Texture("", srgb_to_linear(bits / 255).astype(np.float32), "MIRROR", "LINEAR", bits)
    steps = Texture("", (rng.random((20, 30, 1)) > 0.5) * np.ones(3, np.float32), "CLIP", "CLOSEST")
    white = np.ones(3, np.float32)
    alphas = [ColorSource(white), ColorSource(white / 3), ColorSource(white, smooth), ColorSource(white, steps),
              ColorSource(white)]  # fmt: skip
    meshes = [shapes.box(2)] + [shapes.plate(z, 1.5) for z in (-0.5, 0, 0.5, 1)]
    scene = shapes.scene(meshes)
    materials = tuple(replace(shapes.matte(), alpha=alpha) for alpha in alphas)
    instances = [replace(one, materials=(k,)) for k, one in enumerate(scene.instances)]
    instances[-1] = replace(instances[-1], casts=False)
    geometry = Geometry(replace(scene, materials=materials, instances=tuple(instances)))
    share = as_embree(card, geometry, *rays(20_000, 3, -1.9, 1.9))
    assert ((share > 0.01) & (share < 0.99)).mean() > 0.1
    assert not np.isin(Tracer(geometry, card).closest(*rays(5000, 4, -1.9, 1.9)[:2]).triangle, np.arange(18, 20)).any()


def test_nothing_is_seen_through_what_lies_on_something_solid(card):
    """A half clear plate in the plane of a solid one, at both sides of which others hang: as Embree, and nothing comes
    through."""
    alphas = [ColorSource(np.full(3, share, np.float32)) for share in (1, 0.5, 0.5)]
    scene = shapes.scene([shapes.plate(0, 1.5), shapes.plate(0, 1), shapes.plate(0.5, 1)])
    materials = tuple(replace(shapes.matte(), alpha=alpha) for alpha in alphas)
    instances = tuple(replace(one, materials=(k,)) for k, one in enumerate(scene.instances))
    geometry = Geometry(replace(scene, materials=materials, instances=instances))
    rng = np.random.default_rng(5)
    start = np.concatenate([rng.uniform(-0.9, 0.9, (5000, 2)), np.full((5000, 1), 1)], -1).astype(np.float32)
    target = np.concatenate([rng.uniform(-0.9, 0.9, (5000, 2)), np.full((5000, 1), -1)], -1).astype(np.float32)
    far = np.full(5000, 9, np.float32)
    for tracer in (Tracer(geometry), Tracer(geometry, card)):
        assert not tracer.transmittance(start, unit(target - start), far).any()
        assert not tracer.transmittance(target, unit(start - target), far).any()
        hits = tracer.closest(start, unit(target - start))
        assert 0.4 < np.isin(geometry.instance[hits.triangle], [2]).mean() < 0.6
        assert (hits.distance[geometry.instance[hits.triangle] != 2] >= 1).all()


def test_a_driver_in_software_leaves_rays_to_embree(gpu):
    if gpu.software:
        assert gpu_rays(Geometry(shapes.scene([shapes.plate(0, 1)])), gpu) is None


def test_more_triangles_than_the_card_may_hold_are_the_processors(card, monkeypatch, caplog):
    geometry = Geometry(shapes.scene([shapes.plate(0, 1)]))
    monkeypatch.setattr(card, "software", False)
    assert gpu_rays(geometry, card) and raster_of(geometry, np.arange(2), card)
    monkeypatch.setattr(card, "budget", 160)
    assert gpu_rays(geometry, card) is None and raster_of(geometry, np.arange(2), card) is None
    assert "rays are the processor's" in caplog.text and "pictures are traced" in caplog.text


def test_tiles_ask_the_card_too(card):
    tracer = Tracer(Geometry(shapes.scene([shapes.plate(0, 1)])), card)
    origins, directions, far = rays(1000, 1)
    expected = tracer.occluded(origins, directions, far)
    found = np.zeros(1000, bool)

    def tile(part):
        found[part] = tracer.occluded(origins[part], directions[part], far[part])

    finish(run(tile, slices(1000, 64)))
    assert np.array_equal(found, expected) and 0.01 < expected.mean() < 0.5


def test_rays_are_cut_to_what_the_card_may_hold(card, monkeypatch):
    tracer = Tracer(Geometry(shapes.scene([shapes.plate(0, 1)])), card)
    asked = rays(50_000, 1)
    expected = tracer.transmittance(*asked)
    monkeypatch.setattr(card, "budget", 0)
    assert card.array(np.zeros(1), 1).texture  # what was kept is gone
    monkeypatch.setattr(card, "budget", 1 << 20)
    card.peak = before = card.bytes
    assert np.array_equal(tracer.transmittance(*asked), expected)
    assert 0 < card.peak - before <= 1 << 20
