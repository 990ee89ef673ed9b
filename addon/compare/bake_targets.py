# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What `object.bake` writes to, for a while: an image in copies of an object's materials, or a colour attribute."""

import contextlib

import bpy
import numpy as np


@contextlib.contextmanager
def bake_image(resolution):
    image = bpy.data.images.new(
        "GI Bake reference", resolution, resolution, alpha=True, float_buffer=True, is_data=True
    )
    try:
        yield image
    finally:
        bpy.data.images.remove(image)


@contextlib.contextmanager
def materials_with(obj, image):
    """The object's materials replaced by copies in which the image is what `object.bake` writes to."""
    copies, slots = {}, []
    with _at_least_one_slot(obj):
        try:
            for slot in obj.material_slots:
                link, material = slot.link, slot.material
                if material not in copies:
                    copies[material] = _copy_with(material, image)
                # The object's own choice goes before the mesh's, which other objects may share.
                slot.link = "OBJECT"
                slots.append((slot, link, slot.material))
                slot.material = copies[material]
            yield
        finally:
            for slot, link, material in slots:
                slot.material = material
                slot.link = link
            bpy.data.batch_remove(list(copies.values()))


@contextlib.contextmanager
def _at_least_one_slot(obj):
    if obj.material_slots:
        yield
        return
    mesh = obj.data
    indices = _material_indices(mesh)
    mesh.materials.append(None)
    try:
        yield
    finally:
        mesh.materials.clear()
        # With the slots Blender drops what faces asked for.
        if indices is not None:
            mesh.attributes.new("material_index", "INT", "FACE").data.foreach_set("value", indices)


def _copy_with(material, image):
    """A copy of the material with an active node for the image; without nodes, the surface that Cycles makes of it."""
    if material and material.node_tree and (bpy.app.version >= (5, 0) or material.use_nodes):
        copy = material.copy()
        nodes = copy.node_tree.nodes
    else:
        copy = bpy.data.materials.new("GI Bake reference")
        if not copy.node_tree:
            copy.use_nodes = True
        nodes = copy.node_tree.nodes
        nodes.clear()
        diffuse = nodes.new("ShaderNodeBsdfDiffuse")
        diffuse.inputs["Color"].default_value = material.diffuse_color if material else (0.8, 0.8, 0.8, 1.0)
        output = nodes.new("ShaderNodeOutputMaterial")
        copy.node_tree.links.new(diffuse.outputs["BSDF"], output.inputs["Surface"])
    node = nodes.new("ShaderNodeTexImage")
    node.image = image
    nodes.active = node
    return copy


@contextlib.contextmanager
def vertex_colors(mesh):
    """A colour attribute of the mesh's face corners, active so that `object.bake` writes to it; its name."""
    attributes = mesh.attributes
    before = {key: getattr(attributes, key) for key in ("active_color_name", "default_color_name", "active_index")}
    name = attributes.new("gi_bake_reference", "FLOAT_COLOR", "CORNER").name
    try:
        attributes.active_color_name = name
        # The default is what materials see; a mesh's first colours become it.
        attributes.default_color_name = before["default_color_name"]
        yield name
    finally:
        attributes.remove(attributes[name])
        for key, value in before.items():
            setattr(attributes, key, value)


def _material_indices(mesh):
    """The material slot of each face, (f,) int32; None where the mesh keeps none."""
    if "material_index" not in mesh.attributes:
        return None
    indices = np.empty(len(mesh.polygons), np.int32)
    mesh.attributes["material_index"].data.foreach_get("value", indices)
    return indices
