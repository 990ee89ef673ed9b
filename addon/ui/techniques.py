# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of each technique, and those of lightmaps."""

from dataclasses import fields

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Panel

from ...gi_core.settings import Settings
from ...gi_core.techniques import METHODS
from ..presets import PANELS as PRESETS
from ..rna import own_fields
from .panel import RenderPanel
from .settings import settings
from .words import wrapped

# What a technique is called, and what it is for, in a line; its tooltip says more.
_TITLES = {
    "RSM": ("Reflective Shadow Maps", "Stills, lightmaps: equals Cycles as samples grow"),
    "LPV": ("Light Propagation Volumes", "Smooth without noise, also for what moves later"),
    "SSGI": ("Screen-Space GI", "Camera images and animations, as in game engines"),
}

# What matters of a technique, in the order in which an artist turns to it. All else is advanced.
MAIN = {
    "rsm": ("samples", "bounces", "denoise", "map_resolution", "light_samples"),
    "lpv": ("cells", "cascades", "bounces", "map_resolution", "visibility"),
    "ssgi": ("mode", "samples", "bounces", "denoise", "fallback"),
}


# What lightmaps have beside their resolution, in the order in which they are made.
LIGHTMAPS = (
    "atlas",
    "density",
    "unwrap",
    "padding",
    "margin",
    "stitch",
    "directional",
    "exr",
    "encoding",
    "exposure",
    "gltf",
    "rebake",
)


# Shared settings that are shown elsewhere or that a technique has no use for.
_ELSEWHERE = {"device", "memory", "light", "domain", "antialias", "glossy", *LIGHTMAPS}


class GI_PT_lightmaps(RenderPanel, Panel):
    bl_idname = "GI_PT_lightmaps"
    bl_label = "Lightmaps"
    bl_parent_id = "GI_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.scene.gi_bake.target == "LIGHTMAP"

    def draw(self, context):
        group = context.scene.gi_bake
        settings(self.split(), group, group.method.lower(), LIGHTMAPS, context)


class GI_PT_technique(RenderPanel, Panel):
    """The chosen technique's settings that matter.

    One panel for all techniques: where one takes another's place and is as high, Blender leaves it out.
    """

    bl_idname = "GI_PT_technique"
    bl_label = ""
    bl_parent_id = "GI_PT_main"

    def draw_header(self, context):
        self.layout.label(text=_TITLES[context.scene.gi_bake.method][0])

    def draw_header_preset(self, context):
        PRESETS[context.scene.gi_bake.method.lower()].draw_panel_header(self.layout)

    def draw(self, context):
        group = context.scene.gi_bake
        wrapped(self.layout, iface_(_TITLES[group.method][1]), context)
        settings(self.split(), group, group.method.lower(), MAIN[group.method.lower()], context)


class GI_PT_advanced(RenderPanel, Panel):
    """All its other settings."""

    bl_idname = "GI_PT_advanced"
    bl_label = "Advanced"
    bl_parent_id = "GI_PT_technique"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, group = self.split(), context.scene.gi_bake
        name = group.method.lower()
        own = [f.name for f in own_fields(METHODS[name].settings)]
        shared = [f.name for f in fields(Settings) if f.name not in _ELSEWHERE]
        settings(layout, group, name, [n for n in (*shared, *own) if n not in MAIN[name]], context)


PANELS = (GI_PT_lightmaps, GI_PT_technique, GI_PT_advanced)
