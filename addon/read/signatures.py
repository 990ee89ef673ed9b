# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of nodes, with the images, ramps and curves that they hold, as text that changes when they do."""

import hashlib
from pathlib import Path

import bpy
import numpy as np

# What every node has and no value depends on.
_COMMON = set(bpy.types.Node.bl_rna.properties.keys())


def signature(node: bpy.types.Node, frame: float) -> str:
    """The settings of a node at a frame, but for its inputs."""
    return repr([
        (name, _image(value, node, frame) if isinstance(value, bpy.types.Image) else _described(value))
        for name in node.bl_rna.properties.keys()
        if name not in _COMMON and (value := getattr(node, name)) is not None
    ])


def _described(value) -> object:
    """A value of a property as something whose `repr` says all of it."""
    match value:
        case bpy.types.Object():
            return value.name_full, np.array(value.matrix_world).tolist()
        case bpy.types.Node() | bpy.types.ParticleSystem():
            return value.name
        case bpy.types.Text():
            return value.as_string()
        case bpy.types.ID():
            return value.name_full
        case bpy.types.bpy_struct():
            names = [name for name in value.bl_rna.properties.keys() if name != "rna_type"]
            return [(name, _described(getattr(value, name))) for name in names]
        case bpy.types.bpy_prop_collection():
            return [_described(each) for each in value]
        case str() | int() | float() | None:
            return value
    try:
        return np.array(value).tolist()
    except (TypeError, ValueError):
        return repr(value)


def _image(image: bpy.types.Image, node: bpy.types.Node, frame: float) -> object:
    """What an image's pixels depend on: its files or, where there are none, they themselves."""
    original = image.original
    settings = [image.source, image.colorspace_settings.name, image.alpha_mode]
    if image.source in {"SEQUENCE", "MOVIE"}:
        settings.append(frame)
    if original.packed_files:
        return settings, [hashlib.sha256(file.packed_file.data).hexdigest() for file in original.packed_files]
    if image.source == "GENERATED" or original.is_dirty:
        pixels = np.empty(len(original.pixels), np.float32)
        original.pixels.foreach_get(pixels)
        return settings, tuple(image.size), hashlib.sha256(pixels).hexdigest()
    if image.source == "TILED":
        path = bpy.path.abspath(original.filepath, library=original.library)
        return settings, [(tile.number, _file(_of_tile(path, tile.number))) for tile in original.tiles]
    return settings, _file(original.filepath_from_user(image_user=node.image_user))


def _of_tile(path: str, number: int) -> str:
    column, row = (number - 1001) % 10, (number - 1001) // 10
    return path.replace("<UDIM>", str(number)).replace("<UVTILE>", f"u{column + 1}_v{row + 1}")


def _file(path: str) -> tuple[str, int, int]:
    try:
        state = Path(bpy.path.abspath(path)).stat()
    except OSError:
        return path, 0, 0
    return path, state.st_size, state.st_mtime_ns
