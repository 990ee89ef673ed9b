# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shader node trees: what feeds a socket."""

from dataclasses import dataclass, field

import bpy
import numpy as np

from ..sentence import Sentence, said
from ..write.placement import shows_light
from .images import ImageReader


@dataclass(frozen=True)
class Feed:
    """Where a socket gets its value: an output `socket` of `node`, or, with `node` None, the value set on `socket`.

    groups: the group nodes that `socket` lies in, outermost first.
    """

    node: bpy.types.Node | None
    socket: bpy.types.NodeSocket
    groups: tuple[bpy.types.Node, ...]

    def input(self, name: str | int) -> "Feed":
        """The `Feed` of an input of `node`, by name or index."""
        return feed(self.node.inputs[name], self.groups)


class Mismatch(Exception):
    """Textures that do not lie alike are to be reckoned with one another: read the tree again as a `whole`."""


@dataclass(frozen=True)
class Reading:
    """What a tree is read with.

    owner: whose it is, as notes begin: "Material 'Wall'".
    images: gives the textures.
    notes: sentences on what was approximated.
    known: what `constants.estimate` has found out.
    glossy: whether surfaces' glossy parts are read too.
    wanted: collects the `Expression` of outputs that are to be baked, by their keys; None where nothing is baked.
    baked: the textures of those that were, by the same keys; None in a first reading.
    whole: images are baked too, so that all that varies lies alike.
    frame: of the scene.
    displacement: what is to be seen as relief wherever a shader's Normal is not linked.
    """

    owner: str
    images: ImageReader
    notes: list[str]
    known: dict = field(default_factory=dict)
    glossy: bool = False
    wanted: dict | None = None
    baked: dict | None = None
    whole: bool = False
    frame: float = 0.0
    displacement: Feed | None = None

    def note(self, text: str) -> None:
        """Tells something of the owner."""
        self.note_once(Sentence("{owner}: {text}.", owner=said(self.owner), text=said(text)))

    def note_once(self, sentence: str) -> None:
        """Tells something of the whole scene."""
        if sentence not in self.notes:
            self.notes.append(sentence)


def node_tree(owner: bpy.types.Material | bpy.types.Light | bpy.types.World) -> bpy.types.NodeTree | None:
    """The node tree of a material, light or world; None where it has none or does not use it."""
    # Since 5.0, for lights since later, every tree is used, and asking for `use_nodes` warns.
    always = getattr(owner.bl_rna.properties["use_nodes"], "is_deprecated", False)
    return owner.node_tree if always or owner.use_nodes else None


def output_feed(tree: bpy.types.NodeTree, type: str, name: str) -> Feed | None:
    """The `Feed` of input `name` of the output node that Cycles takes, None where there is none or nothing is linked.

    type: "OUTPUT_MATERIAL", "OUTPUT_WORLD" or "OUTPUT_LIGHT".
    """
    outputs = [node for node in tree.nodes if node.type == type and node.target in {"ALL", "CYCLES"}]
    # The active one of those for Cycles comes before the active one of those for all.
    outputs.sort(key=lambda node: (node.target == "CYCLES", node.is_active_output), reverse=True)
    if not outputs:
        return None
    source = feed(outputs[0].inputs[name])
    return source if source.node else None


def feed(socket: bpy.types.NodeSocket, groups: tuple[bpy.types.Node, ...] = ()) -> Feed:
    """The `Feed` of an input socket, through reroutes, node groups and muted nodes, and past what shows baked light."""
    while True:
        link = next((link for link in socket.links if link.is_valid and not link.is_muted), None)
        if link is None:
            return Feed(None, socket, groups)
        node, source = link.from_node, link.from_socket
        if node.mute:
            inner = next((link for link in node.internal_links if link.to_socket == source), None)
            if inner is None:
                return Feed(None, source, groups)
            socket = inner.from_socket
        elif node.type == "REROUTE":
            socket = node.inputs[0]
        elif shows_light(node):
            socket = node.inputs["Shader"]
        elif node.type == "GROUP" and node.node_tree:
            output = next((n for n in node.node_tree.nodes if n.type == "GROUP_OUTPUT" and n.is_active_output), None)
            if output is None:
                return Feed(None, source, groups)
            socket, groups = _same(output.inputs, source), (*groups, node)
        elif node.type == "GROUP_INPUT":
            socket, groups = _same(groups[-1].inputs, source), groups[:-1]
        else:
            return Feed(node, source, groups)


def _same(sockets, socket: bpy.types.NodeSocket) -> bpy.types.NodeSocket:
    return next(other for other in sockets if other.identifier == socket.identifier)


def set_value(socket: bpy.types.NodeSocket) -> np.ndarray:
    """The value set on a socket as (3,) float64; zero where it has none."""
    value = np.array(getattr(socket, "default_value", 0.0), np.float64).ravel()
    return np.resize(value[:3], 3)
