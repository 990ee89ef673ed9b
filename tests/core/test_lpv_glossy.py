# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Glossy surfaces that look their light up in the volume, against closed forms."""

from functools import partial

import numpy as np
import pytest
from gi_bake.gi_core import lpv, sh, tiles
from gi_bake.gi_core.lpv import LpvSettings
from gi_bake.gi_core.lpv.grid import fitted
from gi_bake.gi_core.lpv.volume import Level, Volume
from gi_bake.gi_core.rsm.glossy import glossy_light
from gi_bake.gi_core.surfels import from_camera
from gi_bake.tests import shapes
from gi_bake.tests.core.test_gloss import glossy_material
from gi_bake.tests.core.test_lpv_scattering import camera, even

SETTINGS = LpvSettings(glossy=True, samples=256, glossy_lookup="volume")


def shown(volume, roughness):
    """What a glossy plate reflects of a volume straight up, over its colour."""
    tracer, eye = shapes.tracer([shapes.plate(0, 1)], material=glossy_material(roughness)), camera(side=4)
    points = from_camera(tracer, eye)
    field = partial(lpv.radiance, tracer, volume=volume, settings=SETTINGS)
    return tiles.finish(glossy_light(tracer, points, eye, 1, slice(0, 4), SETTINGS, field)).indirect


@pytest.mark.parametrize("bands", [4, 9])
@pytest.mark.parametrize("roughness", [0.05, 0.5, 1.0])
def test_an_even_field_shows_as_it_is(bands, roughness):
    found = shown(even((1, 2, 3), bands), roughness)
    assert np.allclose(found, [1, 2, 3], rtol=0.01 if roughness < 1 else 0.05)


def test_a_mirror_shows_the_bands_in_its_direction():
    """Of radiance 1 + cosθ from above the smoothest surface shows 2, a rough one less, one that looks down nothing."""
    grid = fitted((-2, -2, -2), (2, 2, 2), 16)
    values = np.zeros((grid.size, 4, 3), np.float32)
    # Its irradiance is π + 2π/3 cosθ.
    values[:, 0], values[:, 2] = np.pi / sh.Y0, 2 * np.pi / 3 / sh.basis(np.float32([0, 0, 1]))[2]
    volume = Volume((Level(grid, values),))
    smooth, rough = (shown(volume, roughness).mean() for roughness in (0.02, 0.8))
    assert np.isclose(smooth, 2, rtol=2e-3)
    assert 1.4 < rough < 1.9
    values[:, 2] *= -1
    assert shown(volume, 0.02).max() < 0.01
