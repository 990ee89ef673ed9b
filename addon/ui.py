# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels: in the Render properties, and the same in the 3D view's sidebar; one in the Object properties."""

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import fields

import blf
import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Panel, UIList

from ..gi_core.settings import Settings
from ..gi_core.techniques import METHODS
from . import asked, timing
from .preflight import Finding
from .presets import PANELS as PRESETS
from .properties import METHODS as DESCRIBED
from .remedies import REMEDIES
from .rna import own_fields
from .session import session

# What matters of a technique, in the order in which an artist turns to it. All else is advanced.
MAIN = {
    "rsm": ("samples", "bounces", "denoise", "map_resolution", "light_samples"),
    "lpv": ("cells", "cascades", "bounces", "map_resolution", "visibility"),
    "ssgi": ("mode", "samples", "bounces", "denoise", "fallback"),
}

# What lightmaps have beside their resolution, in the order in which they are made.
LIGHTMAPS = (
    "atlas", "density", "unwrap", "padding", "margin", "stitch", "directional", "exr", "encoding", "exposure", "gltf",
    "rebake",
)

# Shared settings that are shown elsewhere or that a technique has no use for.
_ELSEWHERE = {"device", "memory", "light", "antialias", "glossy", *LIGHTMAPS}

# When a setting has an effect; the others always have one.
_USED: dict[str, Callable[[bpy.types.PropertyGroup, bpy.types.PropertyGroup], bool]] = {
    "denoise_passes": lambda shared, own: shared.denoise == "BILATERAL",
    "weighting": lambda shared, own: getattr(own, "pattern", "DISK") == "DISK",
    "disk_radius": lambda shared, own: own.pattern == "DISK",
    "pattern_per_point": lambda shared, own: own.pattern != "ALL",
    "candidates": lambda shared, own: own.pattern == "FLUX",
    "interpolation": lambda shared, own: shared.target == "IMAGE",
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
    "domain": lambda shared, own: shared.target == "VERTICES",
    "exposure": lambda shared, own: shared.encoding == "SRGB",
    "glossy_lookup": lambda shared, own: shared.target == "IMAGE" and shared.glossy,
    "fog_density": lambda shared, own: shared.target == "IMAGE",
    **dict.fromkeys(
        ("fog_albedo", "fog_anisotropy", "fog_steps"),
        lambda shared, own: shared.target == "IMAGE" and own.fog_density > 0,
    ),
}  # fmt: skip

# What a bake is doing, for people.
STAGES = {
    "": "Starting", "read": "Reading the scene", "trees": "Building ray trees", "maps": "Light from lamps",
    "points": "Finding points", "lamps": "Direct light", "gather": "Reflected light", "denoise": "Filtering",
    "oidn": "Open Image Denoise", "gloss": "Reflections", "medium": "Fog", "unwrap": "Making UV maps",
    "materials": "Baking materials", "layout": "Laying out lightmaps", "borders": "Seams and borders",
}  # fmt: skip


# Where a line may end: after a word, and after any character of a script that has no spaces.
_CJK = "\u3000-\u9fff\uff00-\uffef"
_PIECES = re.compile(rf"[{_CJK}]|\s*[^\s{_CJK}]+|\s+")


def _wrapped(layout: bpy.types.UILayout, text: str, context, icon: str = "NONE", taken: int = 0) -> None:
    """A text in as many lines as the region's width asks for. taken: of the width by other things [px at scale 1]."""
    scale = context.preferences.system.ui_scale
    blf.size(0, 11 * scale)
    width = context.region.width - (68 + taken + (20 if icon != "NONE" else 0)) * scale
    lines, line = [], ""
    for piece in _PIECES.findall(text):
        if line and blf.dimensions(0, (line + piece).rstrip())[0] > width:
            lines.append(line.rstrip())
            line = ""
        line += piece if line else piece.lstrip()
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, part in enumerate([*lines, line]):
        column.label(text=part, icon=icon if i == 0 else "BLANK1" if icon != "NONE" else "NONE", translate=False)


