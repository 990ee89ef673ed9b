# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Outputs of nodes that only Cycles can tell: asked for when a tree is read first, there when it is read again."""

import numpy as np

from ...gi_core.scene import WHITE, ColorSource, Texture
from .constants import estimate
from .expression import expression, key_of
from .nodes import Feed, Reading


def baked(source: Feed, reading: Reading, is_normal: bool = False) -> ColorSource | None:
    """A `Feed` as a texture, None where it is not baked. is_normal: as a normal in the object's space.

    In a first reading the texture is one texel, the best constant, which stands for the one that is to come.
    """
    if reading.wanted is None or source.node is None:
        return None
    key = key_of(source), is_normal
    if reading.baked is not None and key not in reading.baked:
        return None
    if key not in reading.wanted:
        reading.wanted[key] = expression(source, reading, is_normal)
    found = reading.wanted[key]
    if found is None:
        return None
    for text in found.notes:
        reading.note(text)
    if reading.baked is not None:
        return reading.baked[key]
    value, _ = estimate(source, reading)
    return ColorSource(WHITE.value, Texture(source.node.name, value.astype(np.float32)[None, None], "EXTEND"), "baked")
