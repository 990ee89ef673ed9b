# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance per vertex as a colour attribute of the mesh as the user made it, before modifiers."""

import bpy
import numpy as np

from ..sentence import Sentence

ATTRIBUTE = "gi_irradiance"
CORNERS = "gi_irradiance_corner"
COVERAGE = "gi_coverage"


class AttributeTargetError(ValueError):
    """A mesh cannot take the attribute; the message names the object and the remedy."""


def check_targets(objects: list[bpy.types.Object], name: str = ATTRIBUTE, domain: str = "POINT") -> None:
    """Raise AttributeTargetError for the first object that cannot take the attribute; touches nothing.

    Refused are objects without a mesh, in edit mode, with linked meshes, with a mesh that other objects share (each
    needs its own light), and meshes where something else has the attribute's name.
    """
    for obj in objects:
        mesh = obj.data
        if obj.type != "MESH":
            said = Sentence("Object '{name}' has no mesh: convert it to one, or leave it out", name=obj.name)
            raise AttributeTargetError(said)
        if obj.mode == "EDIT":
            said = Sentence("Object '{name}' is in edit mode: leave edit mode first", name=obj.name)
            raise AttributeTargetError(said)
        if mesh.library is not None:
            said = Sentence("Object '{name}': its mesh comes from another file: make it local first", name=obj.name)
            raise AttributeTargetError(said)
        sharing = sorted(o.name for o in bpy.data.objects if o.data == mesh)
        if len(sharing) > 1:
            said = Sentence(
                "Objects {names} share the mesh '{mesh}', which can hold the light of one only: make them single-user "
                "(Object > Relations > Make Single User), or bake to lightmaps",
                names=", ".join(map(repr, sharing)), mesh=mesh.name,
            )  # fmt: skip
            raise AttributeTargetError(said)
        taken = mesh.attributes.get(name)
        if (taken and (taken.data_type, taken.domain) != ("FLOAT_COLOR", domain)) or name in obj.vertex_groups:
            said = Sentence(
                "Object '{name}': its mesh has another attribute or vertex group '{other}': rename or remove it",
                name=obj.name, other=name,
            )  # fmt: skip
            raise AttributeTargetError(said)


def write_irradiance(irradiance: dict[str, np.ndarray], name: str = ATTRIBUTE) -> None:
    """Store (v, 3) float32 per object as a FLOAT_COLOR attribute on its mesh's points, alpha 1.

    irradiance: object name -> values for the vertices of the object's own mesh. An attribute of ours is overwritten.
    Raises KeyError for an unknown object and AttributeTargetError for what `check_targets` refuses or a wrong number of
    vertices, all before the first mesh is touched.
    """
    objects = {bpy.data.objects[key]: values for key, values in irradiance.items()}
    check_targets(list(objects), name)
    for obj, values in objects.items():
        if values.shape != (len(obj.data.vertices), 3):
            raise AttributeTargetError(
                f"Object '{obj.name}': light for {len(values)} vertices does not fit its mesh of "
                f"{len(obj.data.vertices)}: modifiers change the mesh; apply them, or bake to a lightmap"
            )
    for obj, values in objects.items():
        rgba = np.ones((len(values), 4), np.float32)
        rgba[:, :3] = values
        mesh = obj.data
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT_COLOR", "POINT")
        attribute.data.foreach_set("color", rgba.ravel())
        mesh.update()


def loops_of(obj: bpy.types.Object, vertex: np.ndarray) -> np.ndarray:
    """The face corners of an object's own mesh that triangles' corners are: (3 t,), the latters' vertices -> (3 t,).

    Modifiers that move vertices may cut faces into other triangles. Raises AttributeTargetError where the triangles are
    not the mesh's.
    """
    mesh = obj.data
    mesh.calc_loop_triangles()
    faces = np.empty(len(mesh.loop_triangles), np.int64)
    mesh.loop_triangles.foreach_get("polygon_index", faces)
    if len(vertex) != 3 * len(faces):
        raise AttributeTargetError(
            f"Object '{obj.name}': light for {len(vertex) // 3} triangles does not fit its mesh of {len(faces)}: "
            "modifiers change the mesh; apply them, or bake to a lightmap"
        )
    totals, own = np.empty(len(mesh.polygons), np.int32), np.empty(len(mesh.loops), np.int32)
    mesh.polygons.foreach_get("loop_total", totals)
    mesh.loops.foreach_get("vertex_index", own)
    keys = np.repeat(np.arange(len(totals)), totals) * len(mesh.vertices) + own
    order = np.argsort(keys)
    asked = np.repeat(faces, 3) * len(mesh.vertices) + vertex
    found = order[np.minimum(np.searchsorted(keys, asked, sorter=order), len(order) - 1)]
    if not np.array_equal(keys[found], asked):
        raise AttributeTargetError(
            f"Object '{obj.name}': its faces are not those that were baked: modifiers change the mesh; apply them, or "
            "bake to a lightmap"
        )
    return found


def write_corners(irradiance: dict[str, np.ndarray], vertices: dict[str, np.ndarray], name: str = CORNERS) -> None:
    """Store light at the corners of triangles, object name -> (3 t, 3) float32, as a FLOAT_COLOR attribute of its face
    corners, alpha 1; a corner that several triangles of a face share takes their mean.

    vertices: object name -> (3 t,) int, the vertices of the triangles' corners.
    Raises what `write_irradiance` raises, where it does.
    """
    objects = {bpy.data.objects[key]: values for key, values in irradiance.items()}
    check_targets(list(objects), name, "CORNER")
    loops = {obj: loops_of(obj, vertices[obj.name]) for obj in objects}
    for obj, values in objects.items():
        mesh, corner = obj.data, loops[obj]
        count = np.maximum(np.bincount(corner, minlength=len(mesh.loops)), 1)
        rgba = np.ones((len(mesh.loops), 4), np.float32)
        for c in range(3):
            rgba[:, c] = np.bincount(corner, values[:, c], len(mesh.loops)) / count
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT_COLOR", "CORNER")
        attribute.data.foreach_set("color", rgba.ravel())
        mesh.update()


def write_coverage(coverage: dict[str, np.ndarray], name: str = COVERAGE) -> None:
    """Store (v,) float32 per object as a FLOAT attribute on its mesh's points: how surely a camera saw each, 0…1.

    For objects that `write_irradiance` took. An attribute of ours is overwritten; something else of that name is left,
    and its object goes without.
    """
    for key, values in coverage.items():
        mesh = bpy.data.objects[key].data
        attribute = mesh.attributes.get(name) or mesh.attributes.new(name, "FLOAT", "POINT")
        if (attribute.data_type, attribute.domain) == ("FLOAT", "POINT"):
            attribute.data.foreach_set("value", values.astype(np.float32))
            mesh.update()
