# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials: the diffuse, emitting and glossy parts of a Blender material, and how solid it is."""

from dataclasses import replace

import bpy
import numpy as np

from ...gi_core.scene import MATTE, WHITE, Gloss, Material, Mesh
from ..sentence import Sentence
from .expression import Expression
from .images import ImageReader
from .nodes import Mismatch, Reading, node_tree, output_feed
from .sources import constant
from .surface_bakes import Patch, SurfaceBakes
from .surfaces import Surface, principled_notes, read_surface, specular_share
from .turns import in_turns


def _default(glossy: bool) -> Material:
    """What Cycles gives to faces without a material: a Principled BSDF from 5.0 on, a Diffuse BSDF before."""
    if bpy.app.version < (5, 0, 0):
        return Material("", constant(0.8))
    gloss = Gloss(roughness=constant(0.5), dielectric=WHITE) if glossy else MATTE
    share = specular_share()
    return Material("", constant(0.8 * (1 - share)), gloss=gloss, gloss_albedo=constant(share))


def _default_notes(glossy: bool) -> tuple[str, ...]:
    return () if bpy.app.version < (5, 0, 0) else principled_notes(glossy)


class MaterialReader:
    """Collects the materials that objects ask for, each read once.

    read: the list of `Material`, in the order in which they were asked for. notes: what was approximated.
    bakes: is asked for what only Cycles can tell, where it is not None; a material then is several, one for each mesh.
    """

    def __init__(
        self,
        depsgraph: bpy.types.Depsgraph,
        images: ImageReader,
        glossy: bool = False,
        bakes: SurfaceBakes | None = None,
    ):
        self.read: list[Material] = []
        self.notes: list[str] = []
        self._override = depsgraph.view_layer_eval.material_override
        self._frame = depsgraph.scene_eval.frame_current_final
        self._images, self._glossy, self._bakes = images, glossy, bakes
        self._known: dict[int | None, tuple[Material, tuple[Expression, ...], bool]] = {}
        self._indices: dict[object, int] = {}
        # Of each of `read`: the material in the file, where it is baked, and whether as a whole.
        self._sources: list[tuple[bpy.types.Material | None, Patch | None, bool]] = []

    def indices(self, entry: bpy.types.DepsgraphObjectInstance, index: int, mesh: Mesh) -> tuple[int, ...]:
        """Indices into `read` for the slots of an instance of the mesh that is the scene's at `index`."""
        slots = [self._override or slot.material for slot in entry.object.material_slots] or [self._override]
        # A polygon beyond the slots takes the last one.
        slots += slots[-1:] * (int(mesh.slots.max()) + 1 - len(slots))
        return tuple(self._index(material, slots, entry, index, mesh) for material in slots)

    def _index(self, material, slots, entry, index: int, mesh: Mesh) -> int:
        key = material and material.original.as_pointer()
        if key not in self._known:
            self._known[key] = self._first_reading(material)
        made, expressions, whole = self._known[key]
        patch = None
        if expressions:
            alike = tuple(k for k, other in enumerate(slots) if other == material)
            patch = self._bakes.want(material, expressions, entry, index, mesh, alike)
        place = key if patch is None else id(patch)
        if place not in self._indices:
            self._indices[place] = len(self.read)
            self.read.append(made)
            self._sources.append((material and material.original, patch, whole))
        return self._indices[place]

    def _first_reading(self, material: bpy.types.Material | None) -> tuple[Material, tuple[Expression, ...], bool]:
        """A material with stand-ins for what is to be baked, what that is, and whether it is all that varies."""
        if material is None:
            self.notes += [note for note in _default_notes(self._glossy) if note not in self.notes]
            return _default(self._glossy), (), False
        for whole in (False, True):
            reading = self._reading(material, None if self._bakes is None else {}, None, whole)
            try:
                made = read_material(material, reading)
            except Mismatch:
                continue
            break
        self.notes += [note for note in reading.notes if note not in self.notes]
        return made, tuple(found for found in (reading.wanted or {}).values() if found), whole

    def read_again(self, depsgraph: bpy.types.Depsgraph) -> tuple[list[Material], list[str]]:
        """The same materials with what was baked, evaluated anew, and what is approximated now."""
        made, notes = [], []
        for (material, patch, whole), before in in_turns(zip(self._sources, self.read)):
            if material is None:
                made.append(before)
                notes += [note for note in _default_notes(self._glossy) if note not in notes]
                continue
            wanted = {e.wanted_as: e for e in patch.expressions} if patch else {}
            textures = patch.textures if patch else {}
            reading = self._reading(material, wanted, textures, whole and bool(textures))
            for note in patch.notes if patch else ():
                reading.note(note)
            made.append(read_material(material.evaluated_get(depsgraph), reading))
            notes += [note for note in reading.notes if note not in notes]
        return made, notes

    def _reading(self, material, wanted, baked, whole: bool) -> Reading:
        return Reading(
            Sentence("Material '{name}'", name=material.name), self._images, [], glossy=self._glossy, wanted=wanted,
            baked=baked, whole=whole, frame=self._frame,
        )  # fmt: skip


def read_material(material: bpy.types.Material, reading: Reading) -> Material:
    """An evaluated `material` as a `Material`. Raises ValueError where one of its images cannot be read."""
    tree = node_tree(material)
    if not tree:
        return Material(material.name, constant(material.diffuse_color[:3]))
    displacement = output_feed(tree, "OUTPUT_MATERIAL", "Displacement")
    moved = displacement and material.displacement_method != "BUMP"
    for name, there in (("volume", output_feed(tree, "OUTPUT_MATERIAL", "Volume")), ("displacement", moved)):
        if there:
            reading.note(Sentence("its {what} is left out", what=Sentence(name)))
    if material.displacement_method != "DISPLACEMENT":
        reading = replace(reading, displacement=displacement)
    source = output_feed(tree, "OUTPUT_MATERIAL", "Surface")
    surface = read_surface(source, reading) if source else Surface()
    albedo = surface.albedo
    if np.any(albedo.value > 1) and albedo.texture is None:
        reading.note("a colour above 1 is taken as 1, since no surface reflects more light than it gets")
        albedo = constant(np.minimum(albedo.value, 1.0))
    return Material(
        material.name, albedo, surface.emission, surface.alpha, surface.gloss, surface.gloss_albedo, surface.normal
    )  # fmt: skip
