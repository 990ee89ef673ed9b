# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The list of a scene's results: put there, compared, taken away."""

import json
import uuid
from collections.abc import Sequence
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import display, exr
from .compare.subject import Subject
from .result import Result
from .write.attributes import ATTRIBUTE, CORNERS, COVERAGE
from .write.images import MARK, file_stem
from .write.placement import LIGHT
from .write.results import export, store

# Blender's scene-linear space, in which light is.
_SPACE = "Linear Rec.709"

# What a comparison shows: an image of each, and their names.
LAYERS = {"BAKED": "Baked", "CYCLES": "Cycles", "DIFFERENCE": "Difference"}


def put(
    result: Result, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, folder: Path | None, seconds: float
) -> bpy.types.PropertyGroup:
    """Stores a result in the file and in the scene's list, where it takes the place of what it replaces; its line.

    folder: for files; None where all is kept in the .blend.
    """
    target = result.job.target
    # Files first: a full disk is found before the file has changed.
    paths = _written(result, scene, folder, view_layer.name) if folder else []
    names = store(result, scene, folder)
    if target == "vertices":
        _drop_attributes(names, ATTRIBUTE if result.job.settings.domain == "corner" else CORNERS)
    images = [bpy.data.images[name] for name in names] if target in {"image", "lightmap"} else []
    for image, path in zip(images, paths):
        _to_file(image, path)
    group = scene.gi_bake
    _drop_replaced(group, target, images, names)
    line = group.results.add()
    line.name, line.key = _title(result, scene, names), uuid.uuid4().hex
    line.method, line.target = result.job.method.upper(), target.upper()
    line.view_layer, line.frame, line.seconds = view_layer.name, scene.frame_current, seconds
    line.size, line.folder = _size(result), _relative(folder) if folder else ""
    for image in images:
        line.images.add().image = image
    line.objects = json.dumps([] if images else names)
    group.active_result = len(group.results) - 1
    return line


def drop(scene: bpy.types.Scene, index: int) -> None:
    """Takes a result out of the file and of the scene's list. Files in folders stay."""
    line = scene.gi_bake.results[index]
    doomed = [part.image for parts in (line.images, line.comparisons) for part in parts if part.image]
    names = json.loads(line.objects or "[]")
    scene.gi_bake.results.remove(index)
    scene.gi_bake.active_result = max(0, min(index, len(scene.gi_bake.results) - 1))
    for image in doomed:
        bpy.data.images.remove(image)
    for name in names:
        if (obj := bpy.data.objects.get(name)) is None:
            continue
        if MARK in obj:
            data = obj.data
            bpy.data.objects.remove(obj)
            if not data.users:
                bpy.data.volumes.remove(data)
            for group in [g for g in bpy.data.node_groups if g.get(MARK, "").endswith(f" {scene.name}")]:
                bpy.data.node_groups.remove(group)
        elif obj.type == "MESH":
            _drop_attributes([name], ATTRIBUTE, CORNERS, COVERAGE)
            obj.data.pop(LIGHT, None)


def _drop_attributes(names: Sequence[str], *attributes: str) -> None:
    for mesh in (bpy.data.objects[name].data for name in names):
        for attribute in attributes:
            if found := mesh.attributes.get(attribute):
                mesh.attributes.remove(found)


def pictured(subjects: Sequence[Subject], folder: Path) -> list[tuple[str, dict[str, Path]]]:
    """Writes ours, Cycles' and the difference of each picture of a comparison: its name, and the files by LAYERS.

    Nothing of Blender is touched.
    """
    # Light at vertices is no picture.
    return [(c.name, _pictures(c, folder)) for c in subjects if c.flat]


