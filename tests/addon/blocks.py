# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a file holds, to tell whether anything was left in it."""

import bpy


def names():
    """Every data-block's name, by type, and each mesh's attributes."""
    kinds = ("objects", "meshes", "images", "materials", "scenes", "cameras", "node_groups", "volumes", "collections")
    found = {kind: sorted(block.name for block in getattr(bpy.data, kind)) for kind in kinds}
    return found | {mesh.name: sorted(mesh.attributes.keys()) for mesh in bpy.data.meshes}


def contents():
    """Every data-block with the values of its properties, groups of properties and lists in it, two levels deep."""
    kinds = [c for name in dir(bpy.data) if isinstance(c := getattr(bpy.data, name), bpy.types.bpy_prop_collection)]
    blocks = {block for kind in kinds for block in kind if not isinstance(block, _OF_THE_WINDOW)}
    return {f"{type(block).__name__} {block.name_full}": _values(block, 0) for block in blocks}


_OF_THE_WINDOW = (bpy.types.WindowManager, bpy.types.Screen, bpy.types.WorkSpace)
# Made when they are asked for, or of the window: Blender itself does not bring them back.
_NOT_KEPT = {
    "rna_type", "bl_rna", "session_uid", "users", "original", "is_evaluated", "preview", "particle_edit", "pixels",
    "loop_triangles", "loop_triangle_polygons", "corner_normals", "vertex_normals", "polygon_normals", "is_dirty",
    "tag", "is_updated", "is_updated_data", "id_data", "is_runtime_data", "uid", "normals_domain",
    "depsgraph", "use_nodes",
}  # fmt: skip


def _values(owner, depth):
    return {
        prop.identifier: _value(getattr(owner, prop.identifier), depth)
        for prop in owner.bl_rna.properties
        if prop.identifier not in _NOT_KEPT and hasattr(owner, prop.identifier)
    }


def _value(value, depth):
    if isinstance(value, bpy.types.ID):
        return value.name_full
    if isinstance(value, bpy.types.bpy_prop_collection):
        return len(value) if depth > 1 or len(value) > 100 else [_values(item, depth + 1) for item in value]
    if isinstance(value, bpy.types.bpy_struct):
        return _values(value, depth + 1) if depth < 2 else None
    return value if isinstance(value, (bool, int, float, str)) or value is None else repr(list(value))
