# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Glossy parts of surface shaders: how rough they are and how much they reflect."""

import numpy as np

from ...gi_core.gloss import fresnel_mean
from ...gi_core.scene import BLACK, MATTE, WHITE, ColorSource, Gloss
from ..sentence import Sentence
from .colors import read_color, read_number
from .factors import read_factor
from .nodes import Feed, Reading
from .sources import constant, mean, scaled, total


def glossy_bsdf(source: Feed, reading: Reading) -> Gloss:
    """The `Gloss` of a Glossy BSDF, which reflects its colour at every angle."""
    color = read_color(source.input("Color"), reading, "the colour")
    return Gloss(_roughness(source, "Anisotropy", reading), color, color, WHITE)


def principled_gloss(source: Feed, reading: Reading) -> Gloss:
    """The `Gloss` of a Principled BSDF: its metal's and its dielectric's."""
    metal, glass, ior, level = (
        read_number(source.input(name), reading, name.lower())
        for name in ("Metallic", "Transmission Weight", "IOR", "Specular IOR Level")
    )
    if not np.allclose(read_color(source.input("Specular Tint"), reading, "the specular tint").value, 1):
        reading.note("its specular tint is left out")
    base = scaled(read_color(source.input("Base Color"), reading, "the base colour"), metal) if metal > 0 else BLACK
    return Gloss(
        roughness=_roughness(source, "Anisotropic", reading),
        specular=base,
        edge=constant(metal),
        metal=constant(metal),
        dielectric=constant((1 - metal) * (1 - glass)),
        ior=specular_ior(ior, level),
    )


def specular_ior(ior: float = 1.5, level: float = 0.5) -> float:
    """Index of refraction whose reflectance is what Principled's Specular IOR Level makes of that of `ior`."""
    root = np.sqrt(min(((ior - 1) / (ior + 1)) ** 2 * 2 * max(level, 0.0), 0.99))
    return float((1 + root) / (1 - root))


def gloss_sum(parts: list[tuple[float, Gloss]], reading: Reading) -> Gloss:
    """Shaders' glossy parts added up, each by its weight; of different roughness the mean is taken, and noted."""
    parts = [(weight, gloss) for weight, gloss in parts if weight > 0 and not gloss.is_none]
    if len(parts) < 2:
        return _scaled(parts[0][1], parts[0][0]) if parts else MATTE
    weights = [weight * _strength(gloss) for weight, gloss in parts]
    made = {
        name: total([scaled(getattr(gloss, name), weight) for weight, gloss in parts], reading, "what it reflects")
        for name in ("specular", "edge", "metal", "dielectric")
    }
    roughness = parts[0][1].roughness
    if any(not _same(gloss.roughness, roughness) for _, gloss in parts):
        roughness = constant(np.average([mean(gloss.roughness)[0] for _, gloss in parts], weights=weights))
        reading.note(
            Sentence(
                "its roughness, a mix of several, is taken as {value:.3g} everywhere", value=float(roughness.value[0])
            )
        )
    _, ior = max((weight * mean(gloss.dielectric)[0], gloss.ior) for weight, gloss in parts)
    return Gloss(roughness, ior=ior, **made)


def _scaled(gloss: Gloss, weight: float) -> Gloss:
    colors = (scaled(color, weight) for color in (gloss.specular, gloss.edge, gloss.metal, gloss.dielectric))
    return Gloss(gloss.roughness, *colors, gloss.ior)


def _strength(gloss: Gloss) -> float:
    """Roughly how much it reflects."""
    return float(np.mean(mean(gloss.specular) + mean(gloss.dielectric) * fresnel_mean(gloss.ior)))


def _same(a: ColorSource, b: ColorSource) -> bool:
    return a.texture is b.texture and a.uv == b.uv and np.array_equal(a.value, b.value)


def _roughness(source: Feed, anisotropy: str, reading: Reading) -> ColorSource:
    if read_number(source.input(anisotropy), reading, "anisotropy"):
        reading.note("its anisotropy is left out")
    if source.node.distribution != "MULTI_GGX":
        reading.note(Sentence("'{node}' is taken as Multiscatter GGX", node=source.node.name))
    return read_factor(source.input("Roughness"), reading, "its roughness")
