# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera as the reader gives it, against Blender's own projections."""

import itertools

import bpy
import numpy as np
import pytest
from gi_bake.addon.read import read_scene
from mathutils import Vector

from bpy_extras.object_utils import world_to_camera_view


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def add_camera(**attributes):
    data = bpy.data.cameras.new("camera")
    for attribute, value in attributes.items():
        setattr(data, attribute, value)
    camera = bpy.data.objects.new("camera", data)
    bpy.context.scene.collection.objects.link(camera)
    bpy.context.scene.camera = camera
    camera.location, camera.rotation_euler, camera.scale = (1, -6, 2), (1.3, 0.1, 0.2), (2, 3, 0.5)
    return camera


def read():
    return read_scene(bpy.context.scene, bpy.context.view_layer)


def image_position(camera, points):
    """(n, 3) world points to (n, 2), 0…1 over the image from left and bottom."""
    x, y, z = (np.linalg.inv(camera.matrix) @ np.c_[points, np.ones(len(points))].T)[:3]
    left, right, bottom, top = camera.window
    depth = -z if camera.kind == "PERSPECTIVE" else 1.0
    return np.c_[(x / depth - left) / (right - left), (y / depth - bottom) / (top - bottom)]


@pytest.mark.parametrize("kind", ["PERSP", "ORTHO"])
@pytest.mark.parametrize("fit", ["AUTO", "HORIZONTAL", "VERTICAL"])
@pytest.mark.parametrize("resolution", [(640, 360), (360, 640)])
@pytest.mark.parametrize("aspect", [(1.0, 1.0), (1.0, 2.5), (1.7, 1.0)])
def test_projection(kind, fit, resolution, aspect):
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y = resolution
    render.pixel_aspect_x, render.pixel_aspect_y = aspect
    camera = add_camera(
        type=kind, sensor_fit=fit, lens=31, sensor_width=30, sensor_height=21, ortho_scale=7, shift_x=0.2, shift_y=-0.3
    )
    found = read().camera
    points = np.array(list(itertools.product((-1, 2), (0, 3), (-1, 1.5))), float)
    expected = [world_to_camera_view(bpy.context.scene, camera, Vector(point))[:2] for point in points]
    assert np.allclose(image_position(found, points), expected, atol=1e-5)
    assert found.resolution == resolution


def test_projection_is_that_of_the_render_matrix():
    render = bpy.context.scene.render
    render.resolution_x, render.resolution_y, render.resolution_percentage = 333, 200, 37
    camera = add_camera(shift_x=0.1, lens=50)
    found = read().camera
    assert found.resolution == (123, 74)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    projection = np.array(camera.calc_matrix_camera(depsgraph, x=123, y=74))
    points = np.random.default_rng(2).normal(size=(20, 3))
    clip = projection @ np.linalg.inv(found.matrix) @ np.c_[points, np.ones(20)].T
    assert np.allclose(image_position(found, points), (clip[:2] / clip[3] / 2 + 0.5).T, atol=1e-5)


def test_matrix_without_scale_and_clip_distances():
    camera = add_camera(clip_start=0.25, clip_end=77)
    found = read().camera
    assert np.allclose(found.matrix, camera.matrix_world.normalized(), atol=1e-6)
    assert found.clip == pytest.approx((0.25, 77))


def test_border_is_ignored():
    add_camera()
    whole = read().camera
    render = bpy.context.scene.render
    render.use_border, render.border_min_x, render.border_max_x = True, 0.3, 0.6
    assert read().camera.window == whole.window and read().camera.resolution == whole.resolution


def test_what_is_not_taken_is_told():
    add_camera(type="PANO")
    scene = read()
    assert scene.camera is None and "Camera 'camera'" in scene.approximated[0]
    bpy.context.scene.camera.data.type = "PERSP"
    bpy.context.scene.camera.data.dof.use_dof = True
    assert "depth of field" in read().approximated[0]


def test_an_object_that_is_no_camera():
    bpy.context.scene.camera = bpy.data.objects.new("empty", None)
    bpy.context.scene.collection.objects.link(bpy.context.scene.camera)
    assert read().camera is None and "'empty'" in read().approximated[0]


def test_no_camera():
    assert read().camera is None
    assert bpy.context.scene.camera is None and not bpy.data.cameras
