# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What Cycles makes of a scene: the light that a bake is measured against, without colour: E/π."""

import tempfile
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import exr
from ...gi_core.tiles import slices, whole
from .bake_targets import bake_image, materials_with, vertex_colors
from .reference_scene import own_camera, reference_scene

PASSES = (
    "diffuse_direct", "diffuse_indirect", "diffuse_color", "glossy_direct", "glossy_indirect", "glossy_color", "emit",
    "environment", "normal", "position", "z",
)  # fmt: skip

# Samples of all points that Cycles takes in about a second on two cores.
GO = 1 << 20

# Of a pixel's first sample, not the mean of all.
_OF_FIRST = {"Depth", "Position"}


def camera_passes(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    samples: int,
    bounces: int,
    seed: int,
    resolution: tuple[int, int] | None = None,
    antialias: bool = True,
    go: int = 0,
) -> Iterator[float]:
    """The camera's view at the current frame: Blender 5's pass name -> (h, w, c) float32. A generator of progress;
    between its steps the file is as it was.

    resolution: (width, height); None takes the scene's. antialias: a pixel is the mean over its square, or else its
        centre. Depth of field and motion blur are left out.
    go: samples of all points that Cycles takes at once, for each of which it builds its scene; 0 for all.
    Raises ValueError where the scene has no camera.
    """
    if scene.camera is None:
        raise ValueError(f"Scene '{scene.name}' has no camera: add one, or choose one in its properties")
    render = scene.render
    share = render.resolution_percentage / 100
    width, height = resolution or (round(render.resolution_x * share), round(render.resolution_y * share))
    total: dict[str, np.ndarray] = {}
    goes = _goes(samples, width * height, go)
    for go in goes:
        yield go.start / samples
        with reference_scene(scene, view_layer, samples, bounces, seed) as (copy, layer), own_camera(copy):
            if len(goes) == 1:
                return _rendered(copy, layer, resolution, antialias)
            _take(copy, go)
            _add(total, _rendered(copy, layer, resolution, antialias), (go.stop - go.start) / samples)
    for name in total:
        if (color := _color_of(name)) in total and name != color:
            total[name] = np.divide(total[name], total[color], out=np.zeros_like(total[name]), where=total[color] > 0)
    return total


def _rendered(copy, layer, resolution, antialias) -> dict[str, np.ndarray]:
    """All passes of a reference scene."""
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


def _goes(samples: int, points: int, go: int) -> list[slice]:
    """The samples of so many points, cut."""
    return slices(samples, go // max(1, points) if go else samples)


def _take(copy: bpy.types.Scene, go: slice) -> None:
    """Lets Cycles take some of a sequence's samples: all goes together are what one of all samples is."""
    copy.cycles.use_sample_subset = True
    copy.cycles.sample_offset, copy.cycles.sample_subset_length = go.start, go.stop - go.start


def _add(total: dict[str, np.ndarray], passes: dict[str, np.ndarray], share: float) -> None:
    """Adds the passes of a share of the samples; light by the colour that Cycles divided it by."""
    for name, image in passes.items():
        if name in _OF_FIRST:
            total.setdefault(name, image)
            continue
        color = _color_of(name)
        weight = passes[color] * share if color in passes and name != color else share
        total[name] = total.get(name, 0) + (image * weight).astype(np.float32)


def _color_of(name: str) -> str:
    """The pass that a pass of light without colour was divided by; any other name where there is none."""
    kind, _, part = name.rpartition(" ")
    return f"{kind} Color" if part in {"Direct", "Indirect"} else ""


def lightmap_passes(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    uv_maps: dict[str, str],
    resolution: int | dict[str, int],
    samples: int,
    bounces: int,
    seed: int,
    passes: tuple[str, ...] = ("INDIRECT",),
    go: int = 0,
) -> Iterator[float]:
    """Lightmaps at the current frame by `object.bake`: object name -> (resolution, resolution, 4) float32. A generator
    of progress; between its steps the file is as it was.

    uv_maps: object name -> the UV map to bake to. resolution: of all, or of each object.
    passes: "DIRECT", "INDIRECT" or both. go: as of `camera_passes`.
    The fourth channel is 1 on texels whose centre a face covers, 0 elsewhere; there is no margin.
    Raises ValueError for objects that are no mesh of the view layer or lack the UV map, RuntimeError where Cycles
    refuses.
    """
    for obj in _meshes(view_layer, uv_maps):
        if uv_maps[obj.name] not in obj.data.uv_layers:
            raise ValueError(f"Object '{obj.name}' has no UV map '{uv_maps[obj.name]}': unwrap it, or choose another")

    def baked(copy, layer, obj) -> np.ndarray:
        side = sides[obj.name]
        with bake_image(side) as image, materials_with(obj, image):
            _bake(copy, layer, obj, passes, target="IMAGE_TEXTURES", uv_layer=uv_maps[obj.name])
            pixels = np.empty((side, side, 4), np.float32)
            image.pixels.foreach_get(pixels.ravel())
            return pixels

    sides = resolution if isinstance(resolution, dict) else dict.fromkeys(uv_maps, resolution)
    goes = _goes(samples, max(sides.values(), default=1) ** 2, go)
    return (yield from _each(scene, view_layer, uv_maps, goes, (samples, bounces, seed), baked))


def vertex_passes(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    names: list[str],
    samples: int,
    bounces: int,
    seed: int,
    passes: tuple[str, ...] = ("INDIRECT",),
    go: int = 0,
) -> Iterator[float]:
    """Light at the face corners of objects' own meshes by `object.bake`: object name -> (corners, 3) float32. A
    generator of progress; between its steps the file is as it was.

    For an attribute of points Blender takes the mean of just these, those inside of walls included.
    go: as of `camera_passes`.
    Raises ValueError for objects that are no mesh of the view layer, RuntimeError where Cycles refuses.
    """

    def baked(copy, layer, obj) -> np.ndarray:
        with vertex_colors(obj.data) as name:
            _bake(copy, layer, obj, passes, target="VERTEX_COLORS")
            rgba = np.empty((len(obj.data.loops), 4), np.float32)
            obj.data.attributes[name].data.foreach_get("color", rgba.ravel())
            return rgba[:, :3].copy()

    most = max((len(obj.data.loops) for obj in _meshes(view_layer, names)), default=1)
    return (yield from _each(scene, view_layer, names, _goes(samples, most, go), (samples, bounces, seed), baked))


def _each(scene, view_layer, names, goes, terms, baked) -> Iterator[float]:
    """`baked(copy, layer, object)` of each object, as the mean of all goes: name -> array. A generator of progress."""
    found, samples = {}, terms[0]
    for k, name in enumerate(names):
        total = 0.0
        for go in goes:
            yield (k + go.start / samples) / len(names)
            # Looked up anew: whoever waits may have changed the file.
            [obj] = _meshes(view_layer, [name])
            with reference_scene(scene, view_layer, *terms) as (copy, layer):
                if len(goes) > 1:
                    _take(copy, go)
                pixels = baked(copy, layer, obj)
            total = pixels if len(goes) == 1 else total + pixels * np.float32((go.stop - go.start) / samples)
        found[name] = total
    return found


camera_reference, lightmap_reference, vertex_reference = map(whole, (camera_passes, lightmap_passes, vertex_passes))


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
