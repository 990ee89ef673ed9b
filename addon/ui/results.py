# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What was baked."""

import bpy
from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Panel, UIList

from .. import preview
from ..baked import LAYERS
from .panel import RenderPanel
from .settings import prop
from .words import duration, short


class GI_UL_results(UIList):
    """The results of a scene."""

    bl_idname = "GI_UL_results"

    def draw_item(self, context, layout, data, item, icon, active_data, active_property, index=0, flt_flag=0):
        split = layout.split(factor=0.4)
        split.prop(item, "name", text="", emboss=False, icon=_icon(item))
        error = f" {item.error:.3f}" if item.compared else ""
        split.label(text=f"{item.method} {short(item.seconds)}{error}", translate=False)


def _icon(item) -> str:
    return item.bl_rna.properties["target"].enum_items[item.target].icon


class GI_PT_results(RenderPanel, Panel):
    bl_idname = "GI_PT_results"
    bl_label = "Results"
    bl_parent_id = "GI_PT_main"

    def draw(self, context):
        layout, group = self.split(), context.scene.gi_bake
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
        known = {
            "Technique": iface_(_enum_name(line, "method")), "Target": iface_(_enum_name(line, "target")),
            {"VERTICES": "Vertices", "VOLUME": "Cells"}.get(line.target, "Resolution"): line.size,
            "Time": duration(line.seconds),
        }  # fmt: skip
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
            row.operator("wm.path_open", text="Folder", icon="FILE_FOLDER").filepath = bpy.path.abspath(line.folder)
        row = layout.row(align=True)
        row.operator("gi.apply", text="Apply", icon="MATERIAL")
        row.operator("gi.remove", icon="TRASH")
        column = layout.column()
        prop(column, group, "reference_samples", context)
        column.operator("gi.compare")
        if line.compared:
            if line.comparisons:
                self._layers(line, column)
            column.operator("wm.path_open", text="Report", icon="URL").filepath = bpy.path.abspath(line.report)

    def _layers(self, line, column):
        """A button for each layer of a comparison; the one that is shown is held down."""
        shown = {space.image for space in preview.editors()}
        row = column.row(align=True)
        for layer, name in LAYERS.items():
            down = any(part.name == layer and part.image in shown for part in line.comparisons)
            row.operator("gi.show", text=name, depress=down).which = layer


def _enum_name(item, name: str) -> str:
    return item.bl_rna.properties[name].enum_items[getattr(item, name)].name
