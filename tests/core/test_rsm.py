# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflective shadow maps against closed forms (techniques: a lit square's form factor, furnaces) and their published
traps."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import rsm, surfels, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.scene import Environment
from gi_bake.gi_core.surfels import Surfels
from gi_bake.tests import shapes

SETTINGS = RsmSettings(samples=1024, map_resolution=128)


def facing(at, normal=(0, 0, -1), n=16):
    here, up = np.tile(np.float32(at), (n, 1)), np.tile(np.float32(normal), (n, 1))
    return Surfels(here, up, up, 0 * here, 0 * here, np.arange(n))


def irradiance(tracer, points, settings=SETTINGS):
    lighting = tiles.finish(rsm.emit(tracer, points, settings))
    return tiles.finish(rsm.indirect(tracer, points, lighting, settings))


def square_over_element(half, height):
    """Form factor from a small parallel element on a square's axis to the square."""
    x = half / height
    return 4 * 2 * (x / np.hypot(1, x)) * np.arctan(x / np.hypot(1, x)) / (2 * np.pi)


# A sun of 2 W/m² on a floor of albedo ½ that is seen from 1 m above: radiosity 1 W/m².
SUNLIT = shapes.tracer([shapes.plate(0, 1)], [shapes.lamp("SUN", 2.0, (0, 0, 5))])
EXPECTED = square_over_element(1, 1)


@pytest.mark.parametrize("pattern", ["all", "flux", "disk"])
def test_a_lit_square_equals_its_form_factor(pattern):
    settings = replace(SETTINGS, pattern=pattern, disk_radius=1.0, samples=8192)
    assert np.allclose(irradiance(SUNLIT, facing((0, 0, 1)), settings), EXPECTED, rtol=0.01)


def test_neither_the_maps_resolution_nor_the_disks_radius_changes_the_light():
    at = facing((0.3, -0.2, 0.7), n=64)
    reference = irradiance(SUNLIT, at, replace(SETTINGS, pattern="all", map_resolution=64)).mean()
    for resolution in (32, 128, 256):
        settings = replace(SETTINGS, pattern="all", map_resolution=resolution)
        assert np.isclose(irradiance(SUNLIT, at, settings).mean(), reference, rtol=0.005)
    for radius in (0.8, 1.2, 2.0):
        settings = replace(SETTINGS, pattern="disk", disk_radius=radius, samples=8192)
        assert np.isclose(irradiance(SUNLIT, at, settings).mean(), reference, rtol=0.02)


def test_the_squared_weight_is_biased_where_light_comes_from_near_by():
    near = facing((0, 0, 0.1), n=64)
    settings = replace(SETTINGS, pattern="disk", disk_radius=0.7, samples=8192)
    exact = irradiance(SUNLIT, near, settings).mean()
    literal = irradiance(SUNLIT, near, replace(settings, weighting="literal")).mean()
    expected = square_over_element(1, 0.1)
    assert np.isclose(exact, expected, rtol=0.02)
    assert literal < 0.7 * expected


def test_what_is_near_in_the_map_may_be_far_away():
    """Under a small roof the disk around a point's place in the map holds the roof's upper side, not what lights it."""
    roof = shapes.plate(0.9, 0.2, name="roof")
    tracer = shapes.tracer([shapes.plate(0, 1), roof], [shapes.lamp("SUN", 2.0, (0, 0, 5))])
    under = facing((0, 0, 0.8), n=64)
    expected = square_over_element(1, 0.8) - square_over_element(0.2, 0.8)
    assert np.isclose(irradiance(tracer, under).mean(), expected, rtol=0.01)
    disk = replace(SETTINGS, pattern="disk")
    assert irradiance(tracer, under, replace(disk, disk_radius=0.09)).max() == 0
    assert irradiance(tracer, under, disk).mean() < 0.7 * expected


def test_tilted_ground_keeps_a_suns_flux():
    """Flux of an orthographic texel has no cosine: what a tilted plate intercepts it sends on."""
    slope = shapes.quad((-1, -1, -1), (1, -1, -1), (1, 1, 1), (-1, 1, 1))
    tracer = shapes.tracer([slope], [shapes.lamp("SUN", 2.0, (0, 0, 5))])
    lighting = tiles.finish(rsm.emit(tracer, facing((0, 0, 1)), SETTINGS))
    assert np.isclose(lighting.reflected.flux.sum(0)[0], 2.0 * 4 * 0.5, rtol=0.01)


