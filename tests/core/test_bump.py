# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Normals that materials give, and what relief hides of light, against closed forms and integrals."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import bump, direct, rsm, surfels, tiles
from gi_bake.gi_core.gathering import Every, gather
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.scene import Environment, Instance, NormalSource
from gi_bake.gi_core.surfels import Surfels
from gi_bake.gi_core.trace import Tracer
from gi_bake.gi_core.vpls import Vpls
from gi_bake.tests import shapes

UP = np.float32([0, 0, 1])


def tilted(degrees):
    return np.float32([np.sin(np.radians(degrees)), 0, np.cos(np.radians(degrees))])


def paper(tilt, slant):
    """The published term by angles [°]: Smith's shadowing of a GGX surface of α² = tan²δ / 8, at most 1."""
    width = min(np.tan(np.radians(tilt)) ** 2 / 8, 1)
    return 2 / (1 + np.sqrt(1 + width * np.tan(np.radians(slant)) ** 2))


def total(tilt, grid=1200):
    """∫ cos(n, ω) G dω over the hemisphere of the mesh, by a grid."""
    z, angle = np.meshgrid((np.arange(grid) + 0.5) / grid, (np.arange(grid) + 0.5) * 2 * np.pi / grid)
    ways = np.stack([np.sqrt(1 - z * z) * np.cos(angle), np.sqrt(1 - z * z) * np.sin(angle), z], -1).reshape(-1, 3)
    slant = np.degrees(np.arccos(ways[:, 2]))
    return np.mean(np.maximum(ways @ tilted(tilt), 0) * paper(tilt, slant)) * 2 * np.pi


def bumpy(n, tilt):
    """Points at the origin of a floor whose normals are tilted."""
    here, up, normal = np.zeros((n, 3), np.float32), np.tile(UP, (n, 1)), np.tile(tilted(tilt), (n, 1))
    return Surfels(here, normal, up, 0 * here, 0 * here, np.arange(n), up)


def test_shadowing_is_the_published_term():
    for tilt in (5, 30, 70, 85):
        for slant in (-80, -20, 0, 45, 80, 89):
            found = bump.shadowing(UP[None], tilted(tilt)[None], tilted(slant)[None])
            assert np.isclose(found[0], paper(tilt, slant), rtol=1e-4)
    assert bump.shadowing(UP[None], UP[None], tilted(80)[None])[0] == 1
    assert not bump.shadowing(UP[None], tilted(40)[None], tilted(95)[None]).any()
    assert not bump.shadowing(UP[None], tilted(100)[None], tilted(60)[None]).any()


@pytest.mark.parametrize("tilt", [0, 20, 45, 75])
def test_the_mean_of_even_light(tilt):
    visible = np.pi * (1 + np.cos(np.radians(tilt))) / 2
    assert np.isclose(bump.mean_shadowing(UP[None], tilted(tilt)[None])[0], total(tilt) / visible, rtol=5e-3)


@pytest.mark.parametrize("tilt", [20, 60])
def test_a_sky_on_relief(tilt):
    tracer = shapes.tracer([shapes.plate(0, 1)], environment=Environment(np.ones(3, np.float32)))
    found = direct.from_surroundings(tracer, bumpy(64, tilt), Samples(1024), 0)
    assert np.isclose(found.mean(), total(tilt), rtol=3e-3)


@pytest.mark.parametrize("visibility", [True, False])
@pytest.mark.parametrize("slant", [30, 70, -40])
def test_a_virtual_light_on_relief(visibility, slant):
    tracer = shapes.tracer([shapes.plate(-1, 1)])
    at = (10 * tilted(slant))[None]
    light = Vpls(at, at, -at / 10, np.full((1, 3), 7, np.float32), np.full(1, 1e-4, np.float32))
    found = tiles.finish(gather(tracer, bumpy(5, 35), light, Every(1), visibility))
    expected = 7 / np.pi / 100 * max(np.cos(np.radians(slant - 35)), 0) * paper(35, slant)
    np.testing.assert_allclose(found, expected, rtol=1e-3, atol=1e-9)


