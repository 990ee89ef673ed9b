# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender to `gi_core.Scene`: one file per type of data, and the evaluated scene that they read from."""

import contextlib
from collections.abc import Callable, Iterator
from dataclasses import replace

import bpy

from ...gi_core.scene import Scene, Texture
from ...gi_core.tiles import whole
from .camera import read_camera
from .images import ImageReader
from .lights import read_lights
from .materials import MaterialReader
from .objects import read_objects
from .panorama import panorama
from .render_depsgraph import reading
from .surface_bakes import SurfaceBakes
from .world import read_environment, wants_panorama


def reading_scene(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    images: ImageReader | None = None,
    look: Callable[[Scene, bpy.types.Depsgraph], None] | None = None,
    with_panorama: bool = True,
    glossy: bool = False,
    bakes: SurfaceBakes | None = None,
    lent: contextlib.AbstractContextManager | None = None,
) -> Iterator[float]:
    """`view_layer` of `scene`, as a render at the current frame sees it, as a `Scene`. A generator of progress.

    images: reads textures, where it is not the usual reader. look: is shown the result beside the evaluated scene that
    it was read from. with_panorama: a world of nodes is rendered; otherwise its mean colour is taken. glossy: what
    surfaces reflect besides their diffuse part is read too. bakes: collects what of the materials only Cycles can tell:
    `with_bakes` then gives the scene that has it. Without it, that is taken at its best constant. lent: what the file
    has while it is evaluated.

    Raises ValueError where an image of a material or of the world cannot be read, and RuntimeError where Blender
    cannot render now. Call it where Blender's data may be changed: not inside a render, not while drawing.
    """
    camera, images, around = scene.camera, images or ImageReader(), None
    world = view_layer.world_override or scene.world
    if with_panorama and wants_panorama(world, images):
        around = panorama(world, scene.frame_current_final)

    def read(depsgraph: bpy.types.Depsgraph) -> Scene:
        core = read_depsgraph(depsgraph, camera, images, around, glossy, bakes)
        if look:
            look(core, depsgraph)
        return core

    return (yield from reading(scene, view_layer, read, lent))


read_scene = whole(reading_scene)


def read_depsgraph(
    depsgraph: bpy.types.Depsgraph,
    camera: bpy.types.Object | None,
    images: ImageReader,
    panorama: Texture | None = None,
    glossy: bool = False,
    bakes: SurfaceBakes | None = None,
) -> Scene:
    """What is in `depsgraph`, seen by `camera`, as a `Scene`.

    images: gives the textures. panorama: of the world, where it was rendered. glossy, bakes: see `read_scene`.
    """
    notes = []
    materials = MaterialReader(depsgraph, images, glossy, bakes)
    meshes, instances = read_objects(depsgraph, materials.indices, notes)
    if camera:
        camera = read_camera(camera.evaluated_get(depsgraph), depsgraph.scene_eval.render, notes)
    scene = Scene(
        meshes=tuple(meshes),
        instances=tuple(instances),
        materials=tuple(materials.read),
        lights=tuple(read_lights(depsgraph, images, notes)),
        environment=read_environment(depsgraph, images, notes, panorama),
        camera=camera,
    )
    if bakes:
        bakes.materials, bakes.notes = materials, notes
    return replace(scene, approximated=tuple(dict.fromkeys(materials.notes + notes)))


def with_bakes(
    core: Scene, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, bakes: SurfaceBakes
) -> Iterator[float]:
    """The scene that was read with `bakes`, with the textures that these ask for. A generator of progress.

    Raises what `read_scene` raises. The file is as it was afterwards.
    """
    if not bakes.patches:
        return core
    uvs = yield from bakes.bake(scene)
    materials, notes = yield from reading(scene, view_layer, bakes.materials.read_again)
    return replace(
        core,
        meshes=bakes.with_uvs(core.meshes, uvs),
        materials=tuple(materials),
        approximated=tuple(dict.fromkeys(notes + bakes.notes)),
    )
