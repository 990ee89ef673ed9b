# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light through a thin wall: none gets there by shadow rays, some without."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core import tiles
from gi_bake.gi_core.rsm.settings import RsmSettings


@pytest.fixture(scope="module")
def rooms(sample):
    """The scene and Cycles' layers of it; the lamp is on the left."""
    bpy.ops.wm.open_mainfile(filepath=str(sample("thin_wall")))
    scene = bpy.context.scene
    return scene, camera_reference(scene, bpy.context.view_layer, 256, 2, 3, (96, 48))


def sides(layers):
    """Mean indirect light of the lit and of the dark room."""
    light, x = layers["Diffuse Indirect"].mean(-1), layers["Position"][..., 0]
    lit = layers["Depth"][..., 0] < 1e9
    return np.array([light[lit & side].mean() for side in (x < -0.1, x > 0.1)])


def test_the_dark_room_is_as_dark_as_in_cycles(rooms):
    scene, cycles = rooms
    lit, dark = sides(cycles)
    for visibility in (True, False):
        settings = RsmSettings(bounces=2, visibility=visibility)
        result = tiles.finish(bake(scene, bpy.context.view_layer, Job(resolution=96, settings=settings)))
        ours = sides(result.layers)
        off = abs(ours[1] - dark) / lit
        assert off <= 0.02 if visibility else off > 0.1
    assert dark < 1e-4 * lit