def duration(seconds: float) -> str:
    """Seconds as people say them."""
    if seconds < 60:
        return iface_("{:.0f} s").format(seconds) if seconds >= 10 else iface_("{:.1f} s").format(seconds)
    if seconds < 3600:
        return iface_("{:.0f} min {:.0f} s").format(seconds // 60, seconds % 60)
    return iface_("{:.0f} h {:.0f} min").format(seconds // 3600, seconds % 3600 // 60)


def amount(count: float) -> str:
    """A large number, short."""
    for size, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count:.0f}"


class _Panel:
    """What all panels of both places share."""

    bl_space_type, bl_region_type = "PROPERTIES", "WINDOW"
    bl_context = "render"

    def _split(self) -> bpy.types.UILayout:
        """Where settings go: greyed out while a bake works by them."""
        layout = self.layout.column()
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.enabled = session.run is None
        return layout


class GI_PT_main(_Panel, Panel):
    bl_idname = "GI_PT_main"
    bl_label = "GI Bake"
    bl_order = 20

    def draw(self, context):
        column, group = self._split(), context.scene.gi_bake
        column.row().prop(group, "method", expand=True)
        column.prop(group, "target")
        _resolution(column, group, context)
        if group.target in {"LIGHTMAP", "VERTICES"}:
            _prop(column, group, "scope", context)
            _prop(column, group, "light", context)
        _buttons(self.layout.column(), context)


def _prop(column, holder, name: str, context) -> None:
    """A property with its name before it, or above or in it where a narrow region would cut the name off."""
    kind = holder.bl_rna.properties[name]
    scale = context.preferences.system.ui_scale
    room = context.region.width - 80 * scale
    blf.size(0, 11 * scale)
    width = blf.dimensions(0, iface_(kind.name))[0]
    if width < (0.6 * room - 15 * scale if kind.type == "BOOLEAN" else 0.4 * room):
        column.prop(holder, name)
    elif kind.type in {"STRING", "ENUM"}:
        column.label(text=kind.name)
        column.prop(holder, name, text="")
    else:
        row = column.row()
        row.use_property_split = False
        row.prop(holder, name)


def _resolution(column, group, context):
    if group.target == "IMAGE":
        _prop(column, group, "use_render_size", context)
        if not group.use_render_size:
            _prop(column, group, "image_resolution", context)
        _prop(column, group, "antialias", context)
        _prop(column, group, "glossy", context)
    elif group.target == "LIGHTMAP":
        _prop(column, group, "resolution", context)
        active = context.object
        if active and active.type == "MESH":
            column.prop_search(group, "uv", active.data, "uv_layers", icon="GROUP_UVS", results_are_suggestions=True)
        else:
            column.prop(group, "uv")


def _buttons(layout, context):
    """Bake, or how far the bake is; then what was found."""
    run = session.run
    if run:
        left = run.seconds_left
        stage = iface_(STAGES.get(run.stage, run.stage))
        text = f"{stage}  {run.fraction:.0%}"
        if left is not None:
            text += "  " + iface_("{:s} left").format(duration(left))
        layout.progress(factor=run.fraction, text=text, type="BAR", translate=False)
        layout.operator("gi.cancel", icon="X")
        if session.of != context.scene.name:
            _wrapped(layout, iface_("Scene {:s} is being baked").format(session.of), context)
        return
    row = layout.row()
    row.scale_y = 1.4
    row.operator("gi.bake", icon="RENDER_STILL")
    layout.operator("gi.check", icon="CHECKMARK")
    found = session.findings(context.scene)
    if found is None:
        return
    if not found:
        layout.label(text="Ready to bake", icon="CHECKMARK")
    for (code, severity), findings in _by_code(found).items():
        _finding(layout, code, severity, findings, context)


def _by_code(found: Iterable[Finding]) -> dict[tuple[str, str], list[Finding]]:
    grouped: dict[tuple[str, str], list[Finding]] = {}
    for finding in found:
        grouped.setdefault((finding.code, finding.severity), []).append(finding)
    return grouped


def _finding(layout, code: str, severity: str, findings: list[Finding], context):
    """A box for what is wrong in one way: the first one's words, the others' number, the code and a button."""
    box = layout.box()
    box.alert = severity == "ERROR"
    first = findings[0]
    _wrapped(box, iface_(first.message), context, icon="ERROR" if severity == "ERROR" else "INFO", taken=20)
    if len(findings) > 1:
        names = ", ".join(f.object for f in findings[1:4]) + ("…" if len(findings) > 4 else "")
        _wrapped(box, iface_("And {:d} more: {:s}").format(len(findings) - 1, names), context, "BLANK1", taken=20)
    box.alert = False
    if first.remedy:
        _wrapped(box, iface_(first.remedy), context, "BLANK1", taken=20)
    row = box.row()
    sub = row.row()
    sub.active = False
    sub.label(text=code, translate=False)
    names = json.dumps([f.object for f in findings if f.object], ensure_ascii=False)
    if code in REMEDIES:
        idname, text = REMEDIES[code]
        operator = row.operator(idname, text=text)
        if idname.startswith("gi.") and "objects" in operator.bl_rna.properties:
            operator.objects = names
    elif any(f.object in context.scene.objects for f in findings):
        row.operator("gi.select").objects = names


class GI_PT_extent(_Panel, Panel):
    bl_idname = "GI_PT_extent"
    bl_label = "What Is Baked"
    bl_parent_id = "GI_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, group = self._split(), context.scene.gi_bake
        extent = asked.extent(context.scene, context.view_layer)
        seconds = timing.expected(context.scene, context.view_layer)
        known = {
            "Objects": str(extent.objects) if group.target in {"LIGHTMAP", "VERTICES"} else "",
            "Resolution": extent.size if group.target in {"IMAGE", "LIGHTMAP"} else "",
            {"LIGHTMAP": "Texels", "VERTICES": "Vertices", "VOLUME": "Cells"}.get(group.target, "Points"):
                amount(extent.points),
            "Memory": iface_("about {:.0f} MB").format(max(1, extent.memory / 2**20)),
            "Time": iface_("about {:s}").format(duration(seconds)) if seconds else iface_("not known yet"),
        }  # fmt: skip
        column = layout.column(align=True)
        for name, text in known.items():
            if text:
                split = column.split(factor=0.4)
                row = split.row()
                row.alignment = "RIGHT"
                row.label(text=name)
                split.label(text=text, translate=False)
        column = layout.column()
        names = ["device", "memory", *(["keep"] if group.target in {"IMAGE", "LIGHTMAP"} else [])]
        if asked.needs_folder(context.scene, group.target.lower()):
            names.append("folder")
        for name in names:
            _prop(column, group, name, context)


class GI_PT_lightmaps(_Panel, Panel):
    bl_idname = "GI_PT_lightmaps"
    bl_label = "Lightmaps"
    bl_parent_id = "GI_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.scene.gi_bake.target == "LIGHTMAP"

    def draw(self, context):
        group = context.scene.gi_bake
        _settings(self._split(), group, group.method.lower(), LIGHTMAPS, context)


class _Technique(_Panel):
    """A technique's settings: those that matter; `_Advanced` has the rest."""

    method = ""

    @classmethod
    def poll(cls, context):
        return context.scene.gi_bake.method == cls.method

    def draw_header_preset(self, context):
        PRESETS[self.method.lower()].draw_panel_header(self.layout)

    def draw(self, context):
        _wrapped(self.layout, iface_(next(text for name, _, text, _ in DESCRIBED if name == self.method)), context)
        _settings(self._split(), context.scene.gi_bake, self.method.lower(), MAIN[self.method.lower()], context)


class _Advanced(_Panel):
    bl_label = "Advanced"
    bl_options = {"DEFAULT_CLOSED"}
    method = ""

    def draw(self, context):
        name = self.method.lower()
        own = [f.name for f in own_fields(METHODS[name].settings)]
        shared = [f.name for f in fields(Settings) if f.name not in _ELSEWHERE]
        layout, group = self._split(), context.scene.gi_bake
        _settings(layout, group, name, [n for n in shared if n not in MAIN[name]], context)
        _settings(layout, group, name, [n for n in own if n not in MAIN[name]], context)


def _settings(layout, group, method: str, names: Iterable[str], context):
    own, column = getattr(group, method), layout.column()
    for name in names:
        holder = own if name in own.bl_rna.properties else group
        row = column.column()
        row.active = name not in _USED or _USED[name](group, own)
        if name == "box":
            row.prop_search(holder, name, bpy.data, "objects", results_are_suggestions=True)
        else:
            _prop(row, holder, name, context)


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


class GI_UL_results(UIList):
    """The results of a scene."""

    bl_idname = "GI_UL_results"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.45)
        split.prop(item, "name", text="", emboss=False, icon=_icon(item))
        error = f"  {item.error:.4f}" if item.compared else ""
        split.label(text=f"{item.method}  {duration(item.seconds)}{error}", translate=False)