def compared(
    line: bpy.types.PropertyGroup, subjects: Sequence[Subject], report: Path, pictures: Sequence[tuple[str, dict]]
) -> list[bpy.types.Image]:
    """Notes a comparison with Cycles in a result's line; the images that show it, packed, of `pictured` files."""
    told = [s for s in subjects if s.kind == "indirect"] or subjects
    line.compared, line.report = True, _relative(report)
    line.error, line.bias = (
        float(np.mean([values[name] for s in told for values in s.measures.values()])) for name in ("relmse", "bias")
    )
    for part in line.comparisons:
        if part.image:
            bpy.data.images.remove(part.image)
    line.comparisons.clear()
    made = []
    for name, paths in pictures:
        for layer, path in paths.items():
            image = bpy.data.images.load(str(path))
            image.name = f"{name} {LAYERS[layer]}"
            image[MARK] = image.name
            # Light, and no data, for which newer Blenders take such files.
            image.colorspace_settings.name = _SPACE
            image.pack()
            made.append(image)
            part = line.comparisons.add()
            part.name, part.image = layer, image
    return made


def _pictures(c: Subject, folder: Path) -> dict[str, Path]:
    exposure = display.exposure_of(c.reference, c.mask)
    [ours] = c.ours.values()
    shown = display.difference(ours, c.reference, exposure, c.mask)[..., :3].astype(np.float32) / 255
    # The file holds scene-linear values, and the picture's colours are sRGB.
    difference = np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4).astype(np.float32)
    found = {}
    for layer, pixels in zip(LAYERS, (ours, c.reference, difference), strict=True):
        found[layer] = folder / f"{file_stem(c.name)} {LAYERS[layer]}.exr"
        exr.write_image(found[layer], pixels)
    return found


def _written(result: Result, scene: bpy.types.Scene, folder: Path, view_layer: str) -> list[Path]:
    """Writes a result's files; the ones that its images are in, in the order in which `store` makes them."""
    paths = export(result, folder, view_layer)
    if result.job.target != "image":
        return [path for path in paths if path.suffix == ".exr"]
    own = {f"{scene.name} GI": "Combined", f"{scene.name} GI Indirect": "Diffuse Indirect"}
    paths = [folder / f"{file_stem(name)}.exr" for name in own]
    for path, layer in zip(paths, own.values()):
        exr.write_image(path, result.layers[layer])
    return paths


def _to_file(image: bpy.types.Image, path: Path) -> None:
    """Lets an image take its pixels from a file instead of from the .blend."""
    space = image.colorspace_settings.name
    image.unpack(method="REMOVE")
    image.source, image.filepath = "FILE", _relative(path)
    image.colorspace_settings.name = space
    image.alpha_mode = "CHANNEL_PACKED"
    image.reload()


def _relative(path: Path) -> str:
    """A path as the file refers to it: from the .blend, where it is saved."""
    try:
        return bpy.path.relpath(str(path)) if bpy.data.filepath else str(path)
    except ValueError:  # another drive
        return str(path)


def _drop_replaced(group, target: str, images: list, names: list[str]) -> None:
    """Lines whose images or objects have all been replaced."""
    ours = {image.name for image in images} or set(names)
    for index in reversed(range(len(group.results))):
        line = group.results[index]
        theirs = {part.image.name for part in line.images if part.image} or set(json.loads(line.objects or "[]"))
        if line.target == target.upper() and theirs <= ours:
            for part in line.comparisons:
                if part.image:
                    bpy.data.images.remove(part.image)
            group.results.remove(index)


def _title(result: Result, scene: bpy.types.Scene, names: list[str]) -> str:
    if result.job.target in {"image", "volume"}:
        return scene.name
    first = next(iter(result.light), "")
    return first if len(result.light) == 1 else f"{first} + {len(result.light) - 1}"


def _size(result: Result) -> str:
    target = result.job.target
    if target == "image":
        height, width = result.layers["Combined"].shape[:2]
        return f"{width} × {height}"
    if target == "lightmap":
        height, width = next(iter(result.light.values())).valid.shape
        return f"{width} × {height}"
    if target == "vertices":
        return str(sum(len(light.valid) for light in result.light.values()))
    return f"{result.job.settings.cells} × {result.job.settings.cascades}"
