# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lamps against closed forms; tests/addon/test_direct_cycles.py holds them against Cycles."""

import numpy as np
import pytest
from gi_bake.gi_core import direct, lights, sampling, surfels, tiles
from gi_bake.gi_core.rsm.views import project, texel_rays, views
from gi_bake.gi_core.scene import Environment
from gi_bake.tests import shapes

N = 1 << 14
U = sampling.r2_sequence(N)
BOUNDS = np.float32([[-1, -1, -1], [1, 1, 1]])

LAMPS = {
    "point": shapes.lamp("POINT", 10, (0.1, 0.2, 0.3)),
    "sphere": shapes.lamp("POINT", 10, (0, 0, 0.2), radius=0.3),
    "soft disk": shapes.lamp("POINT", 10, (0, 0, 0.2), radius=0.1, soft_falloff=True),
    "spot": shapes.lamp("SPOT", 10, (0, 0, 1), spot_angle=1.0, spot_blend=0.3),
    "wide spot": shapes.lamp("SPOT", 10, (0, 0, 1), spot_angle=3.0, spot_blend=0.1),
    "area": shapes.lamp("AREA", 10, (0, 0, 1), size=(0.4, 0.2)),
    "ellipse": shapes.lamp("AREA", 10, (0, 0, 1), size=(0.4, 0.2), shape="ELLIPSE"),
    "spread": shapes.lamp("AREA", 10, (0, 0, 1), size=(0.4, 0.2), spread=np.radians(60)),
    "sun": shapes.lamp("SUN", 3.0),
    "wide sun": shapes.lamp("SUN", 3.0, angle=np.radians(10)),
}


def at(point, normal=(0, 0, 1)):
    """Mean irradiance that a lamp brings to a point without shadows."""

    def irradiance(lamp):
        arrival = lights.towards(lamp, np.broadcast_to(np.float32(point), (N, 3)), U)
        cosine = np.maximum(arrival.direction @ np.float32(normal), 0)
        return (arrival.irradiance[:, 0] * cosine).mean()

    return irradiance


def test_point_and_sphere_light_by_the_inverse_square():
    below = at((0, 0, -1.8))
    assert np.isclose(below(LAMPS["sphere"]), 10 / (4 * np.pi) / 4, rtol=1e-3)
    assert np.isclose(at((0.1, 0.2, -1.7))(LAMPS["point"]), 10 / (4 * np.pi) / 4, rtol=1e-5)
    # A facing disk at height d: L π r²/(d² + r²).
    radiance = 10 / (4 * np.pi) / (np.pi * 0.01)
    assert np.isclose(below(LAMPS["soft disk"]), radiance * np.pi * 0.01 / (4 + 0.01), rtol=1e-3)


def test_sphere_from_within_is_its_radiance_all_around():
    inside = at((0, 0, 0.1))
    assert np.isclose(inside(LAMPS["sphere"]), np.pi * 10 / (4 * np.pi * np.pi * 0.09), rtol=5e-3)


def test_a_rectangle_over_a_parallel_element_has_the_known_form_factor():
    lamp, d = LAMPS["area"], 0.5
    x, y = 0.2 / d, 0.1 / d
    quarter = (
        x / np.hypot(1, x) * np.arctan(y / np.hypot(1, x)) + y / np.hypot(1, y) * np.arctan(x / np.hypot(1, y))
    ) / (2 * np.pi)
    expected = 4 * quarter * np.pi * 10 / (np.pi * 0.08)
    assert np.isclose(at((0, 0, 0.5))(lamp), expected, rtol=1e-3)


def test_a_disk_over_a_parallel_element_has_the_known_form_factor():
    lamp = shapes.lamp("AREA", 10, (0, 0, 1), size=(0.6, 0.6), shape="ELLIPSE")
    radiance = 10 / (np.pi * np.pi * 0.09)
    assert np.isclose(at((0, 0, 0.5))(lamp), np.pi * radiance * 0.09 / (0.25 + 0.09), rtol=1e-3)


def test_sun_is_its_irradiance_and_nothing_shines_behind():
    assert np.isclose(at((5, 5, 5))(LAMPS["sun"]), 3.0)
    assert np.isclose(at((5, 5, 5))(LAMPS["wide sun"]), 3.0, rtol=1e-4)
    assert at((0, 0, 1.5), (0, 0, -1))(LAMPS["area"]) == 0
    assert at((0, 0, 1.5), (0, 0, -1))(LAMPS["spot"]) == 0


@pytest.mark.parametrize("name", [n for n in LAMPS if "sun" not in n])
def test_flux_through_a_sphere_is_that_of_the_maps(name):
    """Irradiance on a sphere around the lamp, from `towards`, adds up to the flux that `texel_rays` send out."""
    lamp = LAMPS[name]
    center, radius = np.array([0, 0, 0.5]), 3.0
    normal = -sampling.cone(np.tile(np.float32([0, 0, 1]), (N, 1)), np.full(N, 2.0), U)
    arrival = lights.towards(lamp, (center - radius * normal).astype(np.float32), U[:, ::-1])
    cosine = np.maximum((arrival.direction * normal).sum(-1), 0)
    through = (arrival.irradiance[:, 0] * cosine).mean() * 4 * np.pi * radius**2
    sent = sum(texel_rays(view, k).flux[:, 0].sum(dtype=np.float64) for k, view in enumerate(views(lamp, BOUNDS, 256)))
    assert np.isclose(sent, through, rtol=5e-3)
    if name != "spot" and name != "wide spot":
        assert np.isclose(sent, 10, rtol=2e-3)


