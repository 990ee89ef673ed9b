# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from what lies beyond the scene, drawn by where it comes from, against closed forms."""

import numpy as np
import pytest
from gi_bake.gi_core import direct, environment, rsm, sampling, surfels, tiles
from gi_bake.gi_core.environment import parted
from gi_bake.gi_core.rsm.scatter import skylit
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.scene import Environment, Texture
from gi_bake.tests import shapes

# A turn of the world by a third around (1, 1, 1), which takes each axis to the next.
TURN = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def sky(pixels, interpolation="LINEAR", rotation=None):
    texture = Texture("sky", np.ascontiguousarray(pixels, np.float32), "REPEAT", interpolation)
    return Environment(np.float32([1, 1, 1]), texture, np.eye(3) if rotation is None else rotation)


def random_sky(interpolation="LINEAR"):
    pixels = np.random.default_rng(3).random((8, 16, 3)) ** 8
    pixels[2:5, 3:9] = 0
    pixels[5, 2] = 20
    return sky(pixels, interpolation, TURN)


def small_sun(radiance=4e4, interpolation="CLOSEST", rotation=None):
    """One bright pixel of 128 × 64, at 48.5° above the horizon: the environment, its direction and solid angle."""
    pixels = np.zeros((64, 128, 3))
    row, column = 49, 20
    pixels[row, column] = radiance
    low, high = np.sin(np.pi * (np.array([row, row + 1]) / 64 - 0.5))
    angle = 2 * np.pi * (0.5 - (column + 0.5) / 128)
    across = np.cos(np.pi * ((row + 0.5) / 64 - 0.5))
    direction = np.array([across * np.cos(angle), across * np.sin(angle), np.sin(np.pi * ((row + 0.5) / 64 - 0.5))])
    turn = np.eye(3) if rotation is None else rotation
    return sky(pixels, interpolation, rotation), direction @ turn, 2 * np.pi / 128 * (high - low)


