# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings as Blender's properties: what a dataclass says of its fields is said once, and there.

A field `map_resolution` becomes a property `map_resolution`; a choice "flux" becomes an enum's "FLUX", as Blender
writes them.
"""

from collections.abc import Iterable
from dataclasses import Field, fields

import bpy
from bpy.props import BoolProperty, EnumProperty, FloatProperty, IntProperty, StringProperty

from ..gi_core.settings import Settings

_CAPITALS = {
    "cpu": "CPU", "exr": "EXR", "gltf": "glTF", "gpu": "GPU", "hdrp": "HDRP", "lpv": "LPV", "mean": "True Mean",
    "oidn": "Open Image Denoise", "rgbd": "RGBD", "rgbm": "RGBM", "srgb": "sRGB", "uv": "UV",
}  # fmt: skip
# What Blender writes behind a value. Other units go behind the name.
_SUBTYPES = {"m": "DISTANCE", "s": "TIME_ABSOLUTE", "pixels": "PIXEL", "texels": "PIXEL"}

# In which settings' names are translated: Blender's own words come first elsewhere, and "Bound" says "tied" there.
CONTEXT = "GI Bake"


def label(name: str) -> str:
    """A name as it is written for people."""
    return _CAPITALS.get(name) or " ".join(_CAPITALS.get(word, word.title()) for word in name.split("_"))


def annotations(chosen: Iterable[Field]) -> dict[str, object]:
    """Properties for fields made by `gi_core.settings.setting`: name -> what a class of Blender's is annotated with."""
    return {f.name: _property(f) for f in chosen}


def values(group: bpy.types.PropertyGroup, chosen: Iterable[Field]) -> dict[str, object]:
    """Fields' values as their dataclass takes them, from a group that was annotated with them."""
    found = {}
    for f in chosen:
        value = getattr(group, f.name)
        if f.metadata["choices"]:
            value = value.lower()
        elif type(f.default) is float:
            value = _as_written(value, f)
        found[f.name] = value
    return found


def own_fields(settings: type[Settings]) -> list[Field]:
    """Fields of a technique's settings that the others do not share."""
    shared = {f.name for f in fields(Settings)}
    return [f for f in fields(settings) if f.name not in shared]


def _as_written(value: float, f: Field) -> float:
    """Blender keeps 32 bits of 0.1, which is then another number, and maybe one beyond a bound."""
    return min(max(float(f"{value:.7g}"), f.metadata["low"]), f.metadata["high"])


def _property(f: Field):
    m = f.metadata
    said = {
        "name": _named(f.name, m["unit"]), "description": m["description"], "options": set(),
        "translation_context": CONTEXT,
    }  # fmt: skip
    if m["choices"]:
        items = [(choice.upper(), label(choice), "") for choice in m["choices"]]
        return EnumProperty(items=items, default=f.default.upper(), **said)
    if isinstance(f.default, bool):
        return BoolProperty(default=f.default, **said)
    if isinstance(f.default, str):
        return StringProperty(default=f.default, **said)
    said |= {"default": f.default, "min": m["low"], "max": m["high"], "subtype": _SUBTYPES.get(m["unit"], "NONE")}
    if isinstance(f.default, int):
        return IntProperty(**said)
    units = {"m": "LENGTH", "s": "TIME_ABSOLUTE"}
    return FloatProperty(precision=3, step=10, unit=units.get(m["unit"], "NONE"), **said)


def _named(name: str, unit: str) -> str:
    shown = label(name)
    if not unit or unit in _SUBTYPES or unit in name:
        return shown
    return f"{shown} ({unit})"
