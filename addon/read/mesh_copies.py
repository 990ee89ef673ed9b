# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of evaluated meshes that outlive the evaluation: the same triangles, with all that materials look up."""

import hashlib
from dataclasses import dataclass
from functools import cached_property

import bpy
import numpy as np

from ...gi_core.scene import Mesh

# Property and numbers to a value, by the type of an attribute.
_VALUES = {
    "FLOAT": ("value", 1, np.float32),
    "INT": ("value", 1, np.int32),
    "INT8": ("value", 1, np.int8),
    "BOOLEAN": ("value", 1, bool),
    "FLOAT_VECTOR": ("vector", 3, np.float32),
    "FLOAT2": ("vector", 2, np.float32),
    "FLOAT_COLOR": ("color", 4, np.float32),
    "BYTE_COLOR": ("color", 4, np.float32),
    "QUATERNION": ("value", 4, np.float32),
}

# Attributes that the copy has anyway.
_OWN = {"position", "material_index", "sharp_face", "custom_normal"}


@dataclass(frozen=True)
class MeshCopy:
    """Triangles with their attributes.

    mesh: the same triangles as techniques see them. resting: (v, 3) float32, where vertices are before modifiers move
        them, which "Generated" coordinates go by; None where they are not moved. texture_space: location and size.
    attributes: name -> (type, domain, values), in order. color: name of the colour attribute that renders.
    """

    mesh: Mesh
    resting: np.ndarray | None
    texture_space: tuple[tuple[float, ...], tuple[float, ...]]
    attributes: dict[str, tuple[str, str, np.ndarray]]
    color: str

    @staticmethod
    def of(source: bpy.types.Object, mesh: Mesh) -> "MeshCopy":
        """The copy of an evaluated object's mesh, which was read as `mesh`."""
        made = source.to_mesh()
        made.calc_loop_triangles()
        count = len(made.loop_triangles)
        corners, faces = np.empty(3 * count, np.int32), np.empty(count, np.int32)
        made.loop_triangles.foreach_get("loops", corners)
        made.loop_triangles.foreach_get("polygon_index", faces)
        rows = {"POINT": slice(None), "CORNER": corners, "FACE": faces}
        attributes = {
            a.name: (a.data_type, a.domain, _values(a)[rows[a.domain]])
            for a in made.attributes
            if a.domain in rows and a.data_type in _VALUES and a.name not in _OWN and not a.name.startswith(".")
        }
        color = made.attributes.default_color_name or ""
        source.to_mesh_clear()
        data = source.data
        resting = np.empty(3 * len(data.vertices), np.float32)
        data.vertices.foreach_get("undeformed_co", resting)
        resting = resting.reshape(-1, 3)
        if resting.shape != mesh.vertices.shape or np.array_equal(resting, mesh.vertices):
            resting = None
        space = tuple(data.texspace_location), tuple(data.texspace_size)
        return MeshCopy(mesh, resting, space, attributes, color)

    @cached_property
    def signature(self) -> bytes:
        """A hash of all of it."""
        digest = hashlib.sha256(repr((self.texture_space, self.color, self.mesh.render_uv)).encode())
        arrays = {name: getattr(self.mesh, name) for name in ("vertices", "triangles", "normals", "slots")}
        arrays |= {"resting": self.resting} if self.resting is not None else {}
        arrays |= {name: values for name, (_, _, values) in self.attributes.items()}
        for name, array in arrays.items():
            digest.update(repr((name, array.shape, array.dtype.str)).encode() + np.ascontiguousarray(array).tobytes())
        return digest.digest()

    def build(self, name: str) -> bpy.types.Object:
        """An object of a new mesh, linked nowhere. Removing the mesh removes it."""
        count = len(self.mesh.triangles)
        mesh = bpy.data.meshes.new(name)
        obj = bpy.data.objects.new(name, mesh)
        mesh.vertices.add(len(self.mesh.vertices))
        mesh.loops.add(3 * count)
        mesh.polygons.add(count)
        mesh.polygons.foreach_set("loop_start", np.arange(0, 3 * count, 3, dtype=np.int32))
        mesh.loops.foreach_set("vertex_index", np.ascontiguousarray(self.mesh.triangles).reshape(-1))
        still = self.mesh.vertices if self.resting is None else self.resting
        mesh.vertices.foreach_set("co", np.ascontiguousarray(still).reshape(-1))
        mesh.update(calc_edges=True)
        for title, (kind, domain, values) in self.attributes.items():
            attribute = mesh.attributes.new(title, kind, domain)
            attribute.data.foreach_set(_VALUES[kind][0], np.ascontiguousarray(values).reshape(-1))
        if not mesh.uv_layers:  # without one, the one to bake to would be where images are looked up
            mesh.uv_layers.new(name=name, do_init=False)
        if self.mesh.render_uv in mesh.uv_layers:
            mesh.uv_layers[self.mesh.render_uv].active_render = True
        if self.color in mesh.attributes:
            mesh.attributes.default_color_name = self.color
        mesh.use_auto_texspace = False
        mesh.texspace_location, mesh.texspace_size = self.texture_space
        if bpy.app.version >= (5, 0, 0):
            normals = mesh.attributes.new("custom_normal", "FLOAT_VECTOR", "CORNER")
            normals.data.foreach_set("vector", np.ascontiguousarray(self.mesh.normals).reshape(-1))
        else:  # with such an attribute Blender 4.5 leaves faces out of a bake; this is slower
            mesh.normals_split_custom_set(self.mesh.normals.reshape(-1, 3))
        if self.resting is not None:
            obj.shape_key_add(name="Basis")
            moved = obj.shape_key_add(name="Moved", from_mix=False)
            moved.data.foreach_set("co", np.ascontiguousarray(self.mesh.vertices).reshape(-1))
            moved.value = 1
        return obj


def _values(attribute: bpy.types.Attribute) -> np.ndarray:
    name, size, dtype = _VALUES[attribute.data_type]
    values = np.empty(len(attribute.data) * size, dtype)
    attribute.data.foreach_get(name, values)
    return values.reshape(-1, size) if size > 1 else values
