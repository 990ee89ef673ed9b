# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the reader makes of worlds against what Cycles does with them, in tiny renders."""

import math

import bpy
import numpy as np
import pytest
from gi_bake.tests.shader_trees import Tree, brightness, image, link, material, overhead_camera, read, render, square


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


@pytest.fixture
def white_square():
    tree = material("white")
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=(1.0, 1.0, 1.0))), size=0.1)
    overhead_camera(0.1, 0.1)


def world():
    """The node tree of a new world, and a function that gives it a Background."""
    bpy.context.scene.world = bpy.data.worlds.new("world")
    tree = Tree(bpy.context.scene.world)
    return tree, lambda **inputs: tree.surface(tree.node("ShaderNodeBackground", **inputs), "ShaderNodeOutputWorld")


def seen_around(tmp_path):
    """Directions (n, 3) and what Cycles shows of the world along them (n, 3)."""
    directions, colors = [], []
    camera = link(bpy.data.cameras.new("camera"))
    camera.data.lens, camera.data.sensor_width = 18, 36
    bpy.context.scene.world.cycles.sampling_method = "NONE"  # spares the map of where light comes from
    bpy.context.scene.camera = camera
    for turn in ((math.pi / 2, 0, 0), (math.pi / 2, 0, 2), (math.pi / 2, 0, -2), (0, 0, 0), (math.pi, 0, 0)):
        camera.rotation_euler = turn
        shown = render(tmp_path, 8, 8)["Combined"]
        across = (np.arange(8) + 0.5) / 4 - 1
        x, y = np.meshgrid(across, across)
        local = np.stack([x, y, np.full_like(x, -1)], -1).reshape(-1, 3)
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        directions.append(local @ np.array(camera.matrix_world)[:3, :3].T)
        colors.append(shown.reshape(-1, 3))
    return np.concatenate(directions), np.concatenate(colors)


def direction_image():
    """An equirectangular image whose colour is (1 + direction)/2."""
    row, column = np.indices((128, 256))
    up, around = np.pi * ((row + 0.5) / 128 - 0.5), -2 * np.pi * ((column + 0.5) / 256 - 0.5)
    direction = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], -1)
    return image(np.concatenate([(1 + direction) / 2, np.ones((128, 256, 1))], -1), "around", float_buffer=True)


@pytest.mark.parametrize(
    "mapping",
    [None, {}, {"vector_type": "TEXTURE"}, {"vector_type": "VECTOR"}, {"vector_type": "NORMAL"}],
    ids=str,
)
def test_world_image(tmp_path, mapping):
    tree, background = world()
    settings = {"image": direction_image()}
    vector = {}
    if mapping is not None:
        coordinates = tree.node("ShaderNodeTexCoord", "Generated")
        vector["Vector"] = tree.node("ShaderNodeMapping", set=mapping, Vector=coordinates, Rotation=(0.3, -0.5, 1.2))
    background(Color=tree.node("ShaderNodeTexEnvironment", set=settings, **vector), Strength=1.5)
    directions, shown = seen_around(tmp_path)
    scene = read()
    assert scene.environment.color == pytest.approx([1.5] * 3) and not scene.approximated
    sought = directions @ scene.environment.rotation.T
    away = np.abs(sought[:, 2]) < 0.999  # Cycles mixes the two poles in the last half texel
    assert np.allclose(1.5 * (1 + sought[away]) / 2, shown[away], atol=5e-3)


def test_plain_worlds(tmp_path):
    _, background = world()
    background(Color=(0.2, 0.4, 0.8), Strength=2.0)
    _, shown = seen_around(tmp_path)
    assert read().environment.color == pytest.approx(shown.mean(0), rel=1e-4)
    assert read().approximated == ()


def test_world_for_the_camera_is_not_that_which_lights(tmp_path, white_square):
    """The usual trick: a Light Path node gives the camera another world than surfaces get their light from."""
    tree, _ = world()
    mix = tree.node("ShaderNodeMixShader")
    tree.tree.links.new(tree.node("ShaderNodeLightPath", "Is Camera Ray"), mix.node.inputs[0])
    for slot, color in ((1, (0.1, 0.2, 0.3)), (2, (5.0, 5.0, 5.0))):
        tree.tree.links.new(tree.node("ShaderNodeBackground", Color=color), mix.node.inputs[slot])
    tree.surface(mix, "ShaderNodeOutputWorld")
    scene = read()
    assert scene.environment.color == pytest.approx(brightness(tmp_path), rel=0.01)
    assert "World 'world'" in scene.approximated[0]


def test_world_that_diffuse_surfaces_do_not_see_is_black(tmp_path, white_square):
    _, background = world()
    background(Color=(0.2, 0.4, 0.8)).cycles_visibility.diffuse = False
    assert not brightness(tmp_path).any()
    assert not read().environment.color.any()


def test_no_world():
    assert not read().environment.color.any()
