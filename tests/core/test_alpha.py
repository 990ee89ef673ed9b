# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surfaces that let light through, against closed forms."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import direct, rsm, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.scene import ColorSource, Environment, Texture
from gi_bake.gi_core.surfels import Surfels
from gi_bake.gi_core.trace import FAR, Tracer
from gi_bake.tests import shapes

SUN = shapes.lamp("SUN", 2.0, (0, 0, 5))
SKY = Environment(np.full(3, 2.0, np.float32))
CHECKER = ColorSource(
    np.ones(3, np.float32),
    Texture(
        "checker", np.repeat((np.indices((64, 64)).sum(0) % 2)[..., None], 3, 2).astype(np.float32), "REPEAT", "CLOSEST"
    ),
)


def alpha(value):
    return ColorSource(np.full(3, value, np.float32)) if np.isscalar(value) else value


def traced(sheets, lights=(), floor=5.0, sheet=20.0, emission=0.0, **more):
    """A floor at z = 0 and sheets above it, each of an alpha of its own, at z = 1, 2, 3 …"""
    meshes = [shapes.plate(0, floor)] + [shapes.plate(k + 1, sheet) for k in range(len(sheets))]
    scene = shapes.scene(meshes, lights, **more)
    materials = [shapes.matte()] + [replace(shapes.matte(0.5, emission), alpha=alpha(a)) for a in sheets]
    instances = tuple(replace(i, materials=(k,)) for k, i in enumerate(scene.instances))
    return Tracer(Geometry(replace(scene, materials=tuple(materials), instances=instances)))


def floor_points(n=4096, half=4.0):
    here = np.zeros((n, 3), np.float32)
    here[:, :2] = np.random.default_rng(1).uniform(-half, half, (n, 2))
    up = np.tile(np.float32([0, 0, 1]), (n, 1))
    return Surfels(here, up, up, 0 * here + np.float32(0.5), 0 * here, np.arange(n))


def rays_down(n=20000):
    origins = floor_points(n).position + np.float32([0, 0, 10])
    directions = np.random.default_rng(2).normal(0, 0.05, (n, 3)).astype(np.float32) - np.float32([0, 0, 1])
    return origins, directions / np.linalg.norm(directions, axis=1, keepdims=True)


def received(tracer, points, samples=16):
    lamps = tiles.finish(direct.lamps(tracer, points, samples, 0))
    return (lamps + tiles.finish(direct.surroundings(tracer, points, Samples(samples), 0)))[:, 0]


@pytest.mark.parametrize("light", ["sun", "sky"])
def test_a_checkered_sheet_halves_the_light_below(light):
    more = {"lights": [SUN]} if light == "sun" else {"environment": SKY}
    below = received(traced([CHECKER], sheet=200.0, **more), floor_points())
    assert np.isclose(below.mean(), (2 if light == "sun" else 2 * np.pi) / 2, rtol=0.03)
    if light == "sun":
        assert set(np.unique(below)) == {0, 2}  # each point has all of it or none


def test_alpha_0_is_as_if_nothing_were_there_and_alpha_1_as_if_it_had_none():
    points, (origins, directions) = floor_points(), rays_down()
    for value, sheets in ((0.0, []), (1.0, [1.0, 1.0])):
        with_alpha, without = (traced(s, [SUN], environment=SKY) for s in ([value, value], sheets))
        assert np.array_equal(received(with_alpha, points), received(without, points))
        found, expected = (t.closest(origins, directions) for t in (with_alpha, without))
        assert np.array_equal(found.triangle, expected.triangle)
        assert np.allclose(found.distance, expected.distance, rtol=1e-5)
    nearly = traced([0.999999, 0.999999], [SUN])
    assert received(nearly, points).max() < 1e-4


