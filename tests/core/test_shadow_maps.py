# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direct light by shadow maps: against closed forms where they are exact, and against rays where they are not."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import direct, shadow_maps, tiles
from gi_bake.gi_core.environment import Environment
from gi_bake.gi_core.scene import ColorSource
from gi_bake.gi_core.surfels import Surfels
from gi_bake.tests import shapes

FLOOR, SHEET = shapes.plate(0, 4.0, name="floor"), shapes.plate(1, 0.5, name="sheet")


def on_floor(n=61, half=2.0) -> Surfels:
    """A row of points through the middle and a square of others."""
    rng = np.random.default_rng(1)
    here = np.zeros((n * n, 3), np.float32)
    here[:, :2] = rng.uniform(-half, half, (n * n, 2))
    up = np.tile(np.float32([0, 0, 1]), (n * n, 1))
    return Surfels(here, up, up, 0 * here + np.float32(0.5), 0 * here, np.arange(n * n))


def light_of(tracer, points, resolution, samples=16):
    return tiles.finish(shadow_maps.lamps(tracer, points, samples, 3, resolution))[:, 0]


def slanted(lamp, angle):
    matrix = lamp.matrix.copy()
    c, s = np.cos(angle), np.sin(angle)
    matrix[:3, :3] = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]]) @ matrix[:3, :3]
    return replace(lamp, matrix=matrix)


HARD = {
    "point": shapes.lamp("POINT", 100, (0.3, -0.2, 3)),
    "spot": shapes.lamp("SPOT", 100, (0.3, -0.2, 3), spot_angle=1.9, spot_blend=0.2),
    "sun": shapes.lamp("SUN", 2, (0, 0, 5)),
    "low sun": slanted(shapes.lamp("SUN", 2, (0, 0, 5)), 1.0),
}


@pytest.mark.parametrize("name", HARD)
@pytest.mark.parametrize("resolution", [16, 200])
def test_a_surface_does_not_shade_itself(name, resolution):
    """Exactly: not one point of a plain is darker than without shadows, however coarse the map is."""
    points = on_floor()
    tracer = shapes.tracer([FLOOR], [HARD[name]])
    free = direct.from_lamp(tracer, points, replace(HARD[name], shadow=False), 1, 0)[:, 0]
    np.testing.assert_allclose(light_of(tracer, points, resolution), free, rtol=1e-5)
    assert free.mean() > 0.1


@pytest.mark.parametrize("name", HARD)
def test_the_edge_of_a_hard_shadow(name):
    """Rays and maps differ within two texels of the shadow's edge and nowhere else."""
    points, resolution = on_floor(), 256
    tracer = shapes.tracer([FLOOR, SHEET], [HARD[name]])
    exact = tiles.finish(direct.lamps(tracer, points, 1, 0))[:, 0]
    found = light_of(tracer, points, resolution)
    free = direct.from_lamp(tracer, points, replace(HARD[name], shadow=False), 1, 0)[:, 0]
    assert 0.01 < np.mean((exact == 0) & (free > 0)) < 0.6
    # The sheet's shadow on the floor, by hand: points go to the sheet's plane along the light.
    lamp = HARD[name]
    axis = lamp.matrix[:3, 2] if lamp.kind == "SUN" else lamp.matrix[:3, 3] - points.position
    crossing = points.position + axis / axis[..., 2:] * 1.0
    from_edge = np.abs(np.abs(crossing[:, :2]).max(-1) - 0.5)
    # Texels are about this large on the sheet, longer where the light is slanted, and wider on six maps of a cube.
    texel = 2 * 6 / resolution * (2.5 if lamp.kind == "POINT" else 1) / np.cos(1.0 if name == "low sun" else 0)
    sure = from_edge > 2 * texel
    assert sure.mean() > 0.25
    np.testing.assert_allclose(found[sure], exact[sure], rtol=1e-4, atol=1e-6)
    assert np.mean(np.abs(found - exact) > 1e-3) > 0  # it is a map


SOFT = {
    "area": shapes.lamp("AREA", 50, (0.2, 0, 3), size=(1.0, 0.6)),
    "sphere": shapes.lamp("POINT", 100, (0.2, 0, 3), radius=0.4),
    "disk": shapes.lamp("POINT", 100, (0.2, 0, 3), radius=0.4, soft_falloff=True),
    "spot": shapes.lamp("SPOT", 100, (0.2, 0, 3), spot_angle=1.4, radius=0.3, spot_blend=0.3),
    "sun": slanted(shapes.lamp("SUN", 2, (0, 0, 5), angle=0.2), 0.4),
}


@pytest.mark.parametrize("name", SOFT)
def test_the_half_shadow_of_a_soft_lamp(name):
    points = on_floor(40)
    tracer = shapes.tracer([FLOOR, SHEET], [SOFT[name]])
    exact = tiles.finish(direct.lamps(tracer, points, 256, 0))[:, 0]
    found = light_of(tracer, points, 96, samples=48)
    free = direct.from_lamp(tracer, points, replace(SOFT[name], shadow=False), 256, 0)[:, 0]
    share = exact / np.maximum(free, 1e-9)
    assert np.mean((share > 0.05) & (share < 0.95)) > 0.03
    error = np.abs(found - exact) / free.max()
    assert error.mean() < 0.01 and np.quantile(error, 0.99) < 0.15 and abs(found.mean() / exact.mean() - 1) < 0.01


def test_a_sheet_that_is_half_clear():
    points = on_floor(half=0.3)
    scene = shapes.scene([FLOOR, SHEET], [HARD["sun"]])
    clear = replace(shapes.matte(), alpha=ColorSource(np.full(3, 0.5, np.float32)))
    instances = (scene.instances[0], replace(scene.instances[1], materials=(1,)))
    scene = replace(scene, materials=(shapes.matte(), clear), instances=instances)
    tracer = shapes.Tracer(shapes.Geometry(scene))
    assert abs(light_of(tracer, points, 256).mean() / 2 - 0.5) < 0.05


def test_what_has_no_maps_is_what_it_was():
    """Lamps that cast no shadow, none at all, no surface, and resolution 0."""
    points = on_floor(9)
    lamps = [replace(HARD["point"], shadow=False), SOFT["area"]]
    tracer = shapes.tracer([FLOOR, SHEET], lamps)
    expected = tiles.finish(direct.lamps(tracer, points, 16, 3))[:, 0]
    np.testing.assert_array_equal(light_of(tracer, points, 0), expected)
    shadowless = shapes.tracer([FLOOR, SHEET], lamps[:1])
    np.testing.assert_array_equal(
        light_of(shadowless, points, 64), tiles.finish(direct.lamps(shadowless, points, 16, 3))[:, 0]
    )
    dark = shapes.tracer([FLOOR], environment=Environment(np.ones(3, np.float32)))
    assert not light_of(dark, points, 64).any()
    assert light_of(tracer, points[:0], 64).shape == (0,)
