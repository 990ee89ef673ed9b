# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface shaders: their diffuse and emitting parts, which are what a bake of diffuse light takes of them, and their
glossy ones where they are asked for."""

from dataclasses import dataclass, replace

import numpy as np

from ...gi_core.gloss import fresnel_mean
from ...gi_core.scene import BLACK, MATTE, WHITE, ColorSource, Gloss
from ..sentence import Sentence
from .colors import read_color, read_number
from .constants import estimate
from .factors import read_factor
from .gloss import gloss_sum, glossy_bsdf, principled_gloss, specular_ior
from .nodes import Feed, Reading, set_value
from .normals import read_normal
from .sources import applied, are_alike, complement, constant, mean, product, quotient, total

# Without `glossy`, and with it.
_GLOSS_NOTES = (
    Sentence("Reflections in glossy surfaces are not baked; they light other surfaces as if they were diffuse."),
    Sentence("What glossy surfaces reflect lights other surfaces as if it were diffuse."),
)
_VIEW_NOTE = Sentence(
    "What a Principled BSDF reflects diffusely depends on the view; its mean over all views is taken."
)


@dataclass(frozen=True)
class Surface:
    """Diffuse reflectance, emitted radiance, gloss and normal of a shader's solid part, and the share that is solid;
    see `scene.Material`."""

    albedo: ColorSource = BLACK
    emission: ColorSource = BLACK
    alpha: ColorSource = WHITE
    gloss: Gloss = MATTE
    gloss_albedo: ColorSource = BLACK
    normal: ColorSource | None = None

    @property
    def is_clear(self) -> bool:
        """Whether all light passes through."""
        return self.alpha.texture is None and not self.alpha.value.any()


def read_surface(source: Feed, reading: Reading) -> Surface:
    """The `Surface` of a shader's `Feed`; what it has besides, or has in a less simple form, is noted."""
    node = source.node
    match node and node.type:
        case None:
            return Surface()
        case "BSDF_DIFFUSE":
            _note_roughness(source, "Roughness", reading)
            return _diffuse(source, reading)
        case "EMISSION" | "BACKGROUND":
            return Surface(emission=_emission(source, "Color", "Strength", reading))
        case "BSDF_PRINCIPLED":
            return _principled(source, reading)
        case "BSDF_GLOSSY":
            reading.note_once(_GLOSS_NOTES[reading.glossy])
            color = _reflectance(source.input("Color"), reading, "the colour")
            gloss = glossy_bsdf(source, reading) if reading.glossy else MATTE
            return Surface(gloss=gloss, gloss_albedo=color, normal=read_normal(source.input("Normal"), reading))
        case "MIX_SHADER":
            return _mix(source, reading)
        case "BSDF_TRANSPARENT":
            color = mean(read_color(source.input("Color"), reading, "the colour of what is transparent"))
            if np.ptp(color) > 0:
                reading.note(Sentence("'{node}' lets light of all colours through alike", node=node.name))
            return Surface(alpha=constant(np.clip(1 - color.mean(), 0, 1)))
        case "ADD_SHADER":
            return _sum([(WHITE, read_surface(source.input(index), reading)) for index in (0, 1)], reading)
        case "SUBSURFACE_SCATTERING" | "BSDF_TRANSLUCENT" | "BSDF_SHEEN" | "BSDF_TOON":
            reading.note(Sentence("'{node}' is taken as diffuse", node=node.name))
            return _diffuse(source, reading)
    reading.note(
        Sentence("'{node}' has no diffuse part; what it reflects or lets through is left out", node=node.name)
    )
    return Surface()


def _diffuse(source: Feed, reading: Reading) -> Surface:
    color = _reflectance(source.input("Color"), reading, "the colour")
    return Surface(albedo=color, normal=read_normal(source.input("Normal"), reading))


def _reflectance(source: Feed, reading: Reading, what: str) -> ColorSource:
    """The colour of something that reflects, not below nothing, as in Cycles."""
    color = read_color(source, reading, what)
    return color if _lowest(color) >= 0 else applied(lambda values: np.maximum(values, 0), color)


