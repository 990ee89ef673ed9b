# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Factors of node trees, such as an alpha: a number or an image's channel, and what Math nodes make of one."""

import numpy as np

from ...gi_core.scene import ColorSource, Texture
from .baked import baked
from .colors import read_number, uv_map
from .constants import LUMINANCE, MATH, estimate
from .nodes import Feed, Reading
from .sources import constant, grey

_UNARY = {"ROUND": np.round, "FLOOR": np.floor, "CEIL": np.ceil, "ABSOLUTE": np.abs}
_BINARY = {
    **MATH,
    "DIVIDE": lambda a, b: np.where(b == 0, 0, a / np.where(b == 0, 1, b)),
    "GREATER_THAN": lambda a, b: a > b,
    "LESS_THAN": lambda a, b: a < b,
}


def read_factor(source: Feed, reading: Reading, what: str, highest: float = 1.0) -> ColorSource:
    """A `Feed` as a grey `ColorSource` of 0…`highest`; what is not exact is noted, `what` naming the quantity."""
    found = (reading.baked and _baked(source, reading)) or _pixels(source, reading) or _baked(source, reading)
    if found is None:
        return constant(np.clip(read_number(source, reading, what), 0, highest))
    values, texture, uv = found
    values = np.clip(np.asarray(values, np.float32), 0, highest)
    first = reading.wanted is not None and reading.baked is None  # what is one texel now will be many
    if texture is None or (np.ptp(values) == 0 and not first):
        return constant(values.flat[0])
    return ColorSource(np.ones(3, np.float32), grey(texture, values), uv)


def _baked(source: Feed, reading: Reading) -> tuple[float | np.ndarray, Texture | None, str] | None:
    """As `_pixels`, of what only Cycles can tell."""
    if source.node is None or (not reading.baked and not estimate(source, reading)[1]):
        return None
    if (color := baked(source, reading)) is None:
        return None
    weights = (LUMINANCE if source.socket.type == "RGBA" else np.full(3, 1 / 3)).astype(np.float32)
    values = color.texture.pixels * color.value if color.texture else color.value
    return values @ weights, color.texture, color.uv


def _pixels(source: Feed, reading: Reading) -> tuple[float | np.ndarray, Texture | None, str] | None:
    """A number or (h, w) values, the texture that they are laid out as, and its UV map; None for anything else."""
    node = source.node
    if node is None:
        return read_number(source, reading, ""), None, ""
    if node.type == "TEX_IMAGE" and (uv := uv_map(source, reading)) is not None:
        if source.socket.name == "Alpha":
            texture = reading.images.texture(node, reading, "ALPHA")
            return texture.pixels[..., 0], texture, uv
        texture = reading.images.texture(node, reading)
        return texture.pixels @ LUMINANCE.astype(np.float32), texture, uv
    if node.type != "MATH" or node.operation not in {*_UNARY, *_BINARY}:
        return None
    unary = node.operation in _UNARY
    parts = [_pixels(source.input(index), reading) for index in range(1 if unary else 2)]
    if any(part is None for part in parts):
        return None
    textures = [(texture, uv) for _, texture, uv in parts if texture]
    # What is black outside the image would not be what the node makes of black.
    if len({(id(texture), uv) for texture, uv in textures}) > 1 or any(t.extension == "CLIP" for t, _ in textures):
        return None
    function = (_UNARY if unary else _BINARY)[node.operation]
    values = np.asarray(function(*(values for values, _, _ in parts)), np.float32)
    if node.use_clamp:
        values = np.clip(values, 0, 1)
    return values, *(textures[0] if textures else (None, ""))
