# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials and the nodes they are made of. Colours are scene-linear."""

import bpy

WHITE = (0.73, 0.73, 0.73)
RED = (0.63, 0.06, 0.05)
GREEN = (0.14, 0.45, 0.09)

DIFFUSE = "ShaderNodeBsdfDiffuse"
PRINCIPLED = "ShaderNodeBsdfPrincipled"


def diffuse(name, color):
    """A material that is one Diffuse BSDF of reflectance `color`."""
    return surface(name, lambda tree: node(tree, DIFFUSE, {"Color": color}))


def emission(name, color, strength):
    """A material that emits `color` times `strength` W/(m²·sr) and reflects nothing."""
    return surface(name, lambda tree: node(tree, "ShaderNodeEmission", {"Color": color, "Strength": strength}))


def surface(name, shader):
    """A material whose surface is the node that `shader(tree)` makes."""
    material = bpy.data.materials.new(name)
    material.use_nodes = True
    material.node_tree.nodes.clear()
    node(material.node_tree, "ShaderNodeOutputMaterial", {"Surface": shader(material.node_tree)})
    return material


def node(tree, kind, inputs=None, **settings):
    """A node of `kind` in `tree`, with `settings` for its properties.

    inputs: {name or number of an input: a value, a socket to link, or a node whose first output to link}.
    """
    made = tree.nodes.new(kind)
    for key, value in settings.items():
        setattr(made, key, value)
    for key, value in (inputs or {}).items():
        socket = made.inputs[key]
        if isinstance(value, bpy.types.Node):
            tree.links.new(value.outputs[0], socket)
        elif isinstance(value, bpy.types.NodeSocket):
            tree.links.new(value, socket)
        else:
            socket.default_value = (*value, 1) if socket.type == "RGBA" else value
    return made
