# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Copies of materials that emit what one output of their nodes computes."""

import contextlib

import bpy
import numpy as np

from .expression import Key, key_of
from .nodes import output_feed


def socket_material(
    material: bpy.types.Material,
    key: Key,
    constants: dict[Key, np.ndarray],
    image: bpy.types.Image,
    gone: contextlib.ExitStack,
    signed: bool = False,
) -> bpy.types.Material:
    """A material whose emission is the output at `key`, and which bakes to `image`.

    signed: it is a normal, or displacement that is seen as a bump, with values from −1 to 1, which come as 0 to 1,
    since light below nothing is none.
    constants: values (3,) that take the place of other outputs. gone: takes all that is made away again.
    """
    copy = material.copy()
    gone.callback(bpy.data.materials.remove, copy)
    tree = copy.node_tree
    displacement = output_feed(tree, "OUTPUT_MATERIAL", "Displacement")
    raised = signed and displacement is not None and key_of(displacement) == key
    _own_groups(tree, gone)
    for (path, *place), value in constants.items():
        _fix(_tree_at(tree, path), *place, value)
    socket = _exposed(tree, *key)
    if raised:
        socket = _bump(tree, socket)
    if signed:
        node = tree.nodes.new("ShaderNodeVectorMath")
        node.operation = "MULTIPLY_ADD"
        tree.links.new(socket, node.inputs[0])
        node.inputs[1].default_value = node.inputs[2].default_value = (0.5, 0.5, 0.5)
        socket = node.outputs[0]
    for node in [node for node in tree.nodes if node.type == "OUTPUT_MATERIAL"]:
        tree.nodes.remove(node)
    emission, output = (tree.nodes.new(kind) for kind in ("ShaderNodeEmission", "ShaderNodeOutputMaterial"))
    tree.links.new(socket, emission.inputs["Color"])
    tree.links.new(emission.outputs[0], output.inputs["Surface"])
    target = tree.nodes.new("ShaderNodeTexImage")
    target.image = image
    tree.nodes.active = target
    return copy


def _bump(tree: bpy.types.NodeTree, displacement: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    """The normal that Cycles makes of displacement along the surface's own."""
    geometry, dot, bump = (tree.nodes.new(f"ShaderNode{k}") for k in ("NewGeometry", "VectorMath", "Bump"))
    dot.operation = "DOT_PRODUCT"
    tree.links.new(displacement, dot.inputs[0])
    tree.links.new(geometry.outputs["Normal"], dot.inputs[1])
    tree.links.new(dot.outputs["Value"], bump.inputs["Height"])
    bump.inputs["Strength"].default_value = bump.inputs["Distance"].default_value = 1
    return bump.outputs[0]


def _own_groups(tree: bpy.types.NodeTree, gone: contextlib.ExitStack) -> None:
    """Gives each group node of a tree a group of its own, all the way down."""
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree:
            node.node_tree = node.node_tree.copy()
            gone.callback(bpy.data.node_groups.remove, node.node_tree)
            _own_groups(node.node_tree, gone)


def _tree_at(tree: bpy.types.NodeTree, path: tuple[str, ...]) -> bpy.types.NodeTree:
    for name in path:
        tree = tree.nodes[name].node_tree
    return tree


def _output(tree: bpy.types.NodeTree, node: str, identifier: str) -> bpy.types.NodeSocket:
    return next(socket for socket in tree.nodes[node].outputs if socket.identifier == identifier)


def _fix(tree: bpy.types.NodeTree, node: str, identifier: str, value: np.ndarray) -> None:
    """Puts a constant in the place of an output."""
    socket = _output(tree, node, identifier)
    if socket.type == "VALUE":
        constant = tree.nodes.new("ShaderNodeValue").outputs[0]
        constant.default_value = float(value[0])
    else:
        constant = tree.nodes.new("ShaderNodeRGB").outputs[0]
        constant.default_value = (*value, 1)
    for target in [link.to_socket for link in socket.links]:
        tree.links.new(constant, target)


def _exposed(tree: bpy.types.NodeTree, path: tuple[str, ...], node: str, identifier: str) -> bpy.types.NodeSocket:
    """An output in the outermost tree with the value of one in a group."""
    if not path:
        return _output(tree, node, identifier)
    outer = tree.nodes[path[0]]
    inner = outer.node_tree
    socket = _exposed(inner, path[1:], node, identifier)
    kind = {"VALUE": "Float", "RGBA": "Color"}.get(socket.type, "Vector")
    made = inner.interface.new_socket("GI Bake", in_out="OUTPUT", socket_type=f"NodeSocket{kind}")
    output = next(n for n in inner.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output)
    inner.links.new(socket, next(s for s in output.inputs if s.identifier == made.identifier))
    return next(s for s in outer.outputs if s.identifier == made.identifier)