def test_sheets_multiply_and_rays_end_as_often_as_each_takes_its_light():
    tracer = traced([0.3, 0.6, CHECKER], [SUN])
    below = received(tracer, floor_points())
    assert np.allclose(np.unique(below), [0, 2 * 0.7 * 0.4])
    tracer = traced([0.3, 0.6], [SUN])
    assert np.allclose(received(tracer, floor_points()), 2 * 0.7 * 0.4)
    origins, directions = rays_down()
    hits = tracer.closest(origins, directions)
    ends = np.bincount(hits.triangle // 2 + 1, minlength=4)[1:] / (hits.triangle >= 0).sum()
    assert np.allclose(ends, [0.4 * 0.7, 0.3 * 1 - 0.3 * 0.6, 0.6], atol=0.01)
    hit = hits.triangle >= 0
    height = (origins[:, 2] + hits.distance * directions[:, 2])[hit]
    assert np.allclose(height, hits.triangle[hit] // 2, atol=1e-4)
    far = np.full(len(origins), FAR)
    without_floor = traced([0.3, 0.6], floor=1e-3)
    assert np.isclose(without_floor.occluded(origins, directions, far).mean(), 1 - 0.7 * 0.4, atol=0.01)
    assert np.allclose(without_floor.transmittance(origins, directions, far), 0.7 * 0.4)
    # Up to the lower sheet, which lies at 1, only the upper one counts.
    assert np.allclose(tracer.transmittance(origins, directions, np.full(len(origins), 8.5)), 0.4)


def test_many_sheets():
    tracer = traced([0.1] * 60, floor=1e-3)
    origins, directions = np.float32([[0.3, 0.2, 100]]), np.float32([[0, 0, -1]])
    assert np.isclose(tracer.transmittance(origins, directions, np.full(1, FAR))[0], 0.9**60, rtol=1e-4)


def test_a_ray_ends_at_the_same_place_whatever_is_traced_with_it():
    tracer = traced([0.5, CHECKER, 0.2])
    origins, directions = rays_down(1000)
    far, order = np.full(1000, FAR), np.random.default_rng(3).permutation(1000)[:300]
    assert np.array_equal(
        tracer.closest(origins, directions).triangle[order], tracer.closest(origins[order], directions[order]).triangle
    )
    blocked = tracer.occluded(origins, directions, far)
    assert np.array_equal(blocked[order], tracer.occluded(origins[order], directions[order], far[order]))


def test_scenes_without_alpha_do_not_look_at_it(monkeypatch):
    tracer = traced([1.0], [SUN])
    monkeypatch.setattr(tracer.geometry, "alpha", None)
    assert not tracer.geometry.clear.any()
    origins, directions = rays_down(100)
    tracer.closest(origins, directions)
    assert received(tracer, floor_points(10)).max() == 0


def test_what_is_not_solid_emits_and_reflects_less():
    solid = received(traced([1.0], emission=3.0, sheet=1.0), floor_points(64, 0.5), 1024)
    quarter = received(traced([0.25], emission=3.0, sheet=1.0), floor_points(64, 0.5), 1024)
    assert np.isclose(quarter.mean(), solid.mean() / 4, rtol=0.03)
    # A sun of 2 W/m² on 16 m² of sheet over a floor of 4 m², each of albedo ½.
    tracer = traced([0.25], [SUN], floor=1.0, sheet=2.0)
    lighting = tiles.finish(rsm.emit(tracer, floor_points(16, 0.5), RsmSettings(map_resolution=256)))
    height = lighting.reflected.position[:, 2]
    flux = [lighting.reflected.flux[np.abs(height - z) < 0.1, 0].sum() for z in (0, 1)]
    assert np.allclose(flux, [2 * 4 * 0.75 * 0.5, 2 * 16 * 0.25 * 0.5], rtol=0.03)


def test_the_skys_light_on_what_is_not_solid():
    """A sheet of alpha ¼ alone under an even sky gets π L from either side and sends half of a quarter on."""
    tracer = traced([0.25], floor=1e-3, sheet=1.0, environment=SKY)
    lighting = tiles.finish(rsm.emit(tracer, floor_points(16, 0.5), RsmSettings(pattern="all")))
    assert np.isclose(lighting.reflected.flux[:, 0].sum(), 2 * 4 * np.pi * 2 * 0.25 * 0.5, rtol=0.01)
