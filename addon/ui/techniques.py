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

# What a technique is for, in a line; its tooltip says more.
_FOR = {
    "RSM": "Stills, lightmaps: equals Cycles as samples grow",
    "LPV": "Smooth without noise, also for what moves later",
    "SSGI": "Camera images and animations, as in game engines",
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


class _Technique(RenderPanel):
    """A technique's settings: those that matter; `_Advanced` has the rest."""

    method = ""

    @classmethod
    def poll(cls, context):
        return context.scene.gi_bake.method == cls.method

    def draw_header_preset(self, context):
        PRESETS[self.method.lower()].draw_panel_header(self.layout)

    def draw(self, context):
        wrapped(self.layout, iface_(_FOR[self.method]), context)
        settings(self.split(), context.scene.gi_bake, self.method.lower(), MAIN[self.method.lower()], context)


class _Advanced(RenderPanel):
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}
    method = ""

    def draw(self, context):
        name = self.method.lower()
        own = [f.name for f in own_fields(METHODS[name].settings)]
        shared = [f.name for f in fields(Settings) if f.name not in _ELSEWHERE]
        layout, group = self.split(), context.scene.gi_bake
        settings(layout, group, name, [n for n in shared if n not in MAIN[name]], context)
        settings(layout, group, name, [n for n in own if n not in MAIN[name]], context)


class GI_PT_rsm(_Technique, Panel):
    bl_idname, bl_parent_id, bl_label = "GI_PT_rsm", "GI_PT_main", "Reflective Shadow Maps"
    method = "RSM"


class GI_PT_rsm_advanced(_Advanced, Panel):
    bl_idname, bl_parent_id, method = "GI_PT_rsm_advanced", "GI_PT_rsm", "RSM"


class GI_PT_lpv(_Technique, Panel):
    bl_idname, bl_parent_id, bl_label = "GI_PT_lpv", "GI_PT_main", "Light Propagation Volumes"
    method = "LPV"


class GI_PT_lpv_advanced(_Advanced, Panel):
    bl_idname, bl_parent_id, method = "GI_PT_lpv_advanced", "GI_PT_lpv", "LPV"


class GI_PT_ssgi(_Technique, Panel):
    bl_idname, bl_parent_id, bl_label = "GI_PT_ssgi", "GI_PT_main", "Screen-Space GI"
    method = "SSGI"


class GI_PT_ssgi_advanced(_Advanced, Panel):
    bl_idname, bl_parent_id, method = "GI_PT_ssgi_advanced", "GI_PT_ssgi", "SSGI"


PANELS = (
    GI_PT_lightmaps, GI_PT_rsm, GI_PT_rsm_advanced, GI_PT_lpv, GI_PT_lpv_advanced, GI_PT_ssgi, GI_PT_ssgi_advanced,
)  # fmt: skip