def test_a_suns_map_covers_the_scene_and_carries_its_flux():
    [view] = views(LAMPS["sun"], BOUNDS, 64)
    sent = texel_rays(view, 0)
    assert np.isclose(sent.flux[:, 0].sum(dtype=np.float64), 3.0 * 4, rtol=1e-3)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    assert ((project(view, corners) >= 0) & (project(view, corners) <= 1)).all()


@pytest.mark.parametrize("name", ["sun", "wide sun"])
def test_cascades_share_the_flux_and_the_texels(name):
    """A room of two metres in a scene of two kilometres: fine texels around the room, no flux twice, none lost."""
    scene = 1000 * BOUNDS
    room = BOUNDS + np.float32([300, -200, 0])
    cascades = views(LAMPS[name], scene, 256, room)
    [whole] = views(LAMPS[name], scene, 256)
    assert len(cascades) == (4 if name == "sun" else 2)
    sent = [texel_rays(view, k).flux[:, 0].sum(dtype=np.float64) for k, view in enumerate(cascades)]
    assert np.isclose(sum(sent), texel_rays(whole, 0).flux[:, 0].sum(dtype=np.float64), rtol=2e-3)
    assert sum(view.resolution**2 for view in cascades) <= 256**2
    finest = 2 * max(cascades[0].extent) / cascades[0].resolution
    assert finest < 0.04 * 2 * max(whole.extent) / whole.resolution or name == "wide sun"
    # What the room projects to lies in the finest cascade.
    assert ((project(cascades[0], room) >= 0) & (project(cascades[0], room) <= 1)).all()
    assert len(views(LAMPS[name], BOUNDS, 256, BOUNDS)) == 1


@pytest.mark.parametrize("name", ["point", "spot", "wide spot", "area", "spread", "ellipse", "sun"])
def test_projecting_a_rays_points_gives_its_texel(name):
    for view in views(LAMPS[name], BOUNDS, 48):
        sent = texel_rays(view, 1)
        if view.kind == "HEMISPHERE":
            # Seen from the middle of the lamp, which the rays leave all over.
            points = view.origin + 2 * sent.direction
        else:
            points = sent.origin + 2 * sent.direction
        st = project(view, points) * view.resolution
        n = view.resolution
        index = np.arange(n * n)
        off = np.abs(st - np.stack([index % n, index // n], -1) - 0.5)
        assert np.nanmax(off) <= 0.5 + 1e-2


def test_a_scaled_spot_has_an_elliptic_cone():
    matrix = np.diag([2.0, 1.0, 1.0, 1.0])
    lamp = shapes.lamp("SPOT", 10, spot_angle=np.radians(60), spot_blend=0)
    lamp = type(lamp)(**{**vars(lamp), "matrix": matrix})
    slope = np.tan(np.radians(30))

    def lit(x, y):
        d = np.float32([[x, y, -1]])
        return lights.spot_gain(lamp, d / np.linalg.norm(d))[0] > 0

    assert lit(2 * slope * 0.98, 0) and not lit(2 * slope * 1.02, 0)
    assert lit(0, slope * 0.98) and not lit(0, slope * 1.02)


def shadowed(meshes, lamps, at_point, normal=(0, 0, 1), samples=256, **more):
    tracer = shapes.tracer(meshes, lamps, **more)
    n = 32
    here = np.tile(np.float32(at_point), (n, 1))
    up = np.tile(np.float32(normal), (n, 1))
    points = surfels.Surfels(here, up, up, 0 * here, 0 * here, np.arange(n))
    around = direct.surroundings(tracer, points, sampling.Samples(samples), 0)
    both = [tiles.finish(part) for part in (direct.lamps(tracer, points, samples, 0), around)]
    return sum(both)[:, 0].mean()


def test_half_a_soft_lamp_is_hidden_by_half_a_wall():
    # The wall's edge runs below the lamp's middle.
    wall = shapes.plate(0.5, 1.0, center=(1.0, 0.0))
    lamp = shapes.lamp("AREA", 10, (0, 0, 1), size=(0.2, 0.2))
    half, whole = shadowed([wall], [lamp], (0, 0, 0)), shadowed([], [lamp], (0, 0, 0))
    assert np.isclose(half / whole, 0.5, atol=0.01)


def test_shadows_can_be_switched_off():
    wall, lamp = shapes.plate(0.5, 1.0), shapes.lamp("POINT", 10, (0, 0, 1))
    assert shadowed([wall], [lamp], (0, 0, 0)) == 0
    lamp = type(lamp)(**{**vars(lamp), "shadow": False})
    assert np.isclose(shadowed([wall], [lamp], (0, 0, 0)), 10 / (4 * np.pi), rtol=1e-4)


def test_an_open_sky_lights_by_pi_times_its_radiance():
    sky = Environment(np.full(3, 2.0, np.float32))
    assert np.isclose(shadowed([shapes.plate(-1, 1)], [], (0, 0, 0), environment=sky), 2 * np.pi, rtol=1e-5)
    # A vertical point over an endless floor sees half of it.
    floor = shapes.plate(-0.01, 1000)
    assert np.isclose(shadowed([floor], [], (0, 0, 0), (1, 0, 0), environment=sky), np.pi, rtol=0.01)


def test_emitting_surfaces_light_by_their_form_factor():
    glow = shapes.matte(0, 3.0)
    panel = shapes.plate(1.0, 0.3)
    x = 0.3
    quarter = 2 * (x / np.hypot(1, x)) * np.arctan(x / np.hypot(1, x)) / (2 * np.pi)
    expected = np.pi * 3.0 * 4 * quarter
    # Both sides shine: the panel's front is turned away.
    assert np.isclose(shadowed([panel], [], (0, 0, 0), material=glow, samples=1024), expected, rtol=5e-3)
