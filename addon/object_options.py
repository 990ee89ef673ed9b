# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a user says about single objects, in `Object.gi_bake`; where nothing is registered the defaults count."""

from dataclasses import dataclass

import bpy

# Types of object with a surface.
SURFACES = {"MESH", "CURVE", "FONT", "SURFACE", "META"}


@dataclass(frozen=True)
class ObjectOptions:
    """What holds for one object.

    use: it gets light of its own; off, it only casts and reflects. casts: it blocks and reflects light; off, it only
        receives. Both off leave it out.
    lightmap_factor: of its texel density. lightmap_group: name of a lightmap that it shares with others, "" for what
        the setting `atlas` says. method: the technique that its light is found with, "" for what is baked with.
    """

    use: bool = True
    casts: bool = True
    lightmap_factor: float = 1.0
    lightmap_group: str = ""
    method: str = ""


def object_options(obj: bpy.types.Object) -> ObjectOptions:
    """Of an object as the user made it."""
    # Before Blender 5 looking at a group that was never touched would write an empty one into the file.
    untouched = bpy.app.version < (5, 0) and "gi_bake" not in obj
    told, default = None if untouched else getattr(obj, "gi_bake", None), ObjectOptions()
    options = {name: getattr(told, name, value) for name, value in vars(default).items()}
    method = options.pop("method").lower()
    return ObjectOptions(**options, method="" if method == "scene" else method)
