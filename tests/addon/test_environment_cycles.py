# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light of worlds with images and skies against Cycles, on a plane with a ball over it."""

import math

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings

SIZE = 32


def diffuse(name, color):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    output, shader = tree.nodes.new("ShaderNodeOutputMaterial"), tree.nodes.new("ShaderNodeBsdfDiffuse")
    shader.inputs["Color"].default_value = (*color, 1)
    tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


@pytest.fixture
def plane():
    """A plane with a ball over it, seen from above; the scene."""
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.mesh.primitive_plane_add(size=4)
    bpy.context.object.data.materials.append(diffuse("Plane", (0.8, 0.7, 0.6)))
    bpy.ops.mesh.primitive_uv_sphere_add(radius=0.5, location=(0.4, 0.2, 0.8), segments=48, ring_count=24)
    bpy.ops.object.shade_smooth()
    bpy.context.object.data.materials.append(diffuse("Ball", (0.3, 0.5, 0.8)))
    scene = bpy.context.scene
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 3.6
    camera.location = (0, 0, 10)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = SIZE
    return scene


def sky_image(sun):
    """A packed float image: a gradient, blue above and brown below, and a disk of 3° of so much radiance 50° up."""
    h, w = 128, 256
    up, around = np.meshgrid(np.pi * ((np.arange(h) + 0.5) / h - 0.5), -2 * np.pi * ((np.arange(w) + 0.5) / w - 0.5),
                             indexing="ij")  # fmt: skip
    direction = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], -1)
    share = (direction[..., 2:] + 1) / 2
    pixels = np.ones((h, w, 4), np.float32)
    pixels[..., :3] = (1 - share) * [0.3, 0.2, 0.1] + share * [0.2, 0.4, 0.9]
    axis = np.array([math.cos(0.87) * math.cos(0.6), math.cos(0.87) * math.sin(0.6), math.sin(0.87)])
    pixels[direction @ axis > math.cos(math.radians(3)), :3] = np.array([1, 0.9, 0.7]) * sun
    image = bpy.data.images.new("sky", w, h, float_buffer=True, is_data=True)
    image.pixels.foreach_set(pixels.ravel())
    image.pack()
    return image


def background(scene):
    """The Background node of a new world."""
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    tree = scene.world.node_tree
    tree.nodes.clear()
    output, node = tree.nodes.new("ShaderNodeOutputWorld"), tree.nodes.new("ShaderNodeBackground")
    tree.links.new(node.outputs[0], output.inputs["Surface"])
    return tree, node


def image_world(scene, sun=300.0, turn=0.7):
    tree, node = background(scene)
    texture, mapping = tree.nodes.new("ShaderNodeTexEnvironment"), tree.nodes.new("ShaderNodeMapping")
    coordinates = tree.nodes.new("ShaderNodeTexCoord")
    texture.image = sky_image(sun)
    mapping.inputs["Rotation"].default_value = (0, 0, turn)
    tree.links.new(coordinates.outputs["Generated"], mapping.inputs["Vector"])
    tree.links.new(mapping.outputs[0], texture.inputs["Vector"])
    tree.links.new(texture.outputs[0], node.inputs["Color"])


def compared(scene, samples):
    settings = RsmSettings(antialias=4, samples=1024)
    result = tiles.finish(bake(scene, bpy.context.view_layer, Job(settings=settings)))
    return result, camera_reference(scene, bpy.context.view_layer, samples, 1, 7)


def test_image_with_a_sun(plane):
    image_world(plane)
    result, cycles = compared(plane, 1024)
    assert not result.approximated
    ours = result.layers
    direct, indirect = "Diffuse Direct", "Diffuse Indirect"
    assert cycles[direct].std() > 0.2 * cycles[direct].mean()
    assert abs(metrics.bias(ours[direct], cycles[direct])) < 0.01
    assert metrics.relmse(ours[direct], cycles[direct]) <= 0.002
    assert abs(metrics.bias(ours[indirect], cycles[indirect])) < 0.02


def sky_world(scene, mixed=False):
    """A Sky Texture with its sun, 30° up; `mixed`: for all but the camera, which sees plain red."""
    tree, node = background(scene)
    sky = tree.nodes.new("ShaderNodeTexSky")
    sky.sun_elevation, sky.sun_rotation, sky.sun_intensity = math.radians(30), 2.0, 0.2
    node.inputs["Strength"].default_value = 0.1
    tree.links.new(sky.outputs[0], node.inputs["Color"])
    if mixed:
        path, mix, red = (tree.nodes.new(f"ShaderNode{kind}") for kind in ("LightPath", "MixShader", "Background"))
        red.inputs["Color"].default_value = (5, 0, 0, 1)
        tree.links.new(path.outputs["Is Camera Ray"], mix.inputs[0])
        tree.links.new(node.outputs[0], mix.inputs[1])
        tree.links.new(red.outputs[0], mix.inputs[2])
        tree.links.new(mix.outputs[0], tree.nodes["World Output"].inputs["Surface"])


@pytest.mark.parametrize("mixed", [False, True])
def test_sky_texture(plane, mixed):
    sky_world(plane, mixed)
    before = {name: len(getattr(bpy.data, name)) for name in ("worlds", "scenes", "images", "cameras", "objects")}
    result, cycles = compared(plane, 512)
    assert before == {name: len(getattr(bpy.data, name)) for name in before}
    assert [note for note in result.approximated if note.startswith("World 'World': ")] == list(result.approximated)
    ours = result.layers
    direct, indirect = "Diffuse Direct", "Diffuse Indirect"
    # The sun alone lights more than half; red would be far off.
    assert cycles[direct].std() > 0.2 * cycles[direct].mean()
    for channel in range(3):
        assert abs(metrics.bias(ours[direct][..., channel], cycles[direct][..., channel])) < 0.015
    assert metrics.relmse(ours[direct], cycles[direct]) <= 0.002
    assert abs(metrics.bias(ours[indirect], cycles[indirect])) < 0.03
