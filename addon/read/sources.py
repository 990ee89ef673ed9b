# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic of `ColorSource`: exact for constants, and texel by texel for textures that lie alike."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from ...gi_core.scene import WHITE, ColorSource, Texture
from ..sentence import Sentence, said
from .nodes import Mismatch, Reading


def constant(value: float | np.ndarray) -> ColorSource:
    """A `ColorSource` of one colour; `value` a number or three."""
    return ColorSource(np.broadcast_to(value, 3).astype(np.float32))


def scaled(color: ColorSource, factor: float | np.ndarray) -> ColorSource:
    """`color` times `factor`, a number or three."""
    return ColorSource((color.value * factor).astype(np.float32), color.texture, color.uv)


def mean(color: ColorSource) -> np.ndarray:
    """The mean of a `ColorSource` over its texture: (3,) float64."""
    return color.value * (color.texture.pixels.mean((0, 1), dtype=np.float64) if color.texture else 1.0)


def product(a: ColorSource, b: ColorSource, reading: Reading, what: str) -> ColorSource:
    """a · b; of images that do not lie alike the second's mean is taken, and noted."""
    if a.texture is None or b.texture is None:
        return scaled(b, a.value) if a.texture is None else scaled(a, b.value)
    if not are_alike([a, b]):
        _mismatch(reading)
        reading.note(Sentence("{what}, a product of two images, is taken with the second one's mean", what=said(what)))
        return scaled(a, mean(b))
    return _texel_by_texel(np.multiply, [a, b])


def total(colors: list[ColorSource], reading: Reading, what: str) -> ColorSource:
    """The sum of several `ColorSource`; of images that do not lie alike, that of their means, which is noted."""
    colors = [color for color in colors if color.value.any()]
    if not colors:
        return constant(0.0)
    if len({(id(color.texture), color.uv) for color in colors}) == 1:
        return ColorSource(sum(color.value for color in colors), colors[0].texture, colors[0].uv)
    if are_alike(colors):
        return _texel_by_texel(lambda *values: sum(values), colors)
    _mismatch(reading)
    value = sum(mean(color) for color in colors)
    reading.note(
        Sentence(
            "{what}, a mix of several images, is taken as {value} everywhere", what=said(what), value=text(value)
        )
    )
    return constant(value)


def complement(a: ColorSource) -> ColorSource:
    """1 − a."""
    return applied(lambda values: 1 - values, a)


def quotient(a: ColorSource, b: ColorSource, reading: Reading, what: str) -> ColorSource:
    """a / b, which is more than nothing; see `product`."""
    return product(a, applied(lambda values: 1 / np.maximum(values, 1e-3), b), reading, what)


def applied(function: Callable[[np.ndarray], np.ndarray], a: ColorSource) -> ColorSource:
    """A function of a `ColorSource`'s values."""
    return constant(function(a.value)) if a.texture is None else _texel_by_texel(function, [a])


def are_alike(colors: list[ColorSource]) -> bool:
    """Whether what textures there are have their texels in the same places."""
    textures = [color.texture for color in colors if color.texture]
    kinds = {(t.pixels.shape, t.extension, t.interpolation) for t in textures}
    places = {color.uv for color in colors if color.texture}
    # Beyond one that is clipped it is black, which is not what would be made of black.
    return len(places) <= 1 and len(kinds) <= 1 and not any(t.extension == "CLIP" for t in textures)


def _texel_by_texel(function: Callable[..., np.ndarray], colors: list[ColorSource]) -> ColorSource:
    texture, uv = next((color.texture, color.uv) for color in colors if color.texture)
    pixels = function(*(color.value * color.texture.pixels if color.texture else color.value for color in colors))
    return ColorSource(WHITE.value, replace(texture, encoded=None, pixels=pixels.astype(np.float32)), uv)


def _mismatch(reading: Reading) -> None:
    """Where everything may be baked to one place, that is what should be done."""
    if reading.wanted is not None and not reading.whole:
        raise Mismatch


def grey(texture: Texture, values: np.ndarray) -> Texture:
    """`texture` with (h, w) `values` in all channels."""
    pixels = np.broadcast_to(values.astype(np.float32)[..., None], (*values.shape, 3))
    return replace(texture, encoded=None, pixels=pixels)


def text(value: np.ndarray) -> str:
    """A colour as notes have it."""
    return "({:.3g}, {:.3g}, {:.3g})".format(*value)
