# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How much a bake is."""

from bpy.app.translations import pgettext_iface as iface_
from bpy.types import Panel

from .. import asked, timing
from .panel import RenderPanel
from .settings import prop
from .words import amount, duration


class GI_PT_extent(RenderPanel, Panel):
    bl_idname = "GI_PT_extent"
    bl_label = "What Is Baked"
    bl_parent_id = "GI_PT_main"
    bl_options = {"DEFAULT_CLOSED"}

    def draw(self, context):
        layout, group = self.split(), context.scene.gi_bake
        extent = asked.extent(context.scene, context.view_layer)
        seconds = timing.expected(context.scene, context.view_layer)
        known = {
            "Objects": str(extent.objects) if group.target in {"LIGHTMAP", "VERTICES"} else "",
            "Images": str(extent.images) if group.target == "LIGHTMAP" else "",
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
            prop(column, group, name, context)
