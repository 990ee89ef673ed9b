# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of node trees: a constant or an image times a constant where they are that, else their best constant."""

import bpy
import numpy as np

from ...gi_core.scene import ColorSource
from ..sentence import Sentence, said
from .baked import baked
from .constants import LUMINANCE, MIXES, estimate, is_color_mix, mix_inputs
from .images import is_known_space
from .nodes import Feed, Reading, feed, set_value
from .sources import constant, product, text


def read_color(source: Feed, reading: Reading, what: str) -> ColorSource:
    """A `Feed` as a `ColorSource`; what is not exact is noted, `what` naming the quantity."""
    color = baked(source, reading) if reading.baked else None
    if color is None:
        color = _exact(source, reading, what)
    if color is None:
        color = baked(source, reading)
    if color is not None:
        return color
    value, doubt = estimate(source, reading)
    reading.note(_everywhere(what, doubt, text(value)))
    return constant(value)


def _everywhere(what: str, doubt: str, value: str) -> Sentence:
    return Sentence(
        "{what}, which '{node}' gives, is taken as {value} everywhere", what=said(what), node=doubt, value=value
    )


def _exact(source: Feed, reading: Reading, what: str) -> ColorSource | None:
    """A constant, or an image times a constant; None for anything else."""
    node = source.node
    if node is None:
        return constant(set_value(source.socket))
    if node.type == "TEX_IMAGE" and source.socket.name == "Color" and (uv := uv_map(source, reading)) is not None:
        if node.interpolation not in {"Linear", "Closest"}:
            reading.note(
                Sentence(
                    "{what}: interpolation {kind} of '{node}' is taken as Linear", what=said(what),
                    kind=node.interpolation, node=node.name,
                )
            )  # fmt: skip
        return ColorSource(np.ones(3, np.float32), reading.images.texture(node, reading), uv)
    if node.type in MIXES and is_color_mix(node) and node.blend_type in {"MIX", "MULTIPLY"}:
        factor, a, b = (feed(socket, source.groups) for socket in mix_inputs(node))
        share, doubt = estimate(factor, reading)
        if not doubt and share[0] <= 0:
            return _exact(a, reading, what)
        if not doubt and share[0] >= 1:
            b = _exact(b, reading, what)
            if node.blend_type == "MIX" or b is None:
                return b
            a = _exact(a, reading, what)
            if a is not None and (a.texture is None or b.texture is None):
                return product(a, b, reading, what)
    value, doubt = estimate(source, reading)
    return None if doubt else constant(value)


def read_number(source: Feed, reading: Reading, what: str) -> float:
    """A `Feed` as a number; what is not exact is noted, `what` naming the quantity."""
    value, doubt = estimate(source, reading)
    number = float(value @ LUMINANCE if source.socket.type == "RGBA" else value.mean())
    if doubt:
        reading.note(_everywhere(what, doubt, f"{number:.3g}"))
    return number


def uv_map(source: Feed, reading: Reading) -> str | None:
    """Name of the UV map that an Image Texture node looks its image up at; None where it is anything else."""
    node = source.node
    if reading.whole or node.projection != "FLAT" or not _is_unmoved(node.texture_mapping):
        return None
    if node.image and (node.image.source not in {"FILE", "GENERATED"} or not is_known_space(node.image)):
        return None
    vector = source.input("Vector")
    while vector.node and vector.node.type == "MAPPING" and _is_identity(vector, reading):
        vector = vector.input("Vector")
    match vector.node and vector.node.type:
        case None:
            return ""
        case "UVMAP" if not vector.node.from_instancer:
            return vector.node.uv_map
        case "TEX_COORD" if vector.socket.name == "UV" and not vector.node.from_instancer:
            return ""
        case "ATTRIBUTE" if vector.node.attribute_type == "GEOMETRY" and vector.socket.name == "Vector":
            return vector.node.attribute_name
    return None


def _is_unmoved(mapping: bpy.types.TexMapping) -> bool:
    """Whether a texture node looks up where it is told to."""
    place = mapping.translation, mapping.rotation, mapping.scale
    axes = mapping.mapping_x, mapping.mapping_y, mapping.mapping_z
    return np.array_equal(place, [[0] * 3, [0] * 3, [1] * 3]) and axes == ("X", "Y", "Z")


def _is_identity(mapping: Feed, reading: Reading) -> bool:
    names = {socket.name for socket in mapping.node.inputs} & {"Location", "Rotation", "Scale"}
    for name in names:
        value, doubt = estimate(mapping.input(name), reading)
        if doubt or not np.allclose(value, 1.0 if name == "Scale" else 0.0):
            return False
    return True
