# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direct light of every lamp against Cycles' Diffuse Direct, on a lit plane with a ball on it."""

import math

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings

SIZE = 48

# Kind, settings of the lamp, scale of its object.
LAMPS = {
    "point": ("POINT", {"energy": 60, "shadow_soft_size": 0}, (1, 1, 1)),
    "sphere": ("POINT", {"energy": 60, "shadow_soft_size": 0.4, "use_soft_falloff": False}, (1, 1, 1)),
    "soft sphere": ("POINT", {"energy": 60, "shadow_soft_size": 0.4, "use_soft_falloff": True}, (1, 1, 1)),
    "spot": (
        "SPOT",
        {"energy": 90, "shadow_soft_size": 0, "spot_size": math.radians(50), "spot_blend": 0.4},
        (1, 1, 1),
    ),
    "sharp spot": (
        "SPOT",
        {"energy": 90, "shadow_soft_size": 0, "spot_size": math.radians(80), "spot_blend": 0},
        (1, 1, 1),
    ),
    "wide spot": (
        "SPOT",
        {"energy": 90, "shadow_soft_size": 0.1, "spot_size": math.radians(170), "spot_blend": 0.2},
        (1, 1, 1),
    ),
    "fat spot": (
        "SPOT",
        {
            "energy": 90,
            "shadow_soft_size": 0.3,
            "spot_size": math.radians(50),
            "spot_blend": 0.5,
            "use_soft_falloff": False,
        },
        (1, 1, 1),
    ),
    "soft fat spot": (
        "SPOT",
        {
            "energy": 90,
            "shadow_soft_size": 0.3,
            "spot_size": math.radians(50),
            "spot_blend": 0.5,
            "use_soft_falloff": True,
        },
        (1, 1, 1),
    ),
    "scaled spot": (
        "SPOT",
        {"energy": 90, "shadow_soft_size": 0, "spot_size": math.radians(50), "spot_blend": 0.4},
        (1.6, 0.8, 1.2),
    ),
    "square": ("AREA", {"energy": 30, "shape": "SQUARE", "size": 0.8}, (1, 1, 1)),
    "rectangle": ("AREA", {"energy": 30, "shape": "RECTANGLE", "size": 1.2, "size_y": 0.3}, (1, 1, 1)),
    "disk": ("AREA", {"energy": 30, "shape": "DISK", "size": 0.8}, (1, 1, 1)),
    "ellipse": ("AREA", {"energy": 30, "shape": "ELLIPSE", "size": 1.2, "size_y": 0.4}, (1, 1, 1)),
    "scaled square": ("AREA", {"energy": 30, "shape": "SQUARE", "size": 0.5}, (2, 0.7, 1)),
    "spread": ("AREA", {"energy": 30, "shape": "SQUARE", "size": 0.8, "spread": math.radians(70)}, (1, 1, 1)),
    "narrow spread": ("AREA", {"energy": 30, "shape": "DISK", "size": 1.5, "spread": math.radians(15)}, (1, 1, 1)),
    "sun": ("SUN", {"energy": 2, "angle": 0}, (1, 1, 1)),
    "soft sun": ("SUN", {"energy": 2, "angle": math.radians(20)}, (1, 1, 1)),
    "exposed": ("POINT", {"energy": 60, "shadow_soft_size": 0.1, "exposure": -1.5}, (1, 1, 1)),
    "warm": ("POINT", {"energy": 60, "shadow_soft_size": 0.1, "use_temperature": True, "temperature": 3200}, (1, 1, 1)),
    "not normalized": (
        "AREA",
        {"energy": 30, "shape": "RECTANGLE", "size": 0.5, "size_y": 0.4, "normalize": False},
        (1, 1, 1),
    ),
    "coloured": ("SUN", {"energy": 2, "angle": 0.1, "color": (1, 0.5, 0.1)}, (1, 1, 1)),
}


def white(name, color=0.8):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    output, diffuse = nodes.new("ShaderNodeOutputMaterial"), nodes.new("ShaderNodeBsdfDiffuse")
    diffuse.inputs["Color"].default_value = (color, color, color, 1)
    material.node_tree.links.new(diffuse.outputs[0], output.inputs["Surface"])
    return material


@pytest.fixture
def lit_plane():
    """A plane with a ball, seen from above; the lamp, slanted, comes with the test."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.data.materials.append(white("Plane"))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.3, location=(0.5, 0.2, 0.6), segments=32, ring_count=16)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(white("Ball"))
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 3.6
    camera.location = (0, 0, 10)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    return scene


def add_lamp(scene, kind, settings, scale):
    light = bpy.data.lights.new("Lamp", kind)
    for name, value in settings.items():
        setattr(light, name, value)
    lamp = bpy.data.objects.new("Lamp", light)
    lamp.location, lamp.rotation_euler, lamp.scale = (-0.6, 0.3, 1.9), (0.25, -0.3, 0.4), scale
    scene.collection.objects.link(lamp)


def compared(scene, samples):
    settings = RsmSettings(antialias=4, light_samples=16 * 16, samples=16)
    ours = tiles.finish(bake(scene, bpy.context.view_layer, Job(settings=settings))).layers["Diffuse Direct"]
    cycles = camera_reference(scene, bpy.context.view_layer, samples, 1, 7)["Diffuse Direct"]
    return ours, cycles


def smooth_places(image):
    """Where nothing jumps from pixel to pixel: (h, w, 3) -> (h, w) bool. Hard shadows' and cones' edges are left
    out."""
    jump = np.zeros(image.shape[:2], bool)
    for axis in (0, 1):
        step = np.abs(np.diff(image.mean(-1), axis=axis)) > 0.12 * image.mean()
        low, high = [[(0, 0), (0, 0)] for _ in range(2)]
        low[axis], high[axis] = (1, 0), (0, 1)
        jump |= np.pad(step, low) | np.pad(step, high)
    return ~jump


@pytest.mark.parametrize("name", LAMPS)
def test_lamp(lit_plane, name):
    kind, settings, scale = LAMPS[name]
    add_lamp(lit_plane, kind, settings, scale)
    ours, cycles = compared(lit_plane, 512)
    assert cycles.max() > 0.05
    assert abs(metrics.bias(ours, cycles)) < 0.01
    smooth = smooth_places(cycles)
    assert smooth.mean() > 0.5
    assert metrics.relmse(ours[smooth], cycles[smooth]) <= 0.002


def test_sky(lit_plane):
    world = bpy.data.worlds.new("World")
    world.use_nodes = True
    world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.2, 0.4, 0.8, 1)
    lit_plane.world = world
    ours, cycles = compared(lit_plane, 512)
    assert abs(metrics.bias(ours, cycles)) < 0.01
    assert metrics.relmse(ours, cycles) <= 0.002


def test_cornell(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    scene = bpy.context.scene
    scene.render.resolution_x = scene.render.resolution_y = 96
    ours, cycles = compared(scene, 256)
    assert abs(metrics.bias(ours, cycles)) < 0.01
    smooth = smooth_places(cycles)
    assert metrics.relmse(ours[smooth], cycles[smooth]) <= 0.002
