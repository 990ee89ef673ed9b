# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmap UVs for every mesh of a scene, by Blender's own unwrapper and packer."""

import math

import bpy

NAME = "Lightmap"
MARGIN = 0.01  # of the map's side around each island: 5 texels between two at 256², 1 at 64²


def unwrap_all(scene):
    """Give each mesh object of `scene` a UV map `NAME`: every face in [0, 1] once, one texel density per object."""
    done = set()
    for obj in scene.objects:
        if obj.type == "MESH" and obj.data not in done:
            _unwrap(obj)
            done.add(obj.data)


def _unwrap(obj):
    layers = obj.data.uv_layers
    layers.active = layers.new(name=NAME)
    bpy.context.view_layer.objects.active = obj
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    # 45 degrees: at the default of 66 Suzanne's islands overlap.
    bpy.ops.uv.smart_project(angle_limit=math.radians(45), island_margin=MARGIN, margin_method="FRACTION")
    bpy.ops.object.mode_set(mode="OBJECT")