def _icon(item) -> str:
    return item.bl_rna.properties["target"].enum_items[item.target].icon


class GI_PT_results(_Panel, Panel):
    bl_idname = "GI_PT_results"
    bl_label = "Results"
    bl_parent_id = "GI_PT_main"

    def draw(self, context):
        layout, group = self._split(), context.scene.gi_bake
        if not group.results:
            row = layout.row()
            row.active = False
            row.label(text="Nothing is baked yet")
            return
        layout.template_list("GI_UL_results", "", group, "results", group, "active_result", rows=2)
        if not 0 <= group.active_result < len(group.results):
            return
        line = group.results[group.active_result]
        column = layout.column(align=True)
        known = {"Technique": iface_(_enum_name(line, "method")), "Target": iface_(_enum_name(line, "target")),
                 "Resolution": line.size, "Time": duration(line.seconds)}  # fmt: skip
        if line.compared:
            known |= {"relMSE": f"{line.error:.5f}", "Bias": f"{line.bias:+.2%}"}
        for name, text in known.items():
            split = column.split(factor=0.4)
            row = split.row()
            row.alignment = "RIGHT"
            row.label(text=name)
            split.label(text=text, translate=False)
        row = layout.row(align=True)
        row.operator("gi.show", text="Show", icon="IMAGE_DATA").which = "RESULT"
        if line.folder:
            row.operator("wm.path_open", text="Folder", icon="FILE_FOLDER").filepath = line.folder
        row = layout.row(align=True)
        row.operator("gi.apply", text="Apply", icon="MATERIAL")
        row.operator("gi.remove", icon="TRASH")
        column = layout.column()
        _prop(column, group, "reference_samples", context)
        column.operator("gi.compare")
        if line.compared:
            row = layout.row(align=True)
            if line.comparisons:
                row.operator("gi.show", text="Comparison", icon="IMAGE_RGB").which = "COMPARISON"
            row.operator("wm.path_open", text="Report", icon="URL").filepath = line.report