def all_around(n=1 << 10):
    """Even directions on a grid: (n · n/2, 3)."""
    z, angle = np.meshgrid((np.arange(n // 2) + 0.5) * 4 / n - 1, (np.arange(n) + 0.5) * 2 * np.pi / n)
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], -1).reshape(-1, 3)


def points(at, normal=(0, 0, 1), n=256):
    here, up = np.tile(np.float32(at), (n, 1)), np.tile(np.float32(normal), (n, 1))
    return surfels.Surfels(here, up, up, 0 * here, 0 * here, np.arange(n))


def received(tracer, here, samples):
    lamps = direct.from_lamps(tracer, here, samples, 0)
    around = direct.from_surroundings(tracer, here, sampling.Samples(samples), 0)
    return (lamps + around)[:, 0]


@pytest.mark.parametrize("interpolation", ["LINEAR", "CLOSEST"])
def test_densities_integrate_to_one_and_are_those_of_the_samples(interpolation):
    parts = parted(random_sky(interpolation))
    around = all_around()
    for part in parts:
        assert np.isclose(part.pdf(around).mean() * 4 * np.pi, 1, rtol=2e-3)
        drawn = part.sample(sampling.r2_sequence(1 << 17))
        assert np.allclose(np.linalg.norm(drawn, axis=1), 1, atol=1e-6)
        density = part.pdf(drawn)
        assert density.min() > 0
        # What samples over their density add up to is what the grid does: of the light, and of the light's direction.
        by_sample, by_grid = part.radiance(drawn).mean(-1) / density, part.radiance(around).mean(-1) * 4 * np.pi
        assert np.isclose(by_sample.mean(), by_grid.mean(), rtol=5e-3)
        assert np.allclose(by_sample @ drawn / len(drawn), by_grid @ around / len(around), atol=5e-3 * by_grid.mean())


@pytest.mark.parametrize("interpolation", ["LINEAR", "CLOSEST"])
def test_sky_and_suns_add_up_and_directions_follow_their_light(interpolation):
    """Brightness over density is nearly the same everywhere, and wherever there is light it is drawn."""
    pixels = np.repeat(np.repeat(random_sky().texture.pixels, 8, 0), 8, 1)
    light = sky(pixels, interpolation, TURN)
    around = all_around(512)
    parts = parted(light)
    whole = environment.radiance(light, around)
    assert np.allclose(sum(part.radiance(around) for part in parts), whole, rtol=1e-5, atol=1e-6)
    assert 0.05 < parts[1].radiance(around).mean() / whole.mean() < 0.95
    for part in parts:
        assert (part.pdf(around)[part.radiance(around).mean(-1) > 0] > 0).all()
        drawn = part.sample(sampling.r2_sequence(1 << 12))
        ratio = part.radiance(drawn).mean(-1) / part.pdf(drawn)
        # Where a sun's edge is interpolated its foot is brighter than the pixels' own densities have it.
        assert ratio.std() < (0.5 if interpolation == "LINEAR" else 0.1) * ratio.mean()


def test_a_uniform_image_is_drawn_evenly_and_what_has_no_light_not_at_all():
    even, suns = parted(sky(np.ones((256, 8, 3))))
    assert suns is None and np.allclose(even.pdf(all_around(64)), 1 / (4 * np.pi), rtol=0.02)
    drawn = even.sample(sampling.r2_sequence(1 << 14))
    assert np.allclose(drawn.T @ drawn / len(drawn), np.eye(3) / 3, atol=2e-3)
    for light in (Environment(np.float32([1, 2, 3])), sky(np.zeros((4, 8, 3)))):
        part, suns = parted(light)
        assert suns is None and not part.share and np.allclose(part.radiance(drawn), environment.radiance(light, drawn))


@pytest.mark.parametrize("rotation", [None, TURN], ids=["straight", "turned"])
def test_one_bright_pixel_is_a_small_sun(rotation):
    light, towards, solid_angle = small_sun(rotation=rotation)
    normal = np.array([0.36, 0.48, 0.8]) * np.where(towards < 0, -1, 1)
    tracer = shapes.tracer([shapes.plate(-1, 1)], environment=light)
    here = points((0, 0, 0), normal)
    found = received(tracer, here, 64)
    assert np.isclose(found.mean(), 4e4 * solid_angle * (normal @ towards), rtol=2e-3)
    assert found.std() < 0.02 * found.mean()


def test_rays_to_the_light_take_the_noise_away():
    light, _, _ = small_sun(4e3, "LINEAR")
    tracer, here, samples = shapes.tracer([shapes.plate(-1, 1)], environment=light), points((0, 0, 0)), 64
    found = received(tracer, here, samples)
    u = sampling.rotated(sampling.r2_sequence(samples), here.place, 5).reshape(-1, 2)
    rays = sampling.cosine_hemisphere(np.repeat(here.normal, samples, 0), u)
    by_cosine = np.pi * environment.radiance(light, rays)[:, 0].reshape(-1, samples).mean(-1)
    assert found.std() <= by_cosine.std() / 5
    around = all_around()
    expected = (environment.radiance(light, around)[:, 0] * np.maximum(around[:, 2], 0)).mean() * 4 * np.pi
    assert np.isclose(found.mean(), expected, rtol=2e-3)


@pytest.mark.parametrize("samples", [1, 2, 3, 64])
def test_any_number_of_rays_is_unbiased(samples):
    """A gradient and a sun, half of the sky behind a wall."""
    light, towards, _ = small_sun(500, "LINEAR")
    rows = light.texture.pixels + np.linspace(0.5, 2, 64)[:, None, None]
    light = sky(rows)
    side = np.sign(towards[0])
    wall = shapes.quad((-side, -1e3, -1), (-side, 1e3, -1), (-side, 1e3, 1e4), (-side, -1e3, 1e4))
    tracer = shapes.tracer([wall], environment=light)
    found = received(tracer, points((0, 0, 0), n=1 << 15 if samples < 4 else 1 << 10), samples)
    around = all_around()
    reaches = np.maximum(around[:, 2], 0) * (around[:, 0] * side > 0)
    expected = (environment.radiance(light, around)[:, 0] * reaches).mean() * 4 * np.pi
    assert np.isclose(found.mean(), expected, rtol=0.01)


def test_the_skys_light_on_surfaces_is_what_they_reflect_of_it():
    """A plate gets π L on either side of an even sky and L Ω cosθ on one side of a small sun; it sends half."""
    light, towards, solid_angle = small_sun()
    area = 16 + 0.04
    for environment_, expected in (
        (Environment(np.float32([2, 2, 2])), 2 * np.pi * 2 * area * 0.5),
        (light, 4e4 * solid_angle * towards[2] * area * 0.5),
    ):
        plates = [shapes.plate(0, 2), shapes.plate(-3, 0.1, center=(40, 4))]
        lights = tiles.finish(skylit(shapes.tracer(plates, environment=environment_), 1 << 14, 0))
        assert np.isclose(lights.flux[:, 0].sum(), expected, rtol=2e-3)
        assert np.isclose(lights.area.sum(), 2 * area, rtol=1e-4)


def test_the_sky_finds_a_window():
    """Through a small window A in a large dark room an even sky sends π L A."""
    r, w = 2.0, 0.4
    walls = [shapes.plate(-r, r)]
    for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1)):
        a, b = (x * r - y * r, y * r + x * r), (x * r + y * r, y * r - x * r)
        walls.append(shapes.quad((*a, -r), (*b, -r), (*b, r), (*a, r)))
    frame = [
        shapes.quad((x0, y0, r), (x1, y0, r), (x1, y1, r), (x0, y1, r))
        for x0, y0, x1, y1 in ((-r, -r, -w, r), (w, -r, r, r), (-w, -r, w, -w), (-w, w, w, r))
    ]
    tracer = shapes.tracer([*walls, *frame], environment=Environment(np.float32([2, 2, 2])))
    lights = tiles.finish(skylit(tracer, 1 << 17, 0))
    inside = (lights.normal * lights.position).sum(-1) < 0
    assert np.isclose(lights.flux[inside, 0].sum(), 0.5 * np.pi * 2 * (2 * w) ** 2, rtol=0.03)


def test_a_small_suns_light_bounces():
    """A floor of albedo ½ sends half of what it gets back up."""
    light, towards, solid_angle = small_sun(rotation=TURN)
    # The floor faces the sun's half of the sky.
    up = towards[2] > 0
    tracer = shapes.tracer([shapes.plate(0, 1, up)], environment=light)
    at = points((0, 0, 1 if up else -1), (0, 0, -1 if up else 1), 64)
    settings = RsmSettings(samples=4096)
    lighting = tiles.finish(rsm.emit(tracer, at, settings))
    found = tiles.finish(rsm.indirect(tracer, at, lighting, settings))[:, 0].mean()
    form_factor = 4 * 2 * np.sqrt(0.5) * np.arctan(np.sqrt(0.5)) / (2 * np.pi)
    assert np.isclose(found, 0.5 * 4e4 * solid_angle * abs(towards[2]) * form_factor, rtol=0.02)
