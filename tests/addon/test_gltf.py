# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked light as glTF, read back by Blender's importer."""

import json

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.addon.write.results import export
from gi_bake.gi_core import tiles
from gi_bake.gi_core.rsm.settings import RsmSettings


def test_a_room_comes_back_with_the_same_picture(sample, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(sample("sunlit_room")))
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    settings = RsmSettings(samples=8, map_resolution=64, atlas="all", gltf=True, exposure=0.5, light_samples=4)
    lightmap = tiles.finish(bake(scene, view_layer, Job(target="lightmap", resolution=512, settings=settings)))
    paths = export(lightmap, tmp_path, view_layer.name)
    assert paths[-1] == tmp_path / "baked.glb"
    # What a camera sees of the same light, worked out for its pixels and not for texels.
    image = Job(resolution=96, settings=RsmSettings(samples=16, map_resolution=64, light_samples=8))
    expected = tiles.finish(bake(scene, view_layer, image)).layers["Combined"][..., :3]
    angle, matrix = scene.camera.data.angle, scene.camera.matrix_world.copy()

    data = (tmp_path / "baked.glb").read_bytes()
    document = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    assert document["asset"]["extras"]["exposure"] == 0.5
    bpy.ops.wm.read_homefile(use_empty=True)
    bpy.ops.import_scene.gltf(filepath=str(tmp_path / "baked.glb"))
    scene = bpy.context.scene
    names = {o.name for o in scene.objects if o.type == "MESH"}
    assert names == {place.name for page in lightmap.pages for place in page.places}
    eye = bpy.data.objects.new("eye", bpy.data.cameras.new("eye"))
    eye.matrix_world, eye.data.angle = matrix, angle
    scene.collection.objects.link(eye)
    scene.camera = eye
    scene.render.resolution_x, scene.render.resolution_y = 96, round(96 * expected.shape[0] / expected.shape[1])
    # Unlit materials are emission in Blender, for the camera alone.
    found = camera_reference(scene, bpy.context.view_layer, 16, 1, 3, (96, expected.shape[0]))["Emission"]
    assert found.shape == expected.shape
    shown = np.clip(expected * 0.5, 0, 1)
    difference = np.abs(found - shown).mean(-1)
    # Silhouettes and shadow borders are a pixel or texel off; the rest is the same light.
    assert np.median(difference) < 0.01 and (difference < 0.06).mean() > 0.9
    assert found.mean() == pytest.approx(shown.mean(), rel=0.05)
