# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures drawn on the graphics card: as the definition has them, as Embree's rays find them, as bakes use them."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.addon.read import read_scene
from gi_bake.gi_core import raster, shadow_maps, tiles
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_raster import Raster, raster_of
from gi_bake.gi_core.kernels.raster import MISS
from gi_bake.gi_core.kernels.raster import raster as drawn
from gi_bake.gi_core.kernels.shadow_map import shadow_map
from gi_bake.gi_core.metrics import relmse
from gi_bake.gi_core.receivers import cut, of_camera
from gi_bake.gi_core.rsm import maps
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.rsm.views import texel_rays, views
from gi_bake.gi_core.scene import Camera, ColorSource, Mesh, Texture
from gi_bake.gi_core.ssgi.frame import g_buffer
from gi_bake.gi_core.ssgi.screen import Screen
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.surfels import camera_rays, from_camera
from gi_bake.gi_core.trace import FAR, Tracer
from gi_bake.tests import shapes


def soup(n, seed):
    """Triangles of all sizes about the unit cube."""
    rng = np.random.default_rng(seed)
    corners = rng.random((n, 1, 3)) + 10.0 ** rng.uniform(-2.5, 0.0, (n, 1, 1)) * rng.normal(size=(n, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * n, dtype=np.int32).reshape(-1, 3)


def as_mesh(vertices, corner):
    n = len(corner)
    return Mesh("soup", vertices, corner, np.zeros((n, 3, 3), np.float32), np.zeros(n, np.int32))


def camera(seed, kind="PERSPECTIVE", resolution=(61, 37)) -> Camera:
    """Somewhere among the triangles, turned anyhow."""
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix[:3, :3] *= np.linalg.det(matrix[:3, :3])
    matrix[:3, 3] = rng.random(3)
    return Camera(kind, matrix, (-0.9, 0.4, -0.3, 0.8), resolution, (0.05, 100.0))


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
@pytest.mark.parametrize("resolution", [(61, 37), (64, 64), (1, 1), (2100, 3)])
@pytest.mark.parametrize("triangles", [0, 1, 300])
def test_the_definition(gpu, same, kind, resolution, triangles):
    eye = camera(triangles, kind, resolution)
    vertices, corner = soup(triangles, 2)
    corners = [np.ascontiguousarray(vertices[corner[:, k]]) for k in range(3)]
    which, rectangle = raster.covered(raster.of_camera(eye), vertices, corner)
    origins, directions = camera_rays(eye)
    same(drawn, origins, directions, resolution[0], corners, which, rectangle, np.float32(50))


def test_the_first_of_equally_near_triangles(gpu, same):
    vertices, corner = np.float32([[-9, -9, -2], [9, -9, -2], [0, 9, -2]] * 3), np.arange(9).reshape(3, 3)
    eye = replace(camera(0), matrix=np.eye(4))
    corners = [np.ascontiguousarray(vertices[corner[:, k]]) for k in range(3)]
    which, rectangle = raster.covered(raster.of_camera(eye), vertices, corner)
    same(drawn, *camera_rays(eye), 61, corners, which[::-1].copy(), rectangle, np.float32(50))
    first = gpu.numpy(gpu.run(drawn, *camera_rays(eye), 61, corners, which, rectangle, np.float32(50)))
    assert (first[:, 0] == 0).all()


def as_rays(tracer, device, grid, origins, directions):
    """What is drawn is what Embree finds but on a few edges: positions to 1e-4, triangles in 9990 of 10000 pixels, and
    in 9999 of them but where two are equally near."""
    tracer.raster = Raster(tracer.geometry, tracer._solid_index, device)
    found = tiles.finish(tracer.drawn(grid, origins, directions))
    expected = tracer._solid.closest(origins, directions, np.full(len(origins), FAR, np.float32))
    agree = found.triangle == expected.triangle
    near = ~agree & (found.triangle >= 0) & (expected.triangle >= 0)
    near &= np.isclose(found.distance, expected.distance, rtol=1e-5)
    assert np.mean(agree | near) >= 0.9999 and np.mean(agree) >= 0.999
    hit = np.flatnonzero(agree & (found.triangle >= 0))
    at, there = (tracer.geometry.position(h.triangle[hit], h.weights[hit]) for h in (found, expected))
    assert np.abs(at - there).max(initial=0) <= 1e-4 * np.abs(there - grid.origin).max(initial=1)
    np.testing.assert_allclose(found.distance[hit], expected.distance[hit], rtol=1e-4, atol=1e-6)
    np.testing.assert_array_equal(found.distance[found.triangle < 0], FAR)
    return len(hit) / len(origins)


@pytest.fixture(scope="module")
def scenes(sample):
    """Sample scenes by their names, read once."""
    found = {}
    for name in ("cornell", "pan", "sunlit_room"):
        bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
        found[name] = read_scene(bpy.context.scene, bpy.context.view_layer)
    return found


@pytest.mark.parametrize("name", ["cornell", "pan", "sunlit_room"])
@pytest.mark.parametrize("device", ["numpy", "gpu"])
def test_a_scene_as_its_camera_sees_it(gpu, scenes, name, device):
    core = scenes[name]
    eye, tracer = replace(core.camera, resolution=(97, 63)), Tracer(Geometry(core))
    parallel = replace(eye, kind="ORTHOGRAPHIC", window=(-3, 2, -1, 2))
    for one, subpixels in ((eye, 2), (parallel, 1)):
        grid, rays = raster.of_camera(one, subpixels), camera_rays(one, subpixels)
        assert as_rays(tracer, {"numpy": NUMPY, "gpu": gpu}[device], grid, *rays) > 0.2


@pytest.mark.parametrize("lamp", [
    shapes.lamp("SUN", angle=0.01), shapes.lamp("SPOT", at=(0, 0, 1.7), spot_angle=1.5),
    shapes.lamp("POINT", at=(0.1, 0.2, 1.2), radius=0.1),
], ids=["sun", "spot", "soft point"])  # fmt: skip
def test_a_scene_as_a_lamp_sees_it(gpu, scenes, lamp):
    tracer = Tracer(Geometry(scenes["cornell"]))
    for k, view in enumerate(views(lamp, tracer.geometry.bounds, 100)):
        rays = texel_rays(view, k)
        assert as_rays(tracer, gpu, view.grid, rays.origin, rays.direction) > 0.2


def test_a_soup_of_triangles_around_the_camera(gpu):
    eye = camera(8, resolution=(128, 64))
    tracer = Tracer(Geometry(shapes.scene([as_mesh(*soup(300, 3))])))
    assert as_rays(tracer, gpu, raster.of_camera(eye), *camera_rays(eye)) > 0.9


def with_raster(geometry, device):
    """A tracer that draws pictures on a device."""
    tracer = Tracer(geometry)
    tracer.raster = Raster(geometry, tracer._solid_index, device)
    return tracer


def cut_out():
    """A plate with holes before one that is half clear, before a solid one; two of one mesh, mirrored and turned."""
    texture = Texture("holes", np.repeat(np.indices((8, 8)).sum(0)[..., None] % 2, 3, 2).astype(np.float32), "REPEAT",
                      "CLOSEST")  # fmt: skip
    holes = replace(shapes.matte(), alpha=ColorSource(np.ones(3, np.float32), texture))
    half = replace(shapes.matte(), alpha=ColorSource(np.full(3, 0.5, np.float32)))
    scene = shapes.scene([shapes.plate(z, 2.0) for z in (-2, -3, -4)] + [shapes.box(0.3)])
    instances = [replace(i, materials=(m,)) for i, m in zip(scene.instances, (1, 2, 0, 0))]
    turned = np.array([[-1, 0.2, 0, 1], [0, 1, 0, 0.5], [0, 0.4, 1, -3.5], [0, 0, 0, 1]])
    instances.append(replace(instances[-1], matrix=turned, is_copy=True))
    instances[-2] = replace(instances[-2], casts=False)
    return replace(scene, materials=(shapes.matte(), holes, half), instances=tuple(instances))


EYE = Camera("PERSPECTIVE", np.eye(4), (-0.7, 0.7, -0.5, 0.5), (70, 50), (1e-3, 3.9))


def test_a_g_buffer_with_surfaces_cut_out(gpu):
    """Alpha, instances, both sides of faces, the far plane: all that follows on what is drawn is what it was."""
    geometry = Geometry(cut_out())
    expected = tiles.finish(g_buffer(Tracer(geometry), Screen(EYE)))
    found = tiles.finish(g_buffer(with_raster(geometry, gpu), Screen(EYE)))
    np.testing.assert_array_equal(found.triangle, expected.triangle)
    seen = np.unique(geometry.instance[expected.triangle[expected.surface]])
    assert set(seen) == {0, 1, 4} and expected.surface.mean() < 0.99
    for name in ("position", "normal", "face", "albedo", "weights"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-4, err_msg=name)


def test_a_tile_of_a_camera_however_it_is_cut(gpu):
    geometry = Geometry(cut_out())
    whole = Tracer(geometry)
    expected = [tiles.finish(t.points()) for t in cut([of_camera(whole, EYE, 2)], 1 << 20, 0)]
    parts = [tiles.finish(t.points()) for t in cut([of_camera(with_raster(geometry, gpu), EYE, 2)], 3000, 1)]
    assert len(expected) == 1 and len(parts) > 3
    found = [tiles.finish(t.points()) for t in cut([of_camera(with_raster(geometry, gpu), EYE, 2)], 1 << 20, 0)]
    np.testing.assert_array_equal(found[0][1], expected[0][1])
    np.testing.assert_allclose(found[0][0].position, expected[0][0].position, atol=1e-4)
    rows = np.unique(np.concatenate([surfels.place for surfels, _, _ in parts]))
    np.testing.assert_array_equal(rows, expected[0][0].place)


def test_maps_of_lamps(gpu, scenes):
    geometry = Geometry(scenes["cornell"])
    lamps = [shapes.lamp("SPOT", 5, (0, 0, 1.7), spot_angle=1.5), shapes.lamp("AREA", 5, (0, 0, 1.8)),
             shapes.lamp("POINT", 5, (0.3, 0, 1), radius=0.1)]  # fmt: skip
    every = [view for lamp in lamps for view in views(lamp, geometry.bounds, 40)]
    expected = tiles.finish(maps.render(Tracer(geometry), every, 3))
    found = tiles.finish(maps.render(with_raster(geometry, gpu), every, 3))
    assert len(found) == len(expected) == 1 + 16 + 6
    for one, other, view in zip(found, expected, every):
        assert one.view is view
        np.testing.assert_array_equal(one.surfels.place, other.surfels.place)
        np.testing.assert_allclose(one.surfels.position, other.surfels.position, atol=1e-4)
        np.testing.assert_allclose(one.flux, other.flux, atol=1e-4 * other.flux.max(initial=0))


@pytest.mark.parametrize("n", [0, 1, 65, 1000])
@pytest.mark.parametrize("lamp", [shapes.lamp("SUN"), shapes.lamp("SPOT", at=(0.5, 0.5, 2)),
                                  shapes.lamp("POINT", at=(0.4, 0.6, 0.3))], ids=["sun", "spot", "point"])  # fmt: skip
def test_points_in_shadow_maps(gpu, same, n, lamp):
    rng = np.random.default_rng(n)
    position, face = rng.random((n, 3), np.float32), rng.normal(size=(n, 3))
    face = (face / np.linalg.norm(face, axis=-1, keepdims=True)).astype(np.float32)
    lit = np.where(rng.random(n) < 0.8, -1, 0.5).astype(np.float32)
    for view in views(lamp, np.float32([[0, 0, 0], [1, 1, 1]]), 13):
        distance = rng.uniform(0, 2, view.resolution**2).astype(np.float32)
        same(shadow_map, lit, position, face, distance, view.grid, 0.1)


def test_shadow_maps_of_a_scene(gpu, scenes):
    """Light by maps that are drawn and looked up on the card is that by maps of Embree's rays looked up in numpy."""
    for name in ("cornell", "sunlit_room"):
        geometry = Geometry(scenes[name])
        points = from_camera(Tracer(geometry), replace(scenes[name].camera, resolution=(48, 32)))
        on_card = with_raster(geometry, gpu)
        on_card.device = gpu
        expected, found = (tiles.finish(shadow_maps.lamps(t, points, 4, 0, 64)) for t in (Tracer(geometry), on_card))
        assert expected.mean() > 0.01 and relmse(found, expected) <= 1e-5


def test_nothing_to_see(gpu):
    tracer = with_raster(Geometry(shapes.scene([shapes.plate(5, 1)])), gpu)
    hits = tiles.finish(tracer.drawn(raster.of_camera(EYE), *camera_rays(EYE)))
    assert (hits.triangle == -1).all() and (hits.distance == MISS).all() and not hits.weights.any()
    assert raster_of(Geometry(shapes.scene([])), np.zeros(0, int), gpu) is None
    assert not tiles.finish(g_buffer(Tracer(Geometry(shapes.scene([])), gpu), Screen(EYE))).surface.any()


def test_what_lies_in_many_layers_is_traced(gpu):
    vertices, corner = soup(3000, 1)
    tracer = with_raster(Geometry(shapes.scene([as_mesh(vertices * 2 - 1, corner)])), gpu)
    assert tiles.finish(tracer.drawn(raster.of_camera(EYE), *camera_rays(EYE))) is None
    assert tiles.finish(g_buffer(tracer, Screen(EYE))).surface.any()


def test_only_the_main_thread_draws(gpu):
    tracer = with_raster(Geometry(cut_out()), gpu)
    with ThreadPoolExecutor(1) as pool:
        work = pool.submit(lambda: tiles.finish(tracer.drawn(raster.of_camera(EYE), *camera_rays(EYE))))
        assert work.result() is None


def test_a_driver_in_software_leaves_pictures_to_embree(gpu):
    geometry = Geometry(cut_out())
    assert (raster_of(geometry, np.arange(4), gpu) is None) == gpu.software
    assert Tracer(geometry).raster is None


def test_draws_are_cut_and_cancelled(gpu, scenes, monkeypatch):
    tracer = with_raster(Geometry(scenes["cornell"]), gpu)
    eye = replace(scenes["cornell"].camera, resolution=(50, 40))
    whole = tiles.finish(tracer.drawn(raster.of_camera(eye), *camera_rays(eye)))
    monkeypatch.setattr("gi_bake.gi_core.device._DISPATCH", 1e-12)  # a triangle at a time
    work, shares = tracer.drawn(raster.of_camera(eye), *camera_rays(eye)), []
    while True:
        try:
            shares.append(next(work))
        except StopIteration as stop:
            part = stop.value
            break
    assert len(shares) > 10
    np.testing.assert_array_equal(part.triangle, whole.triangle)
    monkeypatch.setattr("gi_bake.gi_core.device._DISPATCH", 1e3)
    monkeypatch.setattr("gi_bake.gi_core.gpu_draw._MOST", 4)
    part = tiles.finish(tracer.drawn(raster.of_camera(eye), *camera_rays(eye)))
    np.testing.assert_array_equal(part.triangle, whole.triangle)
    work = tracer.drawn(raster.of_camera(eye), *camera_rays(eye))
    next(work)
    work.close()
    assert len(list(gpu._done())) == 1


def test_textures_of_pictures_are_given_back(gpu):
    tracer = with_raster(Geometry(cut_out()), gpu)
    tiles.finish(tracer.drawn(raster.of_camera(EYE), *camera_rays(EYE)))
    before = gpu.bytes
    for _ in range(3):
        tiles.finish(tracer.drawn(raster.of_camera(EYE), *camera_rays(EYE)))
    assert gpu.bytes == before


RSM = RsmSettings(samples=16, map_resolution=64, light_samples=4, denoise="none")
SCREEN = SsgiSettings(mode="screen_space", fallback="none", samples=4, frames=1, light_samples=4)


@pytest.mark.parametrize("name, method, settings", [
    ("cornell", "rsm", RSM), ("pan", "rsm", replace(RSM, pattern="disk")), ("sunlit_room", "rsm", RSM),
    ("cornell", "ssgi", SCREEN), ("pan", "ssgi", SCREEN),
    ("cornell", "rsm", replace(RSM, shadow_map_resolution=64)),
])  # fmt: skip
def test_a_bake_as_the_processor_has_it(gpu, sample, monkeypatch, name, method, settings):
    """As a card that is one has it: pictures are drawn."""
    drawings = []

    def anywhere(geometry, index, device):
        if device is gpu:
            drawings.append(Raster(geometry, index, gpu))
            return drawings[-1]

    monkeypatch.setattr("gi_bake.gi_core.trace.raster_of", anywhere)
    draw, count = type(gpu).draw, []
    monkeypatch.setattr(type(gpu), "draw", lambda self, *a: count.append(1) or draw(self, *a))
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    found = []
    for device in ("cpu", "gpu"):
        job = Job(method, resolution=48, settings=replace(settings, device=device))
        found.append(tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job)).layers)
    assert len(drawings) == 1 and count
    for layer in ("Diffuse Indirect", "Diffuse Direct", "Combined"):
        expected, got = (one[layer].astype(np.float64) for one in found)
        assert expected.mean() > 1e-3 and relmse(got, expected) <= 1e-5, layer