def _lowest(color: ColorSource) -> float:
    # Bytes are nothing at the least, and not looked at.
    plain = color.texture is None or color.texture.encoded is not None
    return float((color.value if plain else color.value * color.texture.pixels.min((0, 1))).min())


def _principled(source: Feed, reading: Reading) -> Surface:
    def number(name):
        return read_number(source.input(name), reading, name.lower())

    _note_roughness(source, "Diffuse Roughness", reading)
    for name in ("Coat Weight", "Sheen Weight"):
        if _in_use(source, name):
            reading.note(Sentence("its {what} is left out", what=Sentence(name.split()[0].lower())))
    if _in_use(source, "Subsurface Weight"):
        reading.note("subsurface scattering is taken as diffuse")
    metal, glass = (read_factor(source.input(n), reading, n.lower()) for n in ("Metallic", "Transmission Weight"))
    opaque = complement(metal)
    dull = product(opaque, complement(glass), reading, "what is neither metal nor glass")
    if mean(glass)[0] * (1 - mean(metal)[0]) > 0:
        share = float(mean(opaque)[0] - mean(dull)[0])
        reading.note(Sentence("{share:.0%} of it is glass, whose light is left out", share=share))
    normal = read_normal(source.input("Normal"), reading)
    albedo = gloss_albedo = BLACK
    if dull.value.any() or metal.value.any():
        reading.note_once(_GLOSS_NOTES[reading.glossy])
        base = _reflectance(source.input("Base Color"), reading, "the base colour")
        specular = _specular(source, base, number("IOR"), number("Specular IOR Level"), reading)
        if normal is not None and specular.value.any():
            reading.note("how diffuse it is depends on the view, most of all under a normal map; the mean is taken")
        through = product(dull, complement(specular), reading, "what is neither metal nor glass")
        albedo = product(base, through, reading, "the base colour")
        metallic = product(base, metal, reading, "the base colour")
        mirrored = product(dull, specular, reading, "what is neither metal nor glass")
        gloss_albedo = total([metallic, mirrored], reading, "what it reflects")
    emission = BLACK
    if source.input("Emission Strength").node or number("Emission Strength") > 0:
        emission = _emission(source, "Emission Color", "Emission Strength", reading)
    gloss = principled_gloss(source, reading) if reading.glossy else MATTE
    alpha = read_factor(source.input("Alpha"), reading, "its alpha")
    return Surface(albedo, emission, alpha, gloss, gloss_albedo, normal)


def _specular(source: Feed, base: ColorSource, ior: float, level: float, reading: Reading) -> ColorSource:
    """The `specular_share` of a Principled BSDF, everywhere."""
    if specular_ior(ior, level) == 1:
        return BLACK
    reading.note_once(_VIEW_NOTE)
    roughness = read_factor(source.input("Roughness"), reading, "its roughness")
    if not are_alike([base, roughness]):  # it matters too little to bring a base colour to where it lies
        reading.note("its roughness, an image of its own, is taken as its mean for what the base colour is dimmed by")
        roughness = constant(mean(roughness))
    return applied(lambda values: specular_share(ior, level, values), roughness)


def _emission(source: Feed, color: str, strength: str, reading: Reading) -> ColorSource:
    amount = read_factor(source.input(strength), reading, "emission strength", np.inf)
    emitted = product(read_color(source.input(color), reading, "the emitted colour"), amount, reading, "its emission")
    dark = _lowest(emitted) < 0
    if dark or estimate(source.input(strength), reading)[0].min() < 0:
        reading.note("emission below nothing is taken as none")
    return applied(lambda values: np.maximum(values, 0), emitted) if dark else emitted


def _in_use(source: Feed, name: str) -> bool:
    value = source.input(name)
    return value.node is not None or set_value(value.socket)[0] > 0


