# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes: a Blender mesh as arrays of triangles."""

import bpy
import numpy as np

from ...gi_core.scene import LIGHTMAP_UV, Mesh


def read_mesh(mesh: bpy.types.Mesh, name: str) -> Mesh:
    """The triangles of an evaluated mesh as a `Mesh` called `name`."""
    mesh.calc_loop_triangles()
    count = len(mesh.loop_triangles)
    corners = _array(mesh.loop_triangles, "loops", count * 3, np.int32).reshape(count, 3)
    material_index = mesh.attributes.get("material_index")
    if material_index:
        of_polygon = _array(material_index.data, "value", len(mesh.polygons), np.int32)
        slots = of_polygon[_array(mesh.loop_triangles, "polygon_index", count, np.int32)]
    else:
        slots = np.zeros(count, np.int32)
    return Mesh(
        name=name,
        vertices=_array(mesh.vertices, "co", len(mesh.vertices) * 3, np.float32).reshape(-1, 3),
        triangles=_array(mesh.loop_triangles, "vertices", count * 3, np.int32).reshape(count, 3),
        normals=_array(mesh.corner_normals, "vector", len(mesh.loops) * 3, np.float32).reshape(-1, 3)[corners],
        slots=slots,
        uvs={
            layer.name: _array(layer.uv, "vector", len(mesh.loops) * 2, np.float32).reshape(-1, 2)[corners]
            for layer in mesh.uv_layers
        },
        render_uv=next((layer.name for layer in mesh.uv_layers if layer.active_render), ""),
        active_uv=next((layer.name for layer in (mesh.uv_layers.get(LIGHTMAP_UV), mesh.uv_layers.active) if layer), ""),
    )


def _array(collection: bpy.types.bpy_prop_collection, attribute: str, length: int, dtype: type) -> np.ndarray:
    array = np.empty(length, dtype)
    collection.foreach_get(attribute, array)
    return array
