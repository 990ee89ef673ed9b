# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as a reference is rendered from it: a copy that lasts as long as the render.

The copy's collections and objects are the user's, its settings are its own, so none of them has to be put back.
"""

import contextlib

import bpy

# Path tracing without a bias: nothing clamped, blurred, filtered, guessed or left to the machine.
CYCLES = {
    "device": "CPU",
    "use_denoising": False,
    "use_adaptive_sampling": False,
    "time_limit": 0.0,
    "use_sample_subset": False,
    "sample_offset": 0,
    "use_layer_samples": "IGNORE",
    "use_animated_seed": False,
    "scrambling_distance": 1.0,
    "auto_scrambling_distance": False,
    "light_sampling_threshold": 0.0,
    "sample_clamp_direct": 0.0,
    "sample_clamp_indirect": 0.0,
    "blur_glossy": 0.0,
    "use_guiding": False,
    "use_fast_gi": False,
    "film_exposure": 1.0,
    "caustics_reflective": True,
    "caustics_refractive": True,
}
# All kinds alike, and max_bounces limits their sum. Fewer glossy ones would darken diffuse light too: of a surface with
# several lobes Cycles samples one and counts all, so ending glossy paths drops a share of the diffuse light (an eighth
# on the Principled default).
BOUNCES = ("max_bounces", "diffuse_bounces", "glossy_bounces", "transmission_bounces", "volume_bounces")
RENDER = {
    "engine": "CYCLES",
    "use_border": False,
    "use_compositing": False,
    "use_sequencer": False,
    "use_freestyle": False,
    "use_motion_blur": False,
    "use_multiview": False,
    "use_persistent_data": False,
    "use_stamp": False,
    "use_file_extension": True,
    "use_overwrite": True,
}


@contextlib.contextmanager
def reference_scene(scene, view_layer, samples, bounces, seed):
    """A copy of the scene, set up for a reference, and the copy of the view layer.

    Raises ValueError for a scene in the midst of a rigid body simulation, which a copy would start anew.
    """
    world = scene.rigidbody_world
    if world and world.enabled and scene.frame_current > world.point_cache.frame_start:
        raise ValueError(
            f"Scene '{scene.name}': Cycles cannot be compared with at a later frame of a rigid body simulation: "
            "bake it to keyframes (Object > Rigid Body > Bake to Keyframes)"
        )
    copy = scene.copy()
    # Cycles' results show up as an image; one that the user has holds a render of another scene and stays.
    had_result = any(image.type == "RENDER_RESULT" for image in bpy.data.images)
    try:
        # Neither animation nor drivers shall turn the settings below.
        copy.animation_data_clear()
        for name, value in RENDER.items():
            setattr(copy.render, name, value)
        for name, value in CYCLES.items():
            setattr(copy.cycles, name, value)
        copy.cycles.samples, copy.cycles.seed = samples, seed
        for name in BOUNCES:
            setattr(copy.cycles, name, bounces)
        for layer in copy.view_layers:
            layer.use = layer.name == view_layer.name
        yield copy, copy.view_layers[view_layer.name]
    finally:
        bpy.data.scenes.remove(copy)
        if not had_result:
            bpy.data.batch_remove([image for image in bpy.data.images if image.type == "RENDER_RESULT"])


@contextlib.contextmanager
def own_camera(scene):
    """A camera of the scene's own where the user's has depth of field."""
    if not scene.camera.data.dof.use_dof:
        yield
        return
    camera = scene.camera.copy()
    camera.data = camera.data.copy()
    try:
        camera.data.dof.use_dof = False
        scene.collection.objects.link(camera)
        scene.camera = camera
        # Markers with cameras would choose theirs again.
        scene.timeline_markers.clear()
        yield
    finally:
        bpy.data.batch_remove([camera, camera.data])
