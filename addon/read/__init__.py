# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From Blender to `gi_core.Scene`: one file per type of data, and the evaluated scene that they read from."""

from collections.abc import Callable

import bpy

from ...gi_core.scene import Scene, Texture
from .camera import read_camera
from .images import ImageReader
from .lights import read_lights
from .materials import MaterialReader
from .objects import read_objects
from .panorama import panorama
from .render_depsgraph import with_render_depsgraph
from .world import read_environment, wants_panorama


def read_scene(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    images: ImageReader | None = None,
    look: Callable[[Scene, bpy.types.Depsgraph], None] | None = None,
    with_panorama: bool = True,
    glossy: bool = False,
) -> Scene:
    """`view_layer` of `scene`, as a render at the current frame sees it, as a `Scene`.

    images: reads textures, where it is not the usual reader. look: is shown the result beside the evaluated scene that
    it was read from. with_panorama: a world of nodes is rendered; otherwise its mean colour is taken. glossy: what
    surfaces reflect besides their diffuse part is read too.

    Raises ValueError where an image of a material or of the world cannot be read, and RuntimeError where Blender
    cannot render now. Call it where Blender's data may be changed: not inside a render, not while drawing.
    """
    camera, images, around = scene.camera, images or ImageReader(), None
    world = view_layer.world_override or scene.world
    if with_panorama and wants_panorama(world, images):
        around = panorama(world, scene.frame_current_final)

    def read(depsgraph: bpy.types.Depsgraph) -> Scene:
        core = read_depsgraph(depsgraph, camera, images, around, glossy)
        if look:
            look(core, depsgraph)
        return core

    return with_render_depsgraph(scene, view_layer, read)


def read_depsgraph(
    depsgraph: bpy.types.Depsgraph,
    camera: bpy.types.Object | None,
    images: ImageReader,
    panorama: Texture | None = None,
    glossy: bool = False,
) -> Scene:
    """What is in `depsgraph`, seen by `camera`, as a `Scene`.

    images: gives the textures. panorama: of the world, where it was rendered. glossy: see `read_scene`.
    """
    notes = []
    materials = MaterialReader(depsgraph.view_layer_eval.material_override, images, notes, glossy)
    meshes, instances = read_objects(depsgraph, materials.index, notes)
    if camera:
        camera = read_camera(camera.evaluated_get(depsgraph), depsgraph.scene_eval.render, notes)
    return Scene(
        meshes=tuple(meshes),
        instances=tuple(instances),
        materials=tuple(materials.read),
        lights=tuple(read_lights(depsgraph, images, notes)),
        environment=read_environment(depsgraph, images, notes, panorama),
        camera=camera,
        approximated=tuple(notes),
    )
