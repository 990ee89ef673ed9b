# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings in a panel: each property as its room allows, grey where it has no effect."""

from collections.abc import Callable, Iterable

import blf
import bpy
from bpy.app.translations import pgettext_iface as iface_

# When a setting has an effect; the others always have one.
_USED: dict[str, Callable[[bpy.types.PropertyGroup, bpy.types.PropertyGroup], bool]] = {
    "denoise": lambda shared, own: shared.target in {"IMAGE", "LIGHTMAP"},
    "denoise_passes": lambda shared, own: (
        shared.target in {"IMAGE", "LIGHTMAP"} and shared.denoise in {"AUTO", "BILATERAL"}
    ),
    "weighting": lambda shared, own: getattr(own, "pattern", "DISK") == "DISK",
    "disk_radius": lambda shared, own: own.pattern == "DISK",
    "pattern_per_point": lambda shared, own: own.pattern != "ALL",
    "candidates": lambda shared, own: own.pattern == "FLUX",
    "interpolation": lambda shared, own: shared.target in {"IMAGE", "LIGHTMAP"},
    "reach": lambda shared, own: own.propagation == "HIERARCHICAL",
    **dict.fromkeys(
        (
            "iterations", "front_share", "damping", "geometry_volume", "occlusion_amplifier", "geometry_bias",
            "secondary_bounce", "derivative_damping",
        ), lambda shared, own: own.propagation == "FLAT",
    ),
    "half": lambda shared, own: shared.target == "VOLUME",
    "cascade_ratio": lambda shared, own: own.cascades > 1,
    "center": lambda shared, own: own.cascades > 1,
    "steps": lambda shared, own: own.quality == "CUSTOM" and own.mode in {"SCREEN_SPACE", "MIXED"},
    "mixed_steps": lambda shared, own: own.mode == "MIXED",
    "radius": lambda shared, own: own.quality == "CUSTOM",
    "thickness": lambda shared, own: own.mode in {"SCREEN_SPACE", "MIXED"},
    "tracer": lambda shared, own: own.mode in {"SCREEN_SPACE", "MIXED"},
    "last_bounce": lambda shared, own: own.mode in {"RAY_TRACED", "MIXED"},
    "fallback": lambda shared, own: own.mode == "SCREEN_SPACE",
    "cameras": lambda shared, own: shared.target != "IMAGE",
    "debug": lambda shared, own: shared.target == "IMAGE",
    "unwrap": lambda shared, own: not shared.uv,
    **dict.fromkeys(("exr", "encoding", "gltf"), lambda shared, own: shared.keep == "FILES"),
    "exposure": lambda shared, own: shared.keep == "FILES" and shared.encoding == "SRGB",
    "glossy_lookup": lambda shared, own: shared.target == "IMAGE" and shared.glossy,
    "fog_density": lambda shared, own: shared.target == "IMAGE",
    **dict.fromkeys(
        ("fog_albedo", "fog_anisotropy", "fog_steps"),
        lambda shared, own: shared.target == "IMAGE" and own.fog_density > 0,
    ),
}  # fmt: skip


def prop(column, holder, name: str, context) -> None:
    """A property with its name before it, or above or in it where a narrow region would cut the name off."""
    kind = holder.bl_rna.properties[name]
    scale = context.preferences.system.ui_scale
    room = context.region.width - 80 * scale
    blf.size(0, 11 * scale)
    width = blf.dimensions(0, iface_(kind.name, kind.translation_context))[0]
    if width < (0.6 * room - 15 * scale if kind.type == "BOOLEAN" else 0.4 * room):
        column.prop(holder, name)
    elif kind.type in {"STRING", "ENUM"}:
        column.label(text=kind.name, text_ctxt=kind.translation_context)
        column.prop(holder, name, text="")
    else:
        row = column.row()
        row.use_property_split = False
        row.prop(holder, name)


def settings(layout, group, method: str, names: Iterable[str], context):
    own, column = getattr(group, method), layout.column()
    for name in names:
        holder = own if name in own.bl_rna.properties else group
        row = column.column()
        row.active = name not in _USED or _USED[name](group, own)
        if name == "box":
            row.prop_search(holder, name, bpy.data, "objects", results_are_suggestions=True)
        else:
            prop(row, holder, name, context)
