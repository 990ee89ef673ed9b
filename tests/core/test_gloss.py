# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobe of glossy surfaces against what any lobe must hold: reciprocity, furnaces, sampling that equals the
integral."""

import numpy as np
import pytest
from gi_bake.gi_core import gloss, surfels, tiles
from gi_bake.gi_core.gloss import Gloss, dielectric, fresnel_mean
from gi_bake.gi_core.kernels import ggx
from gi_bake.gi_core.rsm.glossy import glossy_light
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.sampling import r2_sequence
from gi_bake.gi_core.scene import Camera, ColorSource, Environment, Material
from gi_bake.gi_core.scene import Gloss as Layer
from gi_bake.gi_core.vectors import dot, normalize
from gi_bake.tests import shapes

UP = np.float32([0, 0, 1])

MIRROR = {"specular": 1.0, "edge": 1.0, "metal": 1.0}
GOLD = {"specular": (0.9, 0.6, 0.2), "edge": 1.0, "metal": 1.0}
PLASTIC = {"dielectric": 1.0}


def tilted(cosine, n):
    return np.tile(np.float32([np.sqrt(1 - cosine**2), 0, cosine]), (n, 1))


def points(roughness, cosine, n, normal=UP, view=None, **layer):
    """n times the same point, seen at an angle to its normal."""
    def rows(value):
        return np.broadcast_to(np.float32(value), (n, 3))

    kinds = [rows(layer.get(name, 0.0)) for name in ("specular", "edge", "metal", "dielectric")]
    view = tilted(cosine, n) if view is None else view
    return Gloss(rows(normal), view, np.full(n, roughness**2, np.float32), *kinds, np.full(n, 1.5, np.float32))


def evenly(n):
    """Directions spread evenly over the upper hemisphere."""
    z, turn = r2_sequence(n).T
    angle, across = 2 * np.pi * turn, np.sqrt(1 - z**2)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], -1)


@pytest.mark.parametrize("roughness", [0.3, 0.6, 1.0])
@pytest.mark.parametrize("cosine", [0.1, 0.5, 0.95])
def test_drawing_from_the_lobe_equals_its_integral(roughness, cosine):
    """Of a sky that grows brighter to one side and to the top, by rays of the lobe and by even ones."""
    n = 1 << 18
    at, light = points(roughness, cosine, n, **GOLD), evenly(n)

    def sky(direction):
        return 1 + 0.8 * direction[:, :1] + direction[:, 2:] ** 2

    direction, weight = at.drawn(r2_sequence(n))
    by_lobe = (weight * sky(direction)).mean(0)
    by_chance = 2 * np.pi * (at.brdf(light) * light[:, 2:] * sky(light)).mean(0)
    assert np.allclose(by_lobe, by_chance, rtol=0.01)


@pytest.mark.parametrize("roughness", [0.2, 0.5, 0.8, 1.0])
@pytest.mark.parametrize("cosine", [0.05, 0.3, 0.7, 1.0])
def test_a_white_furnace_stays_white(roughness, cosine):
    """Facets that are mirrors lose light below the surface; with what bounces among them given back, none is lost."""
    n = 1 << 14
    at = points(roughness, cosine, n, **MIRROR)
    half = ggx.facets(at.view, at.alpha, r2_sequence(n))
    once = ggx.worth(at.view, ggx.mirrored(at.view, half), at.alpha)
    assert once.max() <= 1 and once.mean() <= 1
    assert np.isclose(at.drawn(r2_sequence(n))[1].mean(), 1, atol=0.01)
    assert np.allclose(at.color(), 1, atol=0.01)


@pytest.mark.parametrize("layer", [GOLD, PLASTIC, {"dielectric": 0.5, "specular": 0.4, "edge": 0.5, "metal": 0.5}])
@pytest.mark.parametrize("roughness", [0.1, 0.5, 0.9])
def test_no_more_is_reflected_than_arrives_and_the_colour_says_how_much(layer, roughness):
    for cosine in (0.1, 0.4, 0.9):
        at = points(roughness, cosine, 1 << 14, **layer)
        found = at.drawn(r2_sequence(len(at)))[1].mean(0)
        assert (found <= 1).all()
        assert np.allclose(at.color()[0], found, rtol=0.03, atol=0.003)


def test_light_and_viewer_may_change_places():
    """Of a single reflection; what is given back for later ones goes by the viewer alone, as in Cycles."""
    random = np.random.default_rng(0)
    a, b = (normalize(random.normal(size=(1000, 3)) * [1, 1, 0.5]).astype(np.float32) for _ in range(2))
    a[:, 2], b[:, 2] = np.abs(a[:, 2]) + 0.02, np.abs(b[:, 2]) + 0.02
    a, b = normalize(a), normalize(b)
    for alpha in (0.05, 0.3, 1.0):
        width = np.full(1000, alpha, np.float32)
        assert np.allclose(ggx.brdf(a, b, width), ggx.brdf(b, a, width), rtol=1e-3)


def test_a_narrow_lobe_is_a_mirror():
    at = points(0.03, 0.6, 1000, **MIRROR)
    direction, weight = at.drawn(r2_sequence(1000))
    assert np.abs(direction - [-0.8, 0, 0.6]).max(-1).mean() < 0.01
    assert np.allclose(weight, 1, atol=0.01)


def test_a_dielectric_reflects_as_fresnel_says():
    assert np.isclose(dielectric(np.float32([1.0]), 1.5)[0], 0.04)
    # At Brewster's angle only the part across the plane is reflected: half of sin²(90° − 2·θ_t).
    brewster = np.arctan(1.5)
    expected = np.sin(brewster - (np.pi / 2 - brewster)) ** 2 / 2
    assert np.isclose(dielectric(np.cos([brewster]), 1.5)[0], expected)
    cosine = np.sqrt((np.arange(4096) + 0.5) / 4096)
    assert np.isclose(dielectric(cosine, 1.5).mean(), fresnel_mean(1.5), rtol=0.05)
    assert dielectric(np.float32([0.3]), 1.0)[0] == 0


def test_a_shading_normal_that_looks_away_is_turned():
    scene = shapes.tracer([shapes.plate(0, 1)], material=glossy_material(0.5))
    view = normalize(np.float32([[1, 0, 0.1]]))
    away = normalize(np.float32([[-0.5, 0, 1]]))
    at = gloss.at(scene.geometry, np.zeros(1, np.int64), np.float32([[1, 0, 0]]), away, view)
    assert dot(at.normal, view)[0] > 0 and dot(at.normal, away)[0] > 0.8
    assert np.isfinite(at.drawn(np.float32([[0.3, 0.6]]))[1]).all()


def source(value):
    return ColorSource(np.broadcast_to(np.float32(value), 3))


def glossy_material(roughness, albedo=0.0, emission=0.0, specular=1.0):
    layer = Layer(source(roughness), source(specular), source(specular), source(1.0))
    return Material("glossy", source(albedo), source(emission), gloss=layer)


def seen(tracer, camera, settings):
    points = surfels.from_camera(tracer, camera)
    return tiles.finish(glossy_light(tracer, points, camera, 1, slice(0, camera.resolution[1]), settings))


def camera(size=16):
    """From the middle of a box, down to its floor."""
    return Camera("PERSPECTIVE", np.eye(4), (-0.7, 0.7, -0.7, 0.7), (size, size))


SETTINGS = RsmSettings(glossy=True, samples=64, light_samples=64)


def test_a_furnace_of_glossy_walls():
    """In a closed box that emits L everywhere and reflects ρ diffusely, its gloss shows L, and π L ρ/π at one bounce
    more."""
    tracer = shapes.tracer([shapes.box(1)], material=glossy_material(0.5, 0.6, 1.0))
    for bounces, expected in ((1, 0.6), (2, 0.6 + 0.36)):
        shown = seen(tracer, camera(), RsmSettings(glossy=True, samples=64, bounces=bounces))
        assert np.allclose(shown.color, 1, atol=0.01)
        assert np.isclose(shown.around.mean(), 1, rtol=0.01)
        assert np.isclose(shown.indirect.mean(), expected, rtol=0.02)


def test_an_even_sky_is_seen_as_it_is():
    sky = Environment(np.float32([0.2, 0.5, 1.0]))
    gold = glossy_material(0.7, specular=(0.9, 0.5, 0.1))
    tracer = shapes.tracer([shapes.plate(-1, 1)], material=gold, environment=sky)
    shown = seen(tracer, camera(), SETTINGS)
    assert np.allclose(shown.around.mean(0), sky.color, rtol=0.01)
    assert shown.indirect.max() == 0 and shown.lamps.max() == 0


def test_a_suns_highlight_holds_what_the_lobe_sends():
    """Radiance of a sun of E on a plane at right angles to it, seen from straight above: E f(n, n)."""
    tracer = shapes.tracer([shapes.plate(-1, 1)], [shapes.lamp("SUN", 2.0)], glossy_material(0.6))
    parallel = Camera("ORTHOGRAPHIC", np.eye(4), (-0.5, 0.5, -0.5, 0.5), (4, 4))
    shown = seen(tracer, parallel, SETTINGS)
    at = points(0.6, 1.0, 1, **MIRROR)
    assert np.allclose(shown.lamps * shown.color, 2.0 * at.brdf(UP[None]), rtol=0.01)
    whole = 1 / (np.pi * 0.36**2) / 4
    assert np.isclose(ggx.brdf(UP[None], UP[None], np.float32([0.36]))[0], whole, rtol=1e-4)


def test_matte_surfaces_have_no_gloss_and_tiles_do_not_show(monkeypatch):
    assert len(seen(shapes.tracer([shapes.box(1)], [shapes.lamp("POINT", 10)]), camera(), SETTINGS).surfels) == 0
    tracer = shapes.tracer([shapes.box(1)], [shapes.lamp("POINT", 10, radius=0.1)], glossy_material(0.4, 0.5))
    first = seen(tracer, camera(), SETTINGS)
    monkeypatch.setattr("gi_bake.gi_core.rsm.glossy._PAIRS", 7 * SETTINGS.samples)
    again = seen(tracer, camera(), SETTINGS)
    for name in ("lamps", "around", "indirect", "color"):
        assert np.allclose(getattr(first, name), getattr(again, name), rtol=1e-4, atol=1e-6)
