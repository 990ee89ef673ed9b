# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gathering from virtual point lights on the graphics card: its kernels, patterns and bounds, and a sample scene's."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon import preflight
from gi_bake.addon.read.images import ImageReader
from gi_bake.gi_core import rsm
from gi_bake.gi_core.gathering import Every, Strided
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.kernels.lattice import agreeing, mixed, rows_of
from gi_bake.gi_core.kernels.vpl_bump import bumped
from gi_bake.gi_core.kernels.vpl_gather import BOUNDS, added, chosen, unshadowed
from gi_bake.gi_core.rsm.disk import Disk
from gi_bake.gi_core.rsm.interpolation import interpolated_indirect
from gi_bake.gi_core.rsm.maps import Map
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.rsm.views import views
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.surfels import Surfels, from_camera
from gi_bake.gi_core.tiles import finish
from gi_bake.gi_core.trace import Tracer
from gi_bake.gi_core.vectors import normalize
from gi_bake.gi_core.vpls import Packed, Vpls
from gi_bake.tests import shapes


def unit(rng, n):
    v = rng.normal(size=(n, 3)).astype(np.float32)
    return v / np.maximum(np.linalg.norm(v, axis=-1, keepdims=True), 1e-6)


def surfels(n, seed=1):
    """Points in a cube, their places beyond what a float counts exactly."""
    rng = np.random.default_rng(seed)
    normal = unit(rng, n)
    position = rng.uniform(-1, 1, (n, 3)).astype(np.float32)
    return Surfels(position, normal, normal, 0 * normal, 0 * normal, 2**25 + 3 * np.arange(n))


def lights(n, seed=2):
    rng = np.random.default_rng(seed)
    position, area = rng.uniform(-1, 1, (n, 3)).astype(np.float32), rng.uniform(0.001, 0.1, n).astype(np.float32)
    flux = rng.random((n, 3), np.float32) * (rng.random((n, 1)) > 0.2)
    return Vpls(position, position, unit(rng, n), flux.astype(np.float32), area)


def disk(n, literal=False):
    """A pattern around projections into the map of a sun above, with holes in it."""
    side = 16
    view = views(shapes.lamp("SUN"), np.float64([[-1, -1, -1], [1, 1, 1]]), side)[0]
    seen = np.flatnonzero(np.random.default_rng(3).random(side * side) > 0.1)
    here = replace(surfels(len(seen)), place=seen)
    return Disk.of(Map(here, 0 * here.position, 0 * seen, 0 * seen, view), 0.4, Samples(n), literal, 5)


PATTERNS = {
    "every": Every(256),
    "strided": Strided(24, 256, 0.25, 3),
    "more than there are": Strided(504, 256, 0.0, -1),
    "disk": disk(24),
    "literal disk": disk(24, True),
}


