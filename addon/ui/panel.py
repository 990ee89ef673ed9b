# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the panels of both places share."""

import bpy

from ..session import session


class RenderPanel:
    """What all panels of both places share."""

    bl_space_type, bl_region_type = "PROPERTIES", "WINDOW"
    bl_context = "render"

    def split(self) -> bpy.types.UILayout:
        """Where settings go: greyed out while a bake works by them."""
        layout = self.layout.column()
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.enabled = session.run is None
        return layout