def mapped(matrix, normal=None):
    """A floor of a material with a normal of its own, one of a matrix."""
    material = replace(shapes.matte(), normal=None if normal is None else NormalSource(np.float32(normal)))
    made = shapes.scene([shapes.plate(0, 1)], [shapes.lamp("SUN", 2.0, (0, 0, 5))], material)
    return Tracer(Geometry(replace(made, instances=(Instance("plate", 0, matrix, (0,)),))))


@pytest.mark.parametrize("scale", [(1, 1, 1), (2, 0.5, 3), (-1, 1, 1), (-2, 0.5, -1)])
def test_a_normal_goes_with_its_object(scale):
    """By the inverse transpose; a mirrored object shows the mirror image, on the side that its mesh shows."""
    local = np.array([0.5, -0.2, 0.8])
    turn = np.array([[0.0, 0, 1], [1, 0, 0], [0, 1, 0]])
    matrix = np.eye(4)
    matrix[:3, :3] = turn @ np.diag(scale)
    geometry = mapped(matrix, local).geometry
    weights = np.full((2, 3), 1 / 3, np.float32)
    found = surfels.at(geometry, np.arange(2), weights, np.arange(2))
    expected = turn @ (local / scale)
    np.testing.assert_allclose(found.normal, [expected / np.linalg.norm(expected)] * 2, atol=1e-6)
    side = turn @ (0, 0, np.sign(scale[2]))
    np.testing.assert_allclose(found.smooth, [side] * 2, atol=1e-6)
    np.testing.assert_allclose(found.face, found.smooth, atol=1e-6)
    behind = surfels.at(geometry, np.arange(2), weights, np.arange(2), np.tile(np.float32(-side), (2, 1)))
    np.testing.assert_array_equal(behind.normal, -found.normal)
    np.testing.assert_array_equal(behind.smooth, -found.smooth)


def test_without_maps_nothing_is_carried_along():
    flat = mapped(np.eye(4)).geometry
    here = surfels.at(flat, np.arange(2), np.full((2, 3), 1 / 3, np.float32), np.arange(2))
    parts = here, here[:1], here.turned(np.array([True, False])), Surfels.concatenate([here, here[1:]])
    assert not any(part.is_bumpy for part in parts)
    relief = bumpy(3, 20)
    parts = relief, relief[1:], relief.turned(np.ones(3, bool)), Surfels.concatenate([here, relief])
    assert all(part.is_bumpy and len(part.smooth) == len(part) for part in parts)


def test_vertices_have_their_meshs_normals():
    geometry = mapped(np.eye(4), (0.6, 0, 0.8)).geometry
    corners = surfels.from_corners(geometry, "plate")
    np.testing.assert_allclose(corners.normal, np.tile(UP, (len(corners), 1)))
    texels, _ = surfels.from_texels(geometry, "plate", "", (4, 4))
    np.testing.assert_allclose(texels.normal, np.tile(np.float32([0.6, 0, 0.8]), (16, 1)), atol=1e-6)


def test_what_relief_sends_on():
    """A sunlit floor whose normal is tilted by 40°, seen from a point above: by what its normal takes, but about the
    floor's own normal."""
    at, down = np.tile(UP, (16, 1)), np.tile(-UP, (16, 1))
    here = Surfels(at, down, down, 0 * at, 0 * at, np.arange(16))
    found = {}
    for normal in (None, tilted(40)):
        tracer = mapped(np.eye(4), normal)
        settings = RsmSettings(samples=256, map_resolution=64, bounces=1)
        lighting = tiles.finish(rsm.emit(tracer, here, settings))
        found[normal is None] = tiles.finish(rsm.indirect(tracer, here, lighting, settings)).mean()
    assert np.isclose(found[False] / found[True], np.cos(np.radians(40)), rtol=0.01)
