# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of node trees: a constant or an image times a constant where they are that, else their best constant."""

import numpy as np

from ...gi_core.scene import ColorSource
from .constants import LUMINANCE, MIXES, estimate, is_color_mix, mix_inputs
from .nodes import Feed, Reading, feed, set_value


def constant(value: float | np.ndarray) -> ColorSource:
    """A `ColorSource` of one colour; `value` a number or three."""
    return ColorSource(np.broadcast_to(value, 3).astype(np.float32))


def scaled(color: ColorSource, factor: float | np.ndarray) -> ColorSource:
    """`color` times `factor`, a number or three."""
    return ColorSource((color.value * factor).astype(np.float32), color.texture, color.uv)


def mean(color: ColorSource) -> np.ndarray:
    """The mean of a `ColorSource` over its texture: (3,) float64."""
    return color.value * (color.texture.pixels.mean((0, 1), dtype=np.float64) if color.texture else 1.0)


def total(colors: list[ColorSource], reading: Reading, what: str) -> ColorSource:
    """The sum of several `ColorSource`; where they have different textures, that of their means."""
    colors = [color for color in colors if color.value.any()]
    if not colors:
        return constant(0.0)
    if len({(id(color.texture), color.uv) for color in colors}) == 1:
        return ColorSource(sum(color.value for color in colors), colors[0].texture, colors[0].uv)
    value = sum(mean(color) for color in colors)
    reading.note(f"{what}, a mix of several images, is taken as {_text(value)} everywhere")
    return constant(value)


def read_color(source: Feed, reading: Reading, what: str) -> ColorSource:
    """A `Feed` as a `ColorSource`; what is not exact is noted, `what` naming the quantity."""
    node = source.node
    if node is None:
        return constant(set_value(source.socket))
    if node.type == "TEX_IMAGE" and source.socket.name == "Color" and (uv := uv_map(source, reading)) is not None:
        if node.interpolation not in {"Linear", "Closest"}:
            reading.note(f"{what}: interpolation {node.interpolation} of '{node.name}' is taken as Linear")
        return ColorSource(np.ones(3, np.float32), reading.images.texture(node, reading), uv)
    if node.type in MIXES and is_color_mix(node) and node.blend_type in {"MIX", "MULTIPLY"}:
        factor, a, b = (feed(socket, source.groups) for socket in mix_inputs(node))
        share, doubt = estimate(factor, reading)
        if not doubt:
            if share[0] <= 0:
                return read_color(a, reading, what)
            if share[0] >= 1:
                b = read_color(b, reading, what)
                if node.blend_type == "MIX":
                    return b
                a = read_color(a, reading, what)
                if a.texture is None or b.texture is None:
                    return scaled(b, a.value) if a.texture is None else scaled(a, b.value)
    value, doubt = estimate(source, reading)
    if doubt:
        reading.note(f"{what}, which '{doubt}' gives, is taken as {_text(value)} everywhere")
    return constant(value)


def read_number(source: Feed, reading: Reading, what: str) -> float:
    """A `Feed` as a number; what is not exact is noted, `what` naming the quantity."""
    value, doubt = estimate(source, reading)
    number = float(value @ LUMINANCE if source.socket.type == "RGBA" else value.mean())
    if doubt:
        reading.note(f"{what}, which '{doubt}' gives, is taken as {number:.3g} everywhere")
    return number


def _text(value: np.ndarray) -> str:
    return "({:.3g}, {:.3g}, {:.3g})".format(*value)


def uv_map(source: Feed, reading: Reading) -> str | None:
    """Name of the UV map that an Image Texture node looks its image up at; None where it is anything else."""
    node = source.node
    if node.projection != "FLAT" or (node.image and node.image.source not in {"FILE", "GENERATED"}):
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


def _is_identity(mapping: Feed, reading: Reading) -> bool:
    names = {socket.name for socket in mapping.node.inputs} & {"Location", "Rotation", "Scale"}
    for name in names:
        value, doubt = estimate(mapping.input(name), reading)
        if doubt or not np.allclose(value, 1.0 if name == "Scale" else 0.0):
            return False
    return True