def test_visibility_keeps_light_out():
    lamp = shapes.lamp("SPOT", 20, (0, 0, 0.9), spot_angle=1.0)
    wall = shapes.plate(0.95, 0.9, name="wall")
    tracer = shapes.tracer([shapes.plate(0, 1), wall], [lamp])
    above = facing((0, 0, 1.5))
    assert irradiance(tracer, above).max() == 0
    assert irradiance(tracer, above, replace(SETTINGS, visibility=False)).min() > 0.01


def test_the_singularity_is_bounded_in_a_corner():
    floor, wall = shapes.plate(0, 1), shapes.quad((1, -1, 0), (1, -1, 2), (1, 1, 2), (1, 1, 0), name="wall")
    tracer = shapes.tracer([floor, wall], [shapes.lamp("SUN", 2.0, (0, 0, 5))])
    # Half the floor's radiosity is what an element of the wall can see at the most.
    found = irradiance(tracer, facing((1, 0, 1e-4), (-1, 0, 0), 256), replace(SETTINGS, pattern="all"))
    assert np.isfinite(found).all() and found.max() < 0.5


BOX = shapes.matte(0.6, 1.0)


def test_an_emitting_furnace():
    """In a closed box that emits L everywhere and reflects ρ, the k-th bounce brings π L ρᵏ, everywhere."""
    tracer = shapes.tracer([shapes.box(1)], material=BOX)
    at = facing((0, 0, -0.999), (0, 0, 1), 64)
    expected = np.pi * np.cumsum([0.6**k for k in (1, 2, 3)])
    for bounces in (1, 2, 3):
        found = irradiance(tracer, at, replace(SETTINGS, bounces=bounces, samples=4096)).mean()
        assert np.isclose(found, expected[bounces - 1], rtol=0.02)


def test_light_of_the_sky_bounces():
    """A floor of albedo ½ under an even sky sends half of it back up."""
    tracer = shapes.tracer([shapes.plate(0, 5)], environment=Environment(np.full(3, 2.0, np.float32)))
    found = irradiance(tracer, facing((0, 0, 1.5), n=64), replace(SETTINGS, samples=8192)).mean()
    assert np.isclose(found, np.pi * 2 * 0.5 * square_over_element(5, 1.5), rtol=0.03)


def test_the_same_seed_gives_the_same_bytes_and_tiles_do_not_show(monkeypatch):
    tracer = shapes.tracer([shapes.box(1)], [shapes.lamp("POINT", 10, (0, 0, 0.5), radius=0.1)])
    at = facing((0.2, 0.1, -0.9), (0, 0, 1), 500)
    first = irradiance(tracer, at)
    assert np.array_equal(first, irradiance(tracer, at))
    assert not np.array_equal(first, irradiance(tracer, at, replace(SETTINGS, seed=1)))
    monkeypatch.setattr("gi_bake.gi_core.gathering._PAIRS", 7 * SETTINGS.samples)
    monkeypatch.setattr("gi_bake.gi_core.tiles.os.cpu_count", lambda: 1)
    assert np.allclose(first, irradiance(tracer, at), rtol=1e-6)


def test_no_light_and_no_surface_are_no_errors():
    assert (irradiance(shapes.tracer([shapes.plate(0, 1)]), facing((0, 0, 1))) == 0).all()
    empty = shapes.tracer([], [shapes.lamp("SUN", 2.0)])
    assert (irradiance(empty, facing((0, 0, 1))) == 0).all()
    nowhere = Surfels(*(np.zeros((0, 3), np.float32),) * 5, np.zeros(0, np.int64))
    assert irradiance(SUNLIT, nowhere).shape == (0, 3)


def test_vertices_and_texels_of_a_lit_floor_agree():
    ceiling = shapes.plate(1, 0.5, up=False, name="ceiling")
    tracer = shapes.tracer([shapes.plate(0, 1), ceiling], [shapes.lamp("SPOT", 20, (0, 0, 0.9), spot_angle=1.5)])
    lighting = tiles.finish(rsm.emit(tracer, facing((0, 0, 1)), SETTINGS))
    texels, centred = surfels.from_texels(tracer.geometry, "ceiling", "", (32, 32))
    corners = surfels.from_corners(tracer.geometry, "ceiling")
    assert centred.all() and corners.place.tolist() == list(range(6))
    of_texels = tiles.finish(rsm.indirect(tracer, texels, lighting, SETTINGS))[:, 0].reshape(32, 32)
    of_corners = tiles.finish(rsm.indirect(tracer, corners, lighting, SETTINGS))[:, 0]
    assert np.allclose(of_corners[[0, 1, 2, 5]], of_texels[[0, 0, -1, -1], [0, -1, -1, 0]], rtol=0.1)


