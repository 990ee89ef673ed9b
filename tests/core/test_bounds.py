# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What keeps near lights in bounds, against its formula and in a corner where a wall stands on a sunlit floor; and one
pattern for all points."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import rsm, tiles
from gi_bake.gi_core.kernels.vpl_transfer import transfer
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.surfels import Surfels
from gi_bake.tests import shapes
from gi_bake.tests.core.test_rsm import wall_over_floor

BOUNDED = ("disc", "distance", "geometry", "offset")

WALL = shapes.quad((1, -1, 0), (1, -1, 2), (1, 1, 2), (1, 1, 0), name="wall")
# A sun of 2 W/m² on a floor of albedo ½: radiosity 1 W/m².
CORNER = shapes.tracer([shapes.plate(0, 1), WALL], [shapes.lamp("SUN", 2.0, (0, 0, 5))])


def pairs(n=2000):
    rng = np.random.default_rng(1)
    receivers, lights = rng.uniform(-1, 1, (2, n, 3))
    normals, axes = rng.normal(size=(2, n, 3))
    normals, axes = (v / np.linalg.norm(v, axis=-1, keepdims=True) for v in (normals, axes))
    return receivers, normals, lights, axes, rng.uniform(0.01, 2, n)


def exact(receiver, normal, light, axis):
    """cosθ_p, cosθ_x and d in double precision."""
    d = np.linalg.norm(light - receiver, axis=-1)
    return (
        np.maximum(np.sum(axis * (receiver - light), -1) / d, 0),
        np.maximum(np.sum(normal * (light - receiver), -1) / d, 0),
        d,
    )


@pytest.mark.parametrize("bound", BOUNDED)
def test_bounds_are_what_their_formulas_say(bound):
    receiver, normal, light, axis, area = pairs()
    cos_p, cos_x, d = exact(receiver, normal, light, axis)
    r = np.sqrt(area / np.pi)
    if bound == "disc":
        expected = cos_p * cos_x / (np.pi * d**2 + area)
    elif bound == "distance":
        expected = cos_p * cos_x / (np.pi * np.where(d < r, r, d) ** 2)
    elif bound == "geometry":
        expected = np.minimum(cos_p * cos_x / (np.pi * d**2), 1 / area)
    else:
        faces = cos_p * cos_x > 0
        cos_p, cos_x, d = exact(receiver, normal, light - r[:, None] * axis, axis)
        expected = np.where(faces, cos_p * cos_x / (np.pi * d**2), 0)
    found = transfer(*(a.astype(np.float32) for a in (receiver, normal, light, axis, area)), bound)
    assert np.count_nonzero(expected) > 300
    assert np.allclose(found, expected, rtol=1e-4, atol=1e-6)


@pytest.mark.parametrize("bound", BOUNDED)
def test_no_light_sends_more_than_the_disk_that_it_stands_for(bound):
    """From any side and from as near as one likes, on top of each other too."""
    receiver, normal, _, axis, area = (a.astype(np.float32) for a in pairs())
    for distance in (1.0, 1e-2, 1e-6, 0.0):
        light = receiver + np.float32(distance) * normal
        found = transfer(receiver, normal, light, axis, area, bound)
        assert (found >= 0).all() and (found <= 1.0001 / area).all()


def test_a_light_moved_back_does_not_shine_on_its_own_surface_or_behind_it():
    up, origin = np.float32([[0, 0, 1]]), np.zeros((1, 3), np.float32)
    for height, lit in ((0.1, True), (0.0, False), (-0.1, False)):
        receiver = np.float32([[0.5, 0, height]])
        for normal in (up, -up, np.float32([[-1, 0, 0]])):
            found = transfer(receiver, normal, origin, up, np.float32([1.0]), "offset")
            assert (found > 0) == (lit and normal[0, 2] <= 0)


def on_the_wall(heights):
    n = len(heights)
    here = np.stack([np.ones(n), np.linspace(-0.5, 0.5, n), heights], -1).astype(np.float32)
    towards = np.tile(np.float32([-1, 0, 0]), (n, 1))
    return Surfels(here, towards, towards, 0 * here, 0 * here, np.arange(n))


def irradiance(points, tracer=CORNER, **settings):
    settings = RsmSettings(**({"map_resolution": 256, "samples": 64} | settings))
    lighting = tiles.finish(rsm.emit(tracer, points, settings))
    return tiles.finish(rsm.indirect(tracer, points, lighting, settings))[:, 0]


