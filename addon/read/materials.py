# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the diffuse, emitting and glossy parts of a Blender material, and how solid it is."""

import bpy
import numpy as np

from ...gi_core.scene import MATTE, WHITE, Gloss, Material
from .images import ImageReader
from .nodes import Reading, node_tree, output_feed
from .sources import constant
from .surfaces import Surface, read_surface, specular_share


def _default(glossy: bool) -> Material:
    """What Cycles gives to faces without a material: a Principled BSDF from 5.0 on, a Diffuse BSDF before."""
    if bpy.app.version < (5, 0, 0):
        return Material("", constant(0.8))
    gloss = Gloss(roughness=constant(0.5), dielectric=WHITE) if glossy else MATTE
    share = specular_share()
    return Material("", constant(0.8 * (1 - share)), gloss=gloss, gloss_albedo=constant(share))


class MaterialReader:
    """Collects the materials that objects ask for, each read once.

    read: the list of `Material`, in the order in which they were asked for.
    """

    def __init__(self, override: bpy.types.Material | None, images: ImageReader, notes: list[str], glossy: bool):
        self.read: list[Material] = []
        self._override, self._images, self._notes, self._glossy = override, images, notes, glossy
        self._indices = {}

    def index(self, material: bpy.types.Material | None) -> int:
        """Index into `read` of a `bpy.types.Material`, or of Cycles' default surface for None."""
        material = self._override or material
        key = material and material.original.as_pointer()
        if key not in self._indices:
            self._indices[key] = len(self.read)
            self.read.append(
                read_material(material, self._images, self._notes, self._glossy) if material else _default(self._glossy)
            )
        return self._indices[key]


def read_material(material: bpy.types.Material, images: ImageReader, notes: list[str], glossy: bool) -> Material:
    """`material` as a `Material`, with its gloss where `glossy`. Raises ValueError where one of its images cannot be
    read."""
    tree = node_tree(material)
    if not tree:
        return Material(material.name, constant(material.diffuse_color[:3]))
    reading = Reading(f"Material '{material.name}'", images, notes, glossy=glossy)
    source = output_feed(tree, "OUTPUT_MATERIAL", "Surface")
    surface = read_surface(source, reading) if source else Surface()
    for name in ("Volume", "Displacement"):
        if output_feed(tree, "OUTPUT_MATERIAL", name):
            reading.note(f"its {name.lower()} is left out")
    albedo = surface.albedo
    if np.any(albedo.value > 1) and albedo.texture is None:
        reading.note("a colour above 1 is taken as 1, since no surface reflects more light than it gets")
        albedo = constant(np.minimum(albedo.value, 1.0))
    return Material(material.name, albedo, surface.emission, surface.alpha, surface.gloss, surface.gloss_albedo)
