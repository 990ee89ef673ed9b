# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panel that holds all others: what is baked and for what, and the buttons."""

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Panel

from ..presets import PANELS as PRESETS
from ..session import session
from .findings import by_code, finding_box
from .panel import RenderPanel
from .settings import prop
from .words import duration, wrapped

# What a bake is doing, for people.
STAGES = {
    "": "Starting", "read": "Reading the scene", "checks": "Looking for mistakes", "trees": "Building ray trees",
    "maps": "Light from lamps", "propagation": "Propagating light", "screen": "Screen passes",
    "points": "Finding points", "lamps": "Direct light", "gather": "Reflected light",
    "denoise": "Filtering", "oidn": "Open Image Denoise", "compositor": "Open Image Denoise", "gloss": "Reflections",
    "medium": "Fog",
    "unwrap": "Making UV maps", "overlaps": "Looking at UV maps", "materials": "Baking materials",
    "layout": "Laying out lightmaps", "packing": "Laying out lightmaps", "signatures": "Laying out lightmaps",
    "borders": "Seams and borders",
    "cycles": "Cycles renders", "measure": "Measuring", "report": "Writing the report",
}  # fmt: skip


class GI_PT_main(RenderPanel, Panel):
    bl_idname = "GI_PT_main"
    bl_label = "GI Bake"
    bl_order = 20

    def draw(self, context):
        column, group = self.split(), context.scene.gi_bake
        column.row().prop(group, "method", expand=True)
        column.prop(group, "target")
        _resolution(column, group, context)
        if group.target in {"LIGHTMAP", "VERTICES"}:
            prop(column, group, "scope", context)
            prop(column, group, "light", context)
        if group.target == "VERTICES":
            prop(column, group, "domain", context)
        _quality(column, group)
        buttons(self.layout.column(), context)


def _quality(column, group):
    split = column.split(factor=0.4)
    row = split.row()
    row.alignment = "RIGHT"
    row.label(text="Quality")
    split.popover(panel=PRESETS[group.method.lower()].__name__, text="Presets", icon="PRESET")


def _resolution(column, group, context):
    if group.target == "IMAGE":
        prop(column, group, "use_render_size", context)
        if not group.use_render_size:
            prop(column, group, "image_resolution", context)
        prop(column, group, "antialias", context)
        prop(column, group, "glossy", context)
    elif group.target == "LIGHTMAP":
        prop(column, group, "resolution", context)
        active = context.object
        if active and active.type == "MESH":
            column.prop_search(group, "uv", active.data, "uv_layers", icon="GROUP_UVS", results_are_suggestions=True)
        else:
            column.prop(group, "uv")


def buttons(layout, context):
    """Bake, or how far it is; then what was found."""
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
            wrapped(layout, iface_("GI Bake works on scene {:s}").format(session.of), context)
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
    for (code, severity), findings in by_code(found).items():
        finding_box(layout, code, severity, findings, context)