def summed_over_the_floor(points, transferred):
    """The floor's light at points of the wall by the midpoint rule: transferred(cosθ_p cosθ_x, d²) over 1 mm²."""
    x, y = np.meshgrid((np.arange(1000) + 0.5) / 500 - 1, (np.arange(1000) + 0.5) / 500 - 1)
    total = []
    for _, at_y, z in points.position.astype(np.float64):
        d2 = (1 - x) ** 2 + (y - at_y) ** 2 + z**2
        total.append(np.sum(transferred(z * (1 - x) / d2, d2)) * 4e-6)
    return np.array(total)


@pytest.mark.parametrize("bound", BOUNDED)
def test_in_a_corner_each_bound_takes_the_light_that_its_formula_takes(bound):
    r = 0.1
    points = on_the_wall(np.array([0.02, 0.04, 0.08, 0.16, 0.4]))
    found = irradiance(points, pattern="all", bound=bound, bound_distance=r)
    truth = wall_over_floor(points.position[:, 1], points.position[:, 2])
    if bound == "offset":
        # Every light lies deeper by r: a floor that is lower by as much.
        expected = wall_over_floor(points.position[:, 1], points.position[:, 2] + r)
    else:
        formula = {
            "disc": lambda cosines, d2: cosines / (np.pi * (d2 + r**2)),
            "distance": lambda cosines, d2: cosines / (np.pi * np.maximum(d2, r**2)),
            "geometry": lambda cosines, d2: np.minimum(cosines / (np.pi * d2), 1 / (np.pi * r**2)),
        }
        expected = summed_over_the_floor(points, formula[bound])
    assert np.allclose(found, expected, rtol=0.01)
    loss = 1 - found / truth
    assert loss[0] > 0.09
    # Moving lights costs light at any distance, the others only near by.
    assert loss[-1] > 0.09 if bound == "offset" else loss[-1] < 0.1 * loss[0]


def test_what_is_compensated_loses_nothing_whatever_counts_as_near():
    points = on_the_wall(np.linspace(0.01, 0.4, 2000))
    truth = wall_over_floor(points.position[:, 1], points.position[:, 2])
    for distance in (0.0, 0.3, 1.0):
        found = irradiance(points, bound="compensated", bound_distance=distance, samples=256)
        assert np.isclose(found.mean(), truth.mean(), rtol=0.005)
        # Of 200 points; their noise is 0.4 %.
        assert np.isclose(found[:200].mean(), truth[:200].mean(), rtol=0.015)


@pytest.mark.parametrize("bound", BOUNDED)
def test_in_the_very_corner_all_is_finite(bound):
    points = on_the_wall(np.array([1e-6, 1e-5, 1e-4, 1e-3]))
    for pattern in ("all", "flux", "disk"):
        found = irradiance(points, bound=bound, pattern=pattern)
        assert np.isfinite(found).all()
        # Half the floor's radiosity is what an element of the wall can see; few lights that are near give more.
        if pattern == "all":
            assert (found < 0.75).all()


@pytest.mark.parametrize("pattern", ["flux", "disk"])
def test_with_one_pattern_equal_points_get_equal_light(pattern):
    points = on_the_wall(np.full(50, 0.2))
    points = replace(points, position=np.tile(points.position[:1], (50, 1)))
    each = irradiance(points, pattern=pattern, samples=16)
    same = irradiance(points, pattern=pattern, samples=16, pattern_per_point=False)
    assert len(np.unique(each)) > 25
    # Equal but for the order in which a sum of sixteen is taken.
    assert np.ptp(same) <= 1e-6 * same.max() and same.max() > 0


@pytest.mark.parametrize("pattern", ["flux", "disk"])
def test_one_pattern_leaves_bands_instead_of_noise(pattern):
    """Off by as much, but neighbours are off alike."""
    points = on_the_wall(np.linspace(0.3, 0.6, 500))
    points = replace(points, position=points.position * [1, 0, 1] + np.float32([0, 0.1, 0]))
    truth = wall_over_floor(points.position[:, 1], points.position[:, 2])
    more = {"pattern": pattern, "samples": 32, "bound": "disc", "disk_radius": 0.5}
    noise, bands = (np.diff(irradiance(points, pattern_per_point=own, **more) - truth) for own in (True, False))
    assert np.std(bands) < 0.3 * np.std(noise)
