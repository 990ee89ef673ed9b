# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The box of a volume from an object."""

import bpy
import numpy as np
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.addon.read.box import box_corners
from gi_bake.gi_core.lpv import LpvSettings
from gi_bake.gi_core.lpv.grid import box
from gi_bake.gi_core.tiles import finish


def test_empties_and_meshes_are_boxes():
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    bpy.ops.object.empty_add(location=(1, 2, 3))
    empty = bpy.context.object
    empty.name, empty.empty_display_size, empty.scale = "Room", 2.0, (1, 0.5, 0.25)
    bpy.ops.mesh.primitive_cube_add(size=2, location=(0, 0, 5))
    bpy.context.object.name = "Cube of mine"
    bpy.context.view_layer.update()
    assert np.allclose(box(box_corners("Room", scene)), [[-1, 1, 2.5], [3, 3, 3.5]])
    assert np.allclose(box(box_corners("Cube of mine", scene)), [[-1, -1, 4], [1, 1, 6]])
    assert box_corners("0 0 0 1 1 1", scene) == "0 0 0 1 1 1"


def test_a_volume_covers_the_box_it_is_given(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    bpy.ops.object.empty_add(location=(0, 0, 1))
    bpy.context.object.name, bpy.context.object.empty_display_size = "Half", 0.5
    bpy.context.view_layer.update()
    settings = LpvSettings(cells=16, cascades=1, box="Half", map_resolution=64)
    job = Job(method="lpv", target="volume", settings=settings)
    [level] = finish(bake(bpy.context.scene, bpy.context.view_layer, job)).volume.levels
    assert np.allclose(level.grid.low + level.grid.cell, [-0.5, -0.5, 0.5], atol=1e-4)
