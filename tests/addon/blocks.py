# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file holds, to tell whether anything was left in it."""

import bpy


def names():
    """Every data-block's name, by type, and each mesh's attributes."""
    kinds = ("objects", "meshes", "images", "materials", "scenes", "cameras", "node_groups", "volumes", "collections")
    found = {kind: sorted(block.name for block in getattr(bpy.data, kind)) for kind in kinds}
    return found | {mesh.name: sorted(mesh.attributes.keys()) for mesh in bpy.data.meshes}
