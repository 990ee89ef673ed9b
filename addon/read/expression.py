# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a socket computes: all that feeds it, what else than the surface that depends on, and a hash of it."""

import hashlib
from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np

from ..sentence import Sentence
from .constants import estimate
from .nodes import Feed, Reading, feed, set_value
from .signatures import signature

# Outputs that say something of where the surface is looked at from, by type of node; None for all of them.
_OF_VIEW = {
    "LIGHT_PATH": None,
    "FRESNEL": None,
    "LAYER_WEIGHT": None,
    "CAMERA": None,
    "TEX_COORD": {"Camera", "Window", "Reflection"},
    "NEW_GEOMETRY": {"Incoming"},
}

# Outputs that say something of the object and where it stands, so that objects of one mesh differ.
_OF_OBJECT = {
    "OBJECT_INFO": {"Location", "Color", "Alpha", "Object Index", "Random"},
    "NEW_GEOMETRY": {"Position", "Normal", "True Normal", "Tangent"},
    "VECT_TRANSFORM": None,
    "BUMP": None,
    "DISPLACEMENT": None,
    "VECTOR_DISPLACEMENT": None,
    "NORMAL_MAP": None,
    "BEVEL": None,
    "TANGENT": None,
    "TEX_ENVIRONMENT": None,
    "TEX_SKY": None,
}

# What lies beyond the object that is baked, and what makes copies of one object differ: these are not there.
_NOT_THERE = {
    "AMBIENT_OCCLUSION": "'{node}' sees nothing but the object itself",
    "PARTICLE_INFO": "'{node}' is left at 0",
    "HAIR_INFO": "'{node}' is left at 0",
    "POINT_INFO": "'{node}' is left at 0",
    "VOLUME_INFO": "'{node}' is left at 0",
}

# Place of an output in a tree: names of the group nodes that it lies in, outermost first, of its node, its identifier.
Key = tuple[tuple[str, ...], str, str]


@dataclass(frozen=True)
class Expression:
    """What is known of an output of a node.

    is_normal: whether it is wanted as a normal in the object's space, and not as it is; of displacement as that of the
    bump that it is seen as.
    signature: of all that it is computed from, which changes with the value, but for what depends on the object.
    of_object: whether it differs between objects of one mesh. of_shape: whether only between such as are scaled
    differently. random: outputs that are the object's random number.
    of_view: mean values of outputs that depend on the view. notes: what is not exact.
    """

    key: Key
    is_normal: bool
    name: str
    signature: bytes
    of_object: bool
    of_shape: bool
    random: tuple[Key, ...]
    of_view: dict[Key, np.ndarray]
    notes: tuple[str, ...]

    @property
    def wanted_as(self) -> tuple[Key, bool]:
        """What tells it from others of one material."""
        return self.key, self.is_normal


def expression(source: Feed, reading: Reading, is_normal: bool = False) -> Expression | None:
    """What a `Feed` computes, None where that is nothing but what depends on the view."""
    above = list(_upstream(source))
    of_view = {key_of(part): estimate(part, reading)[0] for part in above if _is(part, _OF_VIEW)}
    if of_view and all(_is(part, _OF_VIEW) or not _varies(part) for part in above):
        return None
    turns_along = is_normal and _turns_along(source)
    return Expression(
        key=key_of(source),
        is_normal=is_normal,
        name=source.node.name,
        signature=_signature(source, reading),
        of_object=not turns_along and any(map(_is_of_object, above)),
        of_shape=turns_along,
        random=tuple(key_of(p) for p in above if p.node.type == "OBJECT_INFO" and p.socket.name == "Random"),
        of_view=of_view,
        notes=tuple(dict.fromkeys(text for part in above for text in _notes(part))),
    )


def _notes(source: Feed) -> Iterator[str]:
    node = source.node
    if _is(source, _OF_VIEW):
        yield Sentence("'{node}' depends on the view, and its mean is taken", node=node.name)
    if what := _NOT_THERE.get(node.type):
        yield Sentence(what, node=node.name)
    if node.type == "NEW_GEOMETRY" and source.socket.name == "Pointiness":
        yield Sentence("'{node}' takes the mesh's triangles for how pointed it is", node=node.name)
    if node.type == "NEW_GEOMETRY" and source.socket.name == "Backfacing":
        yield Sentence("'{node}' tells sides apart, and both are taken as the front is", node=node.name)
    kind = getattr(node, "attribute_type", "GEOMETRY")
    if getattr(node, "from_instancer", False) or kind == "INSTANCER":
        yield Sentence("'{node}' is taken of the object, not of what shows copies of it", node=node.name)
    if kind == "VIEW_LAYER":
        yield Sentence("'{node}' is left at 0", node=node.name)


def key_of(source: Feed) -> Key:
    """Where in its tree an output is."""
    return tuple(group.name for group in source.groups), source.node.name, source.socket.identifier


def _upstream(source: Feed, known: set | None = None) -> Iterator[Feed]:
    """All outputs that a `Feed` is computed from, itself first, each once."""
    known = set() if known is None else known
    if source.node is None or key_of(source) in known:
        return
    known.add(key_of(source))
    yield source
    if not _is(source, _OF_VIEW):
        for socket in source.node.inputs:
            if not socket.is_unavailable:
                yield from _upstream(feed(socket, source.groups), known)


def _is(source: Feed, kinds: dict[str, set[str] | None]) -> bool:
    names = kinds.get(source.node.type, ())
    return names is None or source.socket.name in names


def _is_of_object(source: Feed) -> bool:
    return _is(source, _OF_OBJECT) or _names_object(source.node)


def _turns_along(source: Feed) -> bool:
    """Whether a normal turns with its object, so that in the object's space it is always the same."""
    node = source.node
    if node is None:
        return True
    if node.type not in {"BUMP", "DISPLACEMENT", "NORMAL_MAP"} or (node.type == "NORMAL_MAP" and "WORLD" in node.space):
        return False
    inputs = [source.input(socket.name) for socket in node.inputs if socket.name != "Normal"]
    if any(_is_of_object(part) for one in inputs for part in _upstream(one)):
        return False
    return node.type == "NORMAL_MAP" or _turns_along(source.input("Normal"))


def _names_object(node: bpy.types.Node) -> bool:
    return bool(getattr(node, "object", None)) or getattr(node, "attribute_type", "GEOMETRY") in {"OBJECT", "INSTANCER"}


def _varies(source: Feed) -> bool:
    """Whether an output may differ from place to place by itself."""
    kind = source.node.type
    others = {"ATTRIBUTE", "VERTEX_COLOR", "UVMAP", "OBJECT_INFO", "WIREFRAME", "SCRIPT", "NEW_GEOMETRY"}
    return kind.startswith("TEX_") or kind in {*others, *_OF_OBJECT, *_NOT_THERE}


def _signature(source: Feed, reading: Reading, known: dict | None = None) -> bytes:
    known = {} if known is None else known
    if source.node is None:
        return repr(set_value(source.socket).tolist()).encode()
    if key_of(source) not in known:
        known[key_of(source)] = b"itself"  # zones go around in circles
        parts = [source.node.bl_idname, source.socket.identifier, signature(source.node, reading.frame)]
        if _is(source, _OF_VIEW):
            parts.append(estimate(source, reading)[0].tolist())
        else:
            for socket in source.node.inputs:
                if not socket.is_unavailable:
                    parts += [socket.identifier, _signature(feed(socket, source.groups), reading, known)]
        known[key_of(source)] = hashlib.sha256(repr(parts).encode()).digest()
    return known[key_of(source)]