def corner(bound, samples=64, seed=0):
    """Irradiance on a wall, 1 cm to 40 cm above a sunlit floor that it stands on."""
    wall = shapes.quad((1, -1, 0), (1, -1, 2), (1, 1, 2), (1, 1, 0), name="wall")
    tracer = shapes.tracer([shapes.plate(0, 1), wall], [shapes.lamp("SUN", 2.0, (0, 0, 5))])
    here = np.stack([np.full(2000, 1.0), np.linspace(-0.5, 0.5, 2000), np.linspace(0.01, 0.4, 2000)], -1)
    facing_it = np.tile(np.float32([-1, 0, 0]), (2000, 1))
    points = Surfels(here.astype(np.float32), facing_it, facing_it, 0 * facing_it, 0 * facing_it, np.arange(2000))
    return irradiance(tracer, points, replace(SETTINGS, bound=bound, samples=samples, seed=seed))[:, 0], here


def wall_over_floor(y, z):
    """Closed form of the same: an element on a wall at height z over a floor of depth 2, from y = −1 to y = 1.

    Contour integral of a rectangle over a perpendicular element: for a floor that begins at the wall.
    """
    depth = 2.0
    r = np.hypot(depth, z)

    def half(width):
        return (np.arctan(width / z) - z / r * np.arctan(width / r)) / (2 * np.pi)

    return half(1 - y) + half(1 + y)


def test_the_near_field_is_exact_and_calm():
    found, here = corner("compensated")
    expected = wall_over_floor(here[:, 1], here[:, 2])
    assert np.isclose(found.mean(), expected.mean(), rtol=0.005)
    low = here[:, 2] < 0.05
    assert np.isclose(found[low].mean(), expected[low].mean(), rtol=0.01)
    plain, _ = corner("disc")
    assert np.std(found - expected) < 0.4 * np.std(plain - expected)


def test_error_falls_with_samples_as_it_should():
    """Mean square error times samples does not rise: no outliers that only many samples would tame."""
    errors = []
    for samples in (16, 64, 256):
        found, here = corner("compensated", samples)
        errors.append(samples * np.mean((found - wall_over_floor(here[:, 1], here[:, 2])) ** 2))
    assert errors[1] < 1.5 * errors[0] and errors[2] < 1.5 * errors[1]


def test_lights_that_nobody_sees_take_few_samples(monkeypatch):
    """A sun on a wide roof, and through a slit onto the floor of the room below."""
    roof = [
        shapes.plate(1, 5, center=(-5.1, 0), name="roof left"),
        shapes.plate(1, 5, center=(5.1, 0), name="roof right"),
    ]
    room = [shapes.plate(0, 1, name="floor")]
    tracer = shapes.tracer(roof + room, [shapes.lamp("SUN", 2.0, (0, 0, 5))])
    below = facing((0.5, 0, 0.9), n=500)

    def error():
        found = irradiance(tracer, below, replace(SETTINGS, samples=64, map_resolution=512))[:, 0]
        return found.mean(), found.std()

    mean, deviation = error()
    monkeypatch.setattr("gi_bake.gi_core.rsm.importance._DEFENSE", 1.0)
    monkeypatch.setattr("gi_bake.gi_core.rsm.importance._EXPLORE", 1.0)
    even_mean, even_deviation = error()
    assert np.isclose(mean, even_mean, rtol=0.1)
    assert deviation < 0.5 * even_deviation


def test_drawing_lights_anew_keeps_their_flux():
    tracer = shapes.tracer([shapes.box(1)], [shapes.lamp("POINT", 10, (0.2, 0.1, 0.3), radius=0.05)])
    lighting = tiles.finish(rsm.emit(tracer, facing((0, 0, 0), (1, 0, 0)), SETTINGS))
    assert np.isclose(lighting.reflected.flux[:, 0].sum(dtype=np.float64), 10 * 0.5, rtol=0.005)
