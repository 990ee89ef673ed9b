# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects: each mesh once, and an instance for each place where it stands."""

from collections.abc import Callable, Iterator

import bpy
import numpy as np

from ...gi_core.scene import Instance, Mesh
from ..object_options import object_options
from ..sentence import Sentence
from .meshes import read_mesh
from .turns import in_turns

# Types of object that render, but not as surfaces.
_NO_SURFACES = {"CURVES", "GREASEPENCIL", "POINTCLOUD", "VOLUME"}

# The second number of an instance's persistent id where no instancing took place.
_NOT_NESTED = 0x7FFFFFFF

# Modifiers that make the same of the same mesh wherever its object stands.
_LOCAL = {"EDGE_SPLIT", "SOLIDIFY", "SUBSURF", "TRIANGULATE", "WEIGHTED_NORMAL", "WELD"}


def read_objects(
    depsgraph: bpy.types.Depsgraph,
    material_indices: Callable[[bpy.types.DepsgraphObjectInstance, int, Mesh], tuple[int, ...]],
    notes: list[str],
) -> tuple[list[Mesh], list[Instance]]:
    """The meshes of `depsgraph` and their places.

    Curves, texts, surfaces and metaballs come as the meshes they render as. `material_indices` gives
    the places in `Scene.materials` of the slots of an instance of a mesh, by its index too. What the bake does not have
    is told in `notes`.
    """
    meshes, instances, noted = [], [], set()
    known = {}  # what a mesh is made of -> index into meshes, None without triangles
    for entry in in_turns(depsgraph.object_instances):
        source = entry.object
        if source.name not in noted:
            noted.add(source.name)
            notes += _left_out(source)
        # Other types of object come a second time, as instances of themselves that are meshes.
        if source.type != "MESH" or not entry.show_self:
            continue
        key = _made_of(source)
        if key not in known:
            mesh = read_mesh(source.to_mesh(), source.data.name)
            source.to_mesh_clear()
            known[key] = None
            if len(mesh.triangles):
                known[key] = len(meshes)
                meshes.append(mesh)
        options = object_options(source.original)
        if known[key] is None or not (options.use or options.casts):
            continue
        index = known[key]
        instances.append(
            Instance(
                name=source.name,
                mesh=index,
                matrix=np.array(entry.matrix_world, np.float64),
                materials=material_indices(entry, index, meshes[index]),
                receives=options.use,
                casts=options.casts,
                is_copy=source.is_from_set or (entry.is_instance and not _is_own_surface(entry)),
            )
        )
    return meshes, instances


def _made_of(source: bpy.types.Object) -> tuple:
    """What the mesh of an evaluated object follows from, alike where the meshes are: Blender subdivides the mesh of a
    hundred linked duplicates a hundred times, when each is asked for its own."""
    mesh, used = source.original.data, [modifier for modifier in source.modifiers if modifier.show_render]
    alike = used and source.original.type == "MESH" and all(modifier.type in _LOCAL for modifier in used)
    if not alike or mesh.shape_keys or mesh.is_editmode or source.parent_type in {"ARMATURE", "LATTICE"}:
        return (source.data.as_pointer(),)
    return mesh.as_pointer(), *(setting for modifier in used for setting in _settings(modifier))


def _settings(modifier: bpy.types.Modifier) -> Iterator:
    """All that is set of a modifier but its name."""
    for prop in modifier.bl_rna.properties:
        if prop.identifier in {"name", "is_active"} or (prop.is_readonly and prop.identifier != "type"):
            continue
        yield getattr(modifier, prop.identifier)


def _left_out(source: bpy.types.Object) -> Iterator[str]:
    """Sentences on what Cycles would make of an evaluated object and the bake does not."""
    if source.type in _NO_SURFACES:
        yield Sentence("Object '{name}': objects of type {kind} are left out.", name=source.name, kind=source.type)
    particles = [system.settings for system in source.particle_systems]
    if any(settings.type == "HAIR" and settings.render_type == "PATH" for settings in particles):
        yield Sentence("Object '{name}': its hair is left out.", name=source.name)
    if source.type != "MESH":
        return
    flags = ("visible_camera", "visible_diffuse", "visible_shadow")
    if not all(getattr(source, flag) for flag in flags) or source.is_holdout or source.is_shadow_catcher:
        yield Sentence("Object '{name}': its ray visibility is left out: everything sees it.", name=source.name)


def _is_own_surface(entry: bpy.types.DepsgraphObjectInstance) -> bool:
    """Whether an instance is the surface of a curve, text, surface or metaball object where it stands itself."""
    source = entry.object.original
    return source.type != "MESH" and entry.parent.original == source and entry.persistent_id[1] == _NOT_NESTED