def _enum_name(item, name: str) -> str:
    return item.bl_rna.properties[name].enum_items[getattr(item, name)].name


class GI_PT_object(Panel):
    bl_idname = "GI_PT_object"
    bl_label = "GI Bake"
    bl_space_type, bl_region_type, bl_context = "PROPERTIES", "WINDOW", "object"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return context.object is not None and context.object.type in {"MESH", "CURVE", "FONT", "SURFACE", "META"}

    def draw(self, context):
        layout = self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        for name in ("use", "casts", "lightmap_factor", "lightmap_group", "method"):
            layout.prop(context.object.gi_bake, name)


def _in_sidebar(panel: type) -> type:
    """The same panel in the 3D view's sidebar: Blender wants a class of its own for each place."""
    own = dict(panel.__dict__)
    own |= {
        "bl_idname": f"VIEW3D_{panel.bl_idname}", "bl_space_type": "VIEW_3D", "bl_region_type": "UI",
        "bl_category": "GI Bake", "bl_context": "",
    }  # fmt: skip
    if hasattr(panel, "bl_parent_id"):
        own["bl_parent_id"] = f"VIEW3D_{panel.bl_parent_id}"
    return type(f"VIEW3D_{panel.__name__}", panel.__bases__, own)


_panels = (
    GI_PT_main, GI_PT_lightmaps, GI_PT_rsm, GI_PT_rsm_advanced, GI_PT_lpv, GI_PT_lpv_advanced, GI_PT_ssgi,
    GI_PT_ssgi_advanced, GI_PT_extent, GI_PT_results,
)  # fmt: skip
classes = (GI_UL_results, *_panels, *(_in_sidebar(panel) for panel in _panels), GI_PT_object)
register, unregister = bpy.utils.register_classes_factory(classes)
