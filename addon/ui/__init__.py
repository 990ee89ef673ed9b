# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The panels: in the Render properties, and the same in the 3D view's sidebar; one in the Object properties."""

import bpy

from . import techniques
from .extent import GI_PT_extent
from .main import GI_PT_main
from .object import GI_PT_object
from .results import GI_PT_results, GI_UL_results


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


_panels = (GI_PT_main, *techniques.PANELS, GI_PT_extent, GI_PT_results)
classes = (GI_UL_results, *_panels, *(_in_sidebar(panel) for panel in _panels), GI_PT_object)
register, unregister = bpy.utils.register_classes_factory(classes)