def _note_roughness(source: Feed, roughness: str, reading: Reading) -> None:
    """Notes what makes a diffuse surface reflect otherwise than Lambert's law says."""
    if _in_use(source, roughness):
        reading.note("the roughness of its diffuse part is left out")


def principled_notes(glossy: bool) -> tuple[str, ...]:
    """What is approximated of every Principled BSDF that reflects."""
    return _GLOSS_NOTES[glossy], _VIEW_NOTE


def specular_share(ior: float = 1.5, level: float = 0.5, roughness: float | np.ndarray = 0.5) -> float | np.ndarray:
    """Share of the light that the specular layer of a Principled BSDF takes from the diffuse one below.

    In Cycles it depends on the view. This is its mean over a cosine-weighted hemisphere, where light that bounces goes:
    a smooth dielectric's, less what Cycles' rough one loses, the latter fitted to Cycles' Diffuse Color pass, which is
    met within 0.015 for IOR 1.1 to 2.
    """
    ior = specular_ior(ior, level)
    return fresnel_mean(ior) / (1 + 4.4 / ior * roughness**2.6)


def _mix(source: Feed, reading: Reading) -> Surface:
    """A Mix Shader."""
    share = read_factor(source.input(0), reading, "the share of a Mix Shader")
    if share.texture is None and share.value[0] in (0, 1):
        return read_surface(source.input(2 if share.value[0] else 1), reading)
    one, other = (read_surface(source.input(index), reading) for index in (1, 2))
    if one.is_clear:
        return replace(other, alpha=product(other.alpha, share, reading, "its alpha"))
    if other.is_clear:
        return replace(one, alpha=product(one.alpha, complement(share), reading, "its alpha"))
    return _sum([(complement(share), one), (share, other)], reading)


def _sum(parts: list[tuple[ColorSource, Surface]], reading: Reading) -> Surface:
    """Shaders added up, each by its weight, grey."""

    def summed(name, what):
        colors = [product(getattr(surface, name), weight, reading, what) for weight, surface in parts]
        return total(colors, reading, what)

    through = [product(complement(surface.alpha), weight, reading, "its alpha") for weight, surface in parts]
    alpha = complement(total(through, reading, "its alpha"))
    if not mean(alpha)[0] > 1e-3 and any(mean(w)[0] * mean(surface.alpha)[0] for w, surface in parts):
        reading.note("it lets all light through and shines as well; it is taken as not transparent")
        alpha = WHITE
    # Of the solid part: what each shader gives, over how solid they are together.
    parts = [(product(weight, surface.alpha, reading, "its alpha"), surface) for weight, surface in parts]
    if alpha.texture or alpha.value[0] != 1:
        parts = [(quotient(weight, alpha, reading, "its alpha"), surface) for weight, surface in parts]
    if reading.glossy and any(weight.texture and not surface.gloss.is_none for weight, surface in parts):
        reading.note("how much of it is glossy, an image, is taken as its mean in what it reflects")
    return Surface(
        albedo=summed("albedo", "the colour"),
        emission=summed("emission", "the emitted colour"),
        alpha=alpha,
        gloss=gloss_sum([(float(mean(weight)[0]), surface.gloss) for weight, surface in parts], reading),
        gloss_albedo=summed("gloss_albedo", "what it reflects"),
        normal=_strongest_normal(parts, reading),
    )


def _strongest_normal(parts: list[tuple[ColorSource, Surface]], reading: Reading) -> ColorSource | None:
    """The normal of several shaders together, each with its weight: that of what reflects most."""
    strength = [
        float(mean(weight).mean() * (mean(surface.albedo) + mean(surface.gloss_albedo)).mean())
        for weight, surface in parts
    ]
    normals = [surface.normal for (_, surface), amount in zip(parts, strength) if amount > 0]
    if not normals:
        return None
    if any(normal is not normals[0] for normal in normals):
        reading.note("its shaders have different normals; that of the one that reflects most is taken")
    return parts[int(np.argmax(strength))][1].normal