def agrees(gpu, here, vpls, pattern, bound="disc", candidates=1, area=None):
    """The same lights by the same weights, but for the few that rounding decides about."""
    packed = Packed.of(vpls, area)
    arguments = here, packed, pattern, bound, candidates
    index, weight = np.moveaxis(chosen(*arguments), -1, 0)
    found_index, found_weight = np.moveaxis(gpu.numpy(gpu.run(chosen, *arguments)), -1, 0)
    assert found_index.shape == index.shape == (pattern.lights // candidates, len(here))
    same = found_index == index
    assert np.count_nonzero(~same) <= 1e-3 * same.size
    scale = np.abs(weight).max(initial=0)
    np.testing.assert_allclose(found_weight[same], weight[same], rtol=1e-4, atol=1e-5 * scale)
    # Sums in another order: 1e-3. Of points all of whose lights are the same.
    row = same.all(0)
    light = unshadowed(*arguments)
    found = gpu.numpy(gpu.run(unshadowed, *arguments))
    assert found.shape == light.shape and found.dtype == np.float32
    np.testing.assert_allclose(found[row], light[row], rtol=1e-3, atol=1e-5 * light.max(initial=0))
    assert not len(here) or row.mean() > 0.9


@pytest.mark.parametrize("pattern", PATTERNS)
@pytest.mark.parametrize("bound", BOUNDS)
def test_patterns_and_bounds(gpu, pattern, bound):
    agrees(gpu, surfels(333), lights(256), PATTERNS[pattern], bound)


@pytest.mark.parametrize("n", [0, 1, 333])
def test_relief(same, n):
    here, vpls = surfels(n), Packed.of(lights(256))
    picked = chosen(here, vpls, PATTERNS["strided"])
    mesh_normal = normalize(here.normal + np.random.default_rng(3).normal(0, 0.4, (n, 3))).astype(np.float32)
    same(bumped, picked, here.position, here.normal, mesh_normal, vpls.at)


@pytest.mark.parametrize("candidates", [2, 4, 8])
@pytest.mark.parametrize("pattern", ["strided", "more than there are", "disk"])
def test_one_of_several_candidates(gpu, pattern, candidates):
    agrees(gpu, surfels(333), lights(256), PATTERNS[pattern], "geometry", candidates, area=0.05)


@pytest.mark.parametrize("n", [0, 1, 63, 64, 65, 4099])
@pytest.mark.parametrize("pattern, candidates", [("every", 1), ("strided", 1), ("more than there are", 1),
                                                 ("strided", 4), ("disk", 1)])  # fmt: skip
def test_numbers_of_points(gpu, n, pattern, candidates):
    agrees(gpu, surfels(n, seed=n), lights(256), PATTERNS[pattern], candidates=candidates)


def test_a_single_light(gpu):
    agrees(gpu, surfels(70), lights(1), Every(1))
    agrees(gpu, surfels(70), lights(1), Strided(8, 1, 0.5, 1), candidates=4)


@pytest.mark.parametrize("pattern", [Every(70_000), Strided(70_000, 500, 0.5, 1), Strided(70_000, 90_000, 0.5, 1)])
def test_more_lights_than_a_loop_has_turns(gpu, pattern):
    """Mesa's driver in software leaves loops after 65535 turns."""
    vpls = lights(pattern.count if isinstance(pattern, Strided) else pattern.lights)
    agrees(gpu, surfels(9), vpls, pattern)


def test_more_weights_than_a_loop_has_turns(same):
    rng = np.random.default_rng(1)
    picked = np.stack([rng.integers(0, 50, (70_000, 3)), rng.random((70_000, 3))], -1).astype(np.float32)
    same(added, picked, rng.random((50, 3), np.float32))


@pytest.mark.parametrize("n", [0, 1, 65, 1000])
def test_weighted_lights_are_added(same, n):
    rng = np.random.default_rng(n)
    picked = np.stack([rng.integers(0, 50, (7, n)), rng.random((7, n))], -1).astype(np.float32)
    same(added, picked, rng.random((50, 3), np.float32))


def pixels(width, height, step, seed=1):
    """Arguments of `agreeing` for a bumpy surface with holes, its first rows missing."""
    rng = np.random.default_rng(seed)
    place = np.flatnonzero(rng.random(width * height) > 0.1)
    place = place[place >= 3 * width]
    position = np.stack([place % width, place // width, rng.random(len(place))], -1).astype(np.float32)
    rough = np.where(rng.random((len(place), 1)) > 0.2, 0.1, 0.7)
    normal = (unit(rng, len(place)) * rough + [0, 0, 1]).astype(np.float32)
    size = width, height
    return place, position, normal, np.full(len(place), step, np.float32), rows_of(place, size, step), size, step


@pytest.mark.parametrize("width, height, step", [(70, 33, 4), (129, 64, 2), (5, 9, 8), (1, 4, 2), (3, 3, 4)])
def test_agreement_with_a_lattice(gpu, same, width, height, step):
    arguments = pixels(width, height, step)
    same(agreeing, *arguments)
    neighbours, weights, kind = agreeing(*arguments)
    assert width < 70 or set(kind) == {0, 1, 2}
    light = np.random.default_rng(2).random((len(kind), 3), np.float32)
    same(mixed, light, neighbours, weights)


@pytest.fixture(scope="module")
def seen(sample):
    """What the camera of a sample scene sees, by its name: a tracer, 48 × 48 surfels, the camera."""

    def see(name):
        bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
        _, core = preflight.inspected(bpy.context.scene, bpy.context.view_layer, ImageReader())
        tracer = Tracer(Geometry(core))
        camera = replace(core.camera, resolution=(48, 48))
        return tracer, from_camera(tracer, camera), camera

    return see


@pytest.mark.parametrize("name", ["cornell", "sunlit_room"])
@pytest.mark.parametrize("pattern", ["flux", "disk", "all"])
@pytest.mark.parametrize("visibility", [True, False])
def test_the_light_of_a_scene(gpu, seen, name, pattern, visibility):
    tracer, here, _ = seen(name)
    settings = RsmSettings(pattern=pattern, samples=16, map_resolution=32, visibility=visibility)
    lighting = finish(rsm.emit(tracer, here, settings))
    expected = finish(rsm.indirect(tracer, here, lighting, settings))
    tracer.device = gpu
    found = finish(rsm.indirect(tracer, here, lighting, settings))
    assert expected.mean() > 0.01
    # Points with a light that rounding decides about are few.
    far = np.abs(found - expected) > 1e-3 * (expected + expected.mean())
    assert far.any(-1).mean() < 0.01
    assert np.mean((found - expected) ** 2 / (expected**2 + expected.mean() ** 2)) < 1e-5


def test_an_interpolated_image(gpu, seen):
    tracer, here, camera = seen("cornell")
    settings = RsmSettings(samples=16, map_resolution=32, interpolation=4)
    lighting = finish(rsm.emit(tracer, here, settings))
    expected, share = finish(interpolated_indirect(tracer, here, lighting, settings, camera, 1))
    tracer.device = gpu
    found, found_share = finish(interpolated_indirect(tracer, here, lighting, settings, camera, 1))
    assert 0.3 < share < 0.95 and np.isclose(share, found_share, atol=2e-3)
    assert np.mean((found - expected) ** 2 / (expected**2 + expected.mean() ** 2)) < 1e-5
