# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI against Cycles' Diffuse Indirect: by rays alone it converges to it, and mixed with the screen too."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.ssgi.settings import SsgiSettings

SIDE, REFERENCE = 48, 1536


def smooth(depth):
    """Pixels whose depth is within 5 % of their neighbours': what lies on silhouettes is another thing in each."""
    step = [np.abs(np.diff(np.log(depth), axis=a)) > 0.05 for a in (0, 1)]
    jump = np.zeros(depth.shape, bool)
    jump[1:] |= step[0]
    jump[:-1] |= step[0]
    jump[:, 1:] |= step[1]
    jump[:, :-1] |= step[1]
    return ~jump


def indirect(**settings):
    job = Job("ssgi", resolution=SIDE, settings=SsgiSettings(denoise="none", antialias=1, frames=4, **settings))
    return tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job)).layers["Diffuse Indirect"]


@pytest.mark.parametrize("bounces", [1, 3])
@pytest.mark.parametrize("name", ["cornell", "sunlit_room"])
def test_rays_converge_to_cycles(sample, name, bounces):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    halves = [
        camera_reference(bpy.context.scene, bpy.context.view_layer, REFERENCE // 2, bounces, seed, (SIDE, SIDE), False)
        for seed in (21, 22)
    ]
    mask = smooth(halves[0]["Depth"][..., 0])
    a, b = (h["Diffuse Indirect"][mask] for h in halves)
    noise, reference = metrics.relmse(a, b) / 4, (a + b) / 2
    counts = (16, 64, 256)
    found = [indirect(mode="ray_traced", fallback="none", bounces=bounces, samples=n)[mask] for n in counts]
    errors = [metrics.relmse(x, reference) - noise for x in found]
    assert abs(metrics.bias(found[-1], reference)) < 0.015
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] < -0.85

    mixed = indirect(mode="mixed", bounces=bounces, samples=64)[mask]
    assert abs(metrics.bias(mixed, found[-1])) < 0.03


def test_probes_bring_light_from_off_the_screen():
    """A room whose lamp, a shining panel, is behind the camera: with probes at least twice as close to Cycles."""
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    scene.world = bpy.data.worlds.new("World")
    scene.world.color = 0, 0, 0
    bpy.ops.mesh.primitive_cube_add(size=2)
    bpy.context.object.data.materials.append(_material("White", "ShaderNodeBsdfDiffuse", (0.6, 0.6, 0.6, 1)))
    bpy.ops.mesh.primitive_plane_add(size=0.6, location=(0.4, -0.4, 0.95))
    panel = _material("Panel", "ShaderNodeEmission", (8, 8, 8, 1))
    bpy.context.object.data.materials.append(panel)
    bpy.ops.object.camera_add(location=(-0.2, 0, 0), rotation=(1.7, 0, 0.45))
    scene.camera = bpy.context.object
    scene.camera.data.angle, scene.camera.data.clip_start = 0.9, 0.01
    scene.render.resolution_x = scene.render.resolution_y = SIDE
    reference = camera_reference(scene, bpy.context.view_layer, 512, 1, 23, (SIDE, SIDE), False)["Diffuse Indirect"]
    error = {
        fallback: metrics.relmse(indirect(mode="screen_space", fallback=fallback, samples=32), reference)
        for fallback in ("none", "probes")
    }
    assert np.sqrt(error["probes"]) < 0.5 * np.sqrt(error["none"])


def _material(name, shader, color):
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    nodes = material.node_tree
    nodes.nodes.clear()
    node, output = nodes.nodes.new(shader), nodes.nodes.new("ShaderNodeOutputMaterial")
    node.inputs["Color"].default_value = color
    nodes.links.new(node.outputs[0], output.inputs["Surface"])
    return material
