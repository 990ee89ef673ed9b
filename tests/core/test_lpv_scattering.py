# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Single scattering against closed forms: an even field, a point lamp in an open medium, the phase function."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import sh, tiles
from gi_bake.gi_core.lpv import LpvSettings, scattering
from gi_bake.gi_core.lpv.grid import fitted
from gi_bake.gi_core.lpv.volume import Level, Volume
from gi_bake.gi_core.scene import Camera
from gi_bake.tests import shapes
from gi_bake.tests.core.test_sh import sphere

FOG = LpvSettings(fog_density=0.7, fog_albedo=0.6, box="-2 -2 -2 2 2 2")


def camera(z=1.0, side=4):
    """Looks down from the middle of the box, straight enough that all rays are as long."""
    matrix = np.eye(4)
    matrix[:3, 3] = (0, 0, z)
    return Camera("ORTHOGRAPHIC", matrix, (-0.5, 0.5, -0.5, 0.5), (side, side), (0.0, 100.0))


def even(radiance, bands):
    grid = fitted((-2, -2, -2), (2, 2, 2), 16)
    values = np.zeros((grid.size, bands, 3), np.float32)
    values[:, 0] = np.float32(radiance) * np.float32(np.pi) / sh.Y0
    return Volume((Level(grid, values),))


def fog(tracer, volume, settings, seen=None):
    seen = seen or camera()
    rows = slice(0, seen.resolution[1])
    return tiles.finish(scattering.scattered(tracer, seen, 1, rows, volume, settings))


@pytest.mark.parametrize("bands", [4, 9])
@pytest.mark.parametrize("g", [0.0, 0.6])
def test_an_even_field(bands, g):
    """Radiance L from all around gives albedo L (1 − e^(−σ d)), whatever the phase function."""
    settings = replace(FOG, fog_anisotropy=g)
    for tracer, distance in ((shapes.tracer([]), 3.0), (shapes.tracer([shapes.box(1.5)]), 2.5)):
        (_, indirect), through = fog(tracer, even((1, 2, 3), bands), settings)
        assert np.allclose(through, np.exp(-0.7 * distance), rtol=1e-4)
        assert np.allclose(indirect, 0.6 * (1 - np.exp(-0.7 * distance)) * np.float32([1, 2, 3]), rtol=1e-4)


def test_no_medium_beside_the_box():
    (direct, indirect), through = fog(shapes.tracer([]), even((1, 1, 1), 4), replace(FOG, box="2 2 -2 4 4 2"))
    assert not direct.any() and not indirect.any() and np.all(through == 1)


def lamps(g, shadow=None):
    """Radiance along the axis from a lamp of 4π W/sr a metre aside, beside the same integrated numerically."""
    lamp = shapes.lamp("POINT", 16 * np.pi**2, (1, 0, 0.2))
    things = [] if shadow is None else [shadow]
    eye = camera(side=1)
    settings = replace(FOG, fog_anisotropy=g, fog_steps=1024)
    (direct, _), _ = fog(shapes.tracer(things, [lamp]), Volume(()), settings, eye)
    t = (np.arange(30000) + 0.5) / 10000
    to = np.stack([np.ones_like(t), 0 * t, 0.2 - (1 - t)], -1)
    r = np.linalg.norm(to, axis=-1)
    cosine = -to[:, 2] / r
    p = (1 - g * g) / (4 * np.pi) / (1 + g * g - 2 * g * cosine) ** 1.5
    expected = 0.6 * 0.7 * np.sum(np.exp(-0.7 * (t + r)) * 4 * np.pi / r**2 * p) / 10000
    return direct[0, 0], expected


@pytest.mark.parametrize("g", [0.0, 0.5, -0.5])
def test_a_point_lamp_in_a_medium(g):
    found, expected = lamps(g)
    assert np.isclose(found, expected, rtol=2e-3)


def test_a_shadow_in_a_medium():
    wall = shapes.quad((0.5, -9, -9), (0.5, 9, -9), (0.5, 9, 9), (0.5, -9, 9))
    assert lamps(0.0, wall)[0] == 0


def test_the_phase_function_and_its_bands():
    d = sphere(20000)
    for g in (0.0, 0.5, -0.3):
        values = scattering.phase(d[:, 2], g)
        assert np.isclose(values.mean() * 4 * np.pi, 1, rtol=1e-3)
        assert np.isclose((values * d[:, 2]).mean() * 4 * np.pi, g, atol=1e-3), "the mean cosine"


def test_light_that_goes_on_ahead():
    """Light from before the viewer: the volume's two bands are scattered as the phase function's two are."""
    grid = fitted((-2, -2, -2), (2, 2, 2), 16)
    values = np.zeros((grid.size, 4, 3), np.float32)
    values[:] = (sh.cosine_lobe(np.float32([0, 0, -1])))[:, None]
    volume = Volume((Level(grid, values),))
    taken = 0.6 * (1 - np.exp(-0.7 * 3))
    for g in (0.0, 0.5, -0.3):
        (_, indirect), _ = fog(shapes.tracer([]), volume, replace(FOG, fog_anisotropy=g))
        # A beam of 1 W/m² has the radiance bands 1/4π and 3/4π cosθ.
        assert np.allclose(indirect, taken * max(0, 1 + 3 * g) / (4 * np.pi), rtol=1e-3, atol=1e-6)
