# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The evaluated scene as a render sees it.

Scripts are only given depsgraphs in viewport mode: the viewport's subdivision levels and modifiers, what the eye icon
hides left out. Only a render engine is handed one in render mode, so the scene is read inside the `render` call of an
engine that draws nothing. That costs milliseconds, evaluates every setting exactly as F12 would (levels, visibility,
simplify, "Is Viewport" nodes, drivers, handlers), works with and without a window, and needs no change to any object.
What it does touch is put back: the scene's engine, camera and post-processing, which layers render, the render slot.

Beside a living window the engine is called by Blender's render job, on a thread of the job's. The window waits while
Blender copies and evaluates what it needs, so that nothing changes under it and the settings are put back before the
window has its turn; it goes on while the evaluated scene is read.
"""

import contextlib
import threading
from collections.abc import Callable, Iterator
from typing import TypeVar

import bpy

from .. import run
from .turns import Stopped, taken

T = TypeVar("T")

# Seconds between two looks whether the job has ended.
_LOOK = 0.05


def reading(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    function: Callable[[bpy.types.Depsgraph], T],
    lent: contextlib.AbstractContextManager | None = None,
) -> Iterator[float]:
    """`function(depsgraph)` on `view_layer` at the scene's current frame, evaluated in render mode. A generator of
    progress; between its steps the file is as it was. Beside a living window `function` is called on another thread.

    lent: what the file has while it is evaluated.
    The depsgraph and everything in it are gone afterwards: `function` must return copies. Raises what `function`
    raises, and RuntimeError where Blender cannot render now.
    """
    beside, lent, reader = run.current.get(), lent or contextlib.nullcontext(), _Reader(function)
    if is_going() or (beside and bpy.app.is_job_running("RENDER")):
        return reader.value(scene)
    if beside is None:
        with _registered(reader), lent, _set_up(scene, view_layer, reader), own_render_slot():
            bpy.ops.render.render()
        return reader.value(scene)
    job = _Job(reader)
    try:
        with lent:
            job.start(scene, view_layer)
        beside.wait(lambda: job.ended)
        yield 0.0
    finally:
        job.leave()
    # What comes next may render too.
    beside.wait(lambda: not is_going())
    yield 0.0
    try:
        return reader.value(scene)
    except Stopped:
        # Esc goes to the job as long as there is one.
        beside.cancel()
        yield 0.0


def is_read() -> bool:
    """Whether a scene is read on another thread right now."""
    return is_going() and not _Job.latest.ended


def is_going() -> bool:
    """Whether Blender is not quite done with the job that read, or reads, a scene."""
    return _Job.latest is not None


class _Reader:
    """An engine that calls a function once, and what came of it. left: nobody waits for it any longer."""

    def __init__(self, function: Callable[[bpy.types.Depsgraph], object]):
        self.called = self.left = False
        self.answered = threading.Event()
        self.outcome: tuple[object, BaseException | None] | None = None
        reader = self

        class ReadEngine(bpy.types.RenderEngine):
            bl_idname = "GI_BAKE_READ"
            bl_label = "GI Bake Scene Reader"
            bl_use_custom_freestyle = True

            def render(self, depsgraph):
                if reader.called:  # the second eye of a stereo render
                    return
                reader.called = True
                reader.answered.set()
                try:
                    reader.outcome = reader.read(self, depsgraph, function), None
                except BaseException as error:  # an engine's exceptions end in the console, not with the caller
                    reader.outcome = None, error

        self.engine = ReadEngine

    def read(self, engine: bpy.types.RenderEngine, depsgraph: bpy.types.Depsgraph, function: Callable) -> object:
        if threading.current_thread() is threading.main_thread():
            return function(depsgraph)
        with taken(lambda: self.left or engine.test_break()):
            return function(depsgraph)

    def value(self, scene: bpy.types.Scene) -> object:
        if self.outcome is None:
            raise RuntimeError(f"Scene '{scene.name}' cannot be evaluated now: wait until the running render has ended")
        value, error = self.outcome
        if error:
            raise error
        return value


class _Job:
    """Blender's render job that calls a reader. latest: the one that is not quite over."""

    latest: "_Job | None" = None

    def __init__(self, reader: _Reader):
        self.reader, self._made = reader, None

    def start(self, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
        """Returns when the reader is called, or never will be."""
        _Job.latest = self
        bpy.utils.register_class(self.reader.engine)
        first = _render_result() is None
        slot = contextlib.nullcontext() if first else own_render_slot()
        with _set_up(scene, view_layer, self.reader), slot, _no_window(), self._heard():
            if _invoked() != {"CANCELLED"}:
                self.reader.answered.wait()
        if first and (image := _render_result()):
            self._made = image.session_uid

    @property
    def ended(self) -> bool:
        """Whether something came of it, or nothing will."""
        return self.reader.outcome is not None or not self.reader.called

    def leave(self) -> None:
        """Takes the engine and the empty picture away when the job is over, which is soon."""
        self.reader.left = True
        if self._look() is not None:
            bpy.app.timers.register(self._look, first_interval=_LOOK, persistent=True)

    def _look(self) -> float | None:
        if bpy.app.is_job_running("RENDER"):
            return _LOOK
        bpy.utils.unregister_class(self.reader.engine)
        image = _render_result()
        if image and image.session_uid == self._made:
            bpy.data.images.remove(image)
        _Job.latest = None
        return None

    @contextlib.contextmanager
    def _heard(self) -> Iterator[None]:
        """Listens to the job's end, which comes without a call where Blender finds nothing to render."""

        def ends(*_):
            self.reader.answered.set()

        handlers = bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel
        for each in handlers:
            each.append(ends)
        try:
            yield
        finally:
            for each in handlers:
                each.remove(ends)


def _invoked() -> set[str]:
    """Starts the job; without a window there is none, and all is done when it returns."""
    return bpy.ops.render.render("INVOKE_DEFAULT")


@contextlib.contextmanager
def _registered(reader: _Reader) -> Iterator[_Reader]:
    bpy.utils.register_class(reader.engine)
    try:
        yield reader
    finally:
        bpy.utils.unregister_class(reader.engine)


@contextlib.contextmanager
def _set_up(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, reader: _Reader) -> Iterator[None]:
    """What makes a render one that calls the reader for `view_layer` and does nothing else."""
    with (
        _render_settings(scene, view_layer, reader.engine.bl_idname),
        # Given by name the scene would be set to the frame of the one on the screen.
        bpy.context.temp_override(scene=scene, view_layer=view_layer),
    ):
        yield


@contextlib.contextmanager
def _no_window() -> Iterator[None]:
    """Lets a render start without a window or an editor of its own. The user's preferences are as they were, also
    whether there is anything in them to be saved."""
    preferences = bpy.context.preferences
    display, dirty = preferences.view.render_display_type, preferences.is_dirty
    preferences.view.render_display_type = "NONE"
    try:
        yield
    finally:
        preferences.view.render_display_type = display
        preferences.is_dirty = dirty


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
