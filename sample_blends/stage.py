# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What every sample has besides its meshes: an empty Cycles scene with a world, a camera, lamps."""

import math

import bpy
from mathutils import Vector


def empty_scene(resolution=(256, 256), world=(0, 0, 0)):
    """Blender's factory settings with nothing in them, Cycles, and a world of `world` W/(m²·sr)."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 256
    scene.render.resolution_x, scene.render.resolution_y = resolution
    # The plain sRGB curve: the picture in Blender is then the one in GI Bake's report.
    scene.view_settings.view_transform = "Standard"
    scene.world = bpy.data.worlds.new("World")
    scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (*world, 1)
    return scene


def camera(location, target, field_of_view):
    """The scene's camera, `field_of_view` [degrees] across the longer side of the picture."""
    data = bpy.data.cameras.new("Camera")
    data.angle = math.radians(field_of_view)
    obj = bpy.data.objects.new("Camera", data)
    _aim(obj, location, target)
    bpy.context.scene.camera = obj
    return obj


def lamp(kind, name, location, target, energy, color=(1, 1, 1), **settings):
    """A lamp of `kind` POINT, SPOT, AREA [W] or SUN [W/m²]; `settings` are its data-block's own, angles in radians."""
    data = bpy.data.lights.new(name, kind)
    data.energy = energy
    data.color = color
    for key, value in settings.items():
        setattr(data, key, value)
    obj = bpy.data.objects.new(name, data)
    _aim(obj, location, target)
    return obj


def _aim(obj, location, target):
    obj.location = location
    obj.rotation_euler = (Vector(target) - Vector(location)).to_track_quat("-Z", "Y").to_euler()
    bpy.context.scene.collection.objects.link(obj)
