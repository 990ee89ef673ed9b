# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluated scene as a render sees it.

Scripts are only given depsgraphs in viewport mode: the viewport's subdivision levels and modifiers, what the eye icon
hides left out. Only a render engine is handed one in render mode, so the scene is read inside the `render` call of an
engine that draws nothing. That costs milliseconds, evaluates every setting exactly as F12 would (levels, visibility,
simplify, "Is Viewport" nodes, drivers, handlers), works with and without a window, and needs no change to any object.
What it does touch is put back: the scene's engine, camera and post-processing, which layers render, the render slot.
"""

import contextlib
from collections.abc import Callable, Iterator
from typing import TypeVar

import bpy

T = TypeVar("T")


def with_render_depsgraph(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, function: Callable[[bpy.types.Depsgraph], T]
) -> T:
    """`function(depsgraph)` on `view_layer` at the scene's current frame, evaluated in render mode.

    The depsgraph and everything in it are gone afterwards: `function` must return copies. Raises what `function`
    raises, and RuntimeError where Blender cannot render now.
    """
    outcome = []

    class ReadEngine(bpy.types.RenderEngine):
        bl_idname = "GI_BAKE_READ"
        bl_label = "GI Bake Scene Reader"
        bl_use_custom_freestyle = True

        def render(self, depsgraph):
            if outcome:  # the second eye of a stereo render
                return
            try:
                outcome.append((function(depsgraph), None))
            except BaseException as error:  # an engine's exceptions end in the console, not with the caller
                outcome.append((None, error))

    bpy.utils.register_class(ReadEngine)
    try:
        with (
            _render_settings(scene, view_layer, ReadEngine.bl_idname),
            own_render_slot(),
            # Given by name the scene would be set to the frame of the one on the screen.
            bpy.context.temp_override(scene=scene, view_layer=view_layer),
        ):
            bpy.ops.render.render()
    finally:
        bpy.utils.unregister_class(ReadEngine)
    if not outcome:
        raise RuntimeError(f"Scene '{scene.name}' cannot be evaluated now: wait until the running render has ended")
    result, error = outcome[0]
    if error:
        raise error
    return result


@contextlib.contextmanager
def _render_settings(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, engine: str) -> Iterator[None]:
    """The scene's settings for one render that calls `engine` for `view_layer` and nothing else."""
    changes = {"engine": engine, "use_compositing": False, "use_sequencer": False}
    before = {name: getattr(scene.render, name) for name in changes}
    used = [layer.use for layer in scene.view_layers]
    camera = scene.camera
    stand_in = None
    try:
        if camera is None:  # Blender refuses to render without one, a lightmap needs none
            stand_in = bpy.data.cameras.new("GI Bake")
            scene.camera = bpy.data.objects.new("GI Bake", stand_in)
        for name, value in changes.items():
            setattr(scene.render, name, value)
        for layer in scene.view_layers:
            layer.use = layer == view_layer
        yield
    finally:
        for name, value in before.items():
            setattr(scene.render, name, value)
        for layer, use in zip(scene.view_layers, used):
            layer.use = use
        scene.camera = camera
        if stand_in:
            bpy.data.cameras.remove(stand_in)


@contextlib.contextmanager
def own_render_slot() -> Iterator[None]:
    """Lets the empty picture go to the last slot of the Render Result, so that what the user looks at stays."""
    image = _render_result()
    if image is None:
        try:
            yield
        finally:
            if image := _render_result():
                bpy.data.images.remove(image)
        return
    slots = image.render_slots
    before = slots.active_index
    # Blender makes eight slots. Which of them are empty cannot be asked for, and one that was added stays for good.
    slots.active_index = len(slots) - 1 if before != len(slots) - 1 else 0
    try:
        yield
    finally:
        slots.active_index = before


def _render_result() -> bpy.types.Image | None:
    return next((image for image in bpy.data.images if image.type == "RENDER_RESULT"), None)
