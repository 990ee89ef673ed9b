# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Presets of a technique's settings, in Blender's own system: shipped ones lie beside this file.

A shipped preset says only what it is about; one that a user adds holds all settings of the technique.
"""

from dataclasses import fields
from pathlib import Path

import bpy
from bpy.types import Operator, Panel

from bl_operators.presets import AddPresetBase
from bl_ui.utils import PresetPanel

from ...gi_core.settings import Settings
from ...gi_core.techniques import METHODS
from ..rna import own_fields

# What belongs to a machine or a scene and not to a quality.
_NOT_KEPT = {"device", "memory", "seed", "light", "margin", "glossy", "box", "cameras", "center", "debug"}


def _panel(method: str) -> type:
    return type(
        f"GI_PT_{method}_presets", (PresetPanel, Panel),
        {
            "bl_label": f"{method.upper()} Presets", "preset_subdir": f"gi_bake/{method}",
            "preset_operator": "script.execute_preset", "preset_add_operator": f"gi.{method}_preset_add",
        },
    )  # fmt: skip


def _operator(method: str) -> type:
    own = [f.name for f in own_fields(METHODS[method].settings) if f.name not in _NOT_KEPT]
    shared = [f.name for f in fields(Settings) if f.name not in _NOT_KEPT]
    return type(
        f"GI_OT_{method}_preset_add", (AddPresetBase, Operator),
        {
            "__doc__": f"Add or remove a preset of {method.upper()}'s settings",
            "bl_idname": f"gi.{method}_preset_add", "bl_label": f"Add {method.upper()} Preset",
            "preset_menu": f"GI_PT_{method}_presets", "preset_subdir": f"gi_bake/{method}",
            "preset_defines": ["gi_bake = bpy.context.scene.gi_bake"],
            "preset_values": [f"gi_bake.{name}" for name in shared] + [f"gi_bake.{method}.{name}" for name in own],
        },
    )  # fmt: skip


PANELS = {method: _panel(method) for method in METHODS}
classes = (*PANELS.values(), *(_operator(method) for method in METHODS))
_register, _unregister = bpy.utils.register_classes_factory(classes)

# It holds this folder `presets`, where Blender looks.
_PATH = str(Path(__file__).resolve().parents[1])


def register():
    _register()
    bpy.utils.register_preset_path(_PATH)


def unregister():
    bpy.utils.unregister_preset_path(_PATH)
    _unregister()
