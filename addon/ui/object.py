# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What holds for one object, in its own properties."""

from bpy.types import Panel

from .settings import prop


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
            prop(layout, context.object.gi_bake, name, context)
