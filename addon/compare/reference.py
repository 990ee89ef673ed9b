# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles makes of a scene: the light that a bake is measured against, without colour: E/π."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import exr
from .bake_targets import bake_image, materials_with, vertex_colors
from .reference_scene import own_camera, reference_scene

PASSES = (
    "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct", "glossy_indirect", "glossy_color", "emit",
    "environment", "normal", "position", "z",
)  # fmt: skip


def camera_reference(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    samples: int,
    bounces: int,
    seed: int,
    resolution: tuple[int, int] | None = None,
    antialias: bool = True,
) -> dict[str, np.ndarray]:
    """The camera's view at the current frame: Blender 5's pass name -> (h, w, c) float32.

    resolution: (width, height); None takes the scene's. antialias: a pixel is the mean over its square, or else its
        centre. Depth of field and motion blur are left out.
    Raises ValueError where the scene has no camera.
    """
    if scene.camera is None:
        raise ValueError(f"Scene '{scene.name}' has no camera: add one, or choose one in its properties")
    with reference_scene(scene, view_layer, samples, bounces, seed) as (copy, layer), own_camera(copy):
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "reference.exr"
            for name in PASSES:
                setattr(layer, f"use_pass_{name}", True)
            # Cycles has no filter of the width 0; this one falls off within a hundredth of a pixel.
            copy.cycles.pixel_filter_type = "BOX" if antialias else "GAUSSIAN"
            copy.cycles.filter_width = 0.01
            if resolution:
                copy.render.resolution_x, copy.render.resolution_y = resolution
                copy.render.resolution_percentage = 100
            settings = copy.render.image_settings
            if hasattr(settings, "media_type"):
                settings.media_type = "MULTI_LAYER_IMAGE"
            settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
            settings.color_management = "FOLLOW_SCENE"
            copy.render.filepath = str(path)
            bpy.ops.render.render(write_still=True, scene=copy.name)
            return exr.read_layers(path, layer.name)


def lightmap_reference(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    uv_maps: dict[str, str],
    resolution: int | dict[str, int],
    samples: int,
    bounces: int,
    seed: int,
    passes: tuple[str, ...] = ("INDIRECT",),
) -> dict[str, np.ndarray]:
    """Lightmaps at the current frame by `object.bake`: object name -> (resolution, resolution, 4) float32.

    uv_maps: object name -> the UV map to bake to. resolution: of all, or of each object.
    passes: "DIRECT", "INDIRECT" or both.
    The fourth channel is 1 on texels whose centre a face covers, 0 elsewhere; there is no margin.
    Raises ValueError for objects that are no mesh of the view layer or lack the UV map, RuntimeError where Cycles
    refuses.
    """
    objects = _meshes(view_layer, uv_maps)
    for obj in objects:
        if uv_maps[obj.name] not in obj.data.uv_layers:
            raise ValueError(f"Object '{obj.name}' has no UV map '{uv_maps[obj.name]}': unwrap it, or choose another")
    baked = {}
    with reference_scene(scene, view_layer, samples, bounces, seed) as (copy, layer):
        for obj in objects:
            side = resolution[obj.name] if isinstance(resolution, dict) else resolution
            with bake_image(side) as image, materials_with(obj, image):
                _bake(copy, layer, obj, passes, target="IMAGE_TEXTURES", uv_layer=uv_maps[obj.name])
                baked[obj.name] = np.empty((side, side, 4), np.float32)
                image.pixels.foreach_get(baked[obj.name].ravel())
    return baked


def vertex_reference(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    names: list[str],
    samples: int,
    bounces: int,
    seed: int,
    passes: tuple[str, ...] = ("INDIRECT",),
) -> dict[str, np.ndarray]:
    """Light at the face corners of objects' own meshes by `object.bake`: object name -> (corners, 3) float32.

    For an attribute of points Blender takes the mean of just these, those inside of walls included.
    Raises ValueError for objects that are no mesh of the view layer, RuntimeError where Cycles refuses.
    """
    baked = {}
    with reference_scene(scene, view_layer, samples, bounces, seed) as (copy, layer):
        for obj in _meshes(view_layer, names):
            with vertex_colors(obj.data) as name:
                _bake(copy, layer, obj, passes, target="VERTEX_COLORS")
                rgba = np.empty((len(obj.data.loops), 4), np.float32)
                obj.data.attributes[name].data.foreach_get("color", rgba.ravel())
                baked[obj.name] = rgba[:, :3].copy()
    return baked


def _meshes(view_layer, names):
    found = []
    for name in names:
        obj = view_layer.objects.get(name)
        if obj is None or obj.type != "MESH":
            raise ValueError(f"Object '{name}' is no mesh of the view layer '{view_layer.name}'")
        found.append(obj)
    return found


def _bake(scene, view_layer, obj, passes, **target):
    # What is not given here would be the user's, left in scene.render.bake.
    settings = {
        "type": "DIFFUSE",
        "pass_filter": set(passes),
        "margin": 0,
        "use_clear": True,
        "use_selected_to_active": False,
        "use_split_materials": False,
        "save_mode": "INTERNAL",
    }
    # The active object is not baked, but Blender asks it to be a mesh that viewports show, which `obj` may not be.
    active = bpy.data.objects.new("GI Bake reference", bpy.data.meshes.new("GI Bake reference"))
    scene.collection.objects.link(active)
    context = {"scene": scene, "view_layer": view_layer, "object": active, "active_object": active}
    try:
        with bpy.context.temp_override(**context, selected_objects=[obj]):
            bpy.ops.object.bake(**settings, **target)
    finally:
        bpy.data.meshes.remove(active.data)  # takes the object along
