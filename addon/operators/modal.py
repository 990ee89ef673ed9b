# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work of an operator: to its end in scripts, in steps beside a living window."""

import time
from collections.abc import Callable, Iterator

import bpy

from .. import preview
from ..bake import Refused
from ..preflight import Finding
from ..read.render_depsgraph import is_going, is_read
from ..redraw import redraw
from ..run import Run
from ..session import session
from .findings import failure, report
from .poll import busy

# Seconds between two looks at the work, and how long each may take.
_TICK, _STEP = 0.05, 0.04

# Seconds between two pictures of the result so far.
_PICTURE = 0.3


class Modal:
    """An operator with work: `_begin` gives it, `_end` puts its value into the file, which is as it was until then."""

    # Stages after which the work still knows parts of the file.
    holding = frozenset()

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def _begin(self, context, seen: preview.Preview | None) -> Iterator[tuple[float, str]]:
        """The work, a generator of (fraction, stage); `seen` is shown what there is so far."""
        raise NotImplementedError

    def _on_main(self) -> Callable[[str], bool]:
        """Whether the step after a stage belongs on the main thread."""
        raise NotImplementedError

    def _end(self, context, value) -> set[str]:
        raise NotImplementedError

    def execute(self, context):
        self._scene = context.scene.name
        try:
            work = self._begin(context, None)
            manager = context.window_manager
            manager.progress_begin(0, 1)
            try:
                while True:
                    fraction, _ = next(work)
                    manager.progress_update(fraction)
            except StopIteration as stop:
                value = stop.value
            finally:
                manager.progress_end()
            return self._end(context, value)
        except Exception as error:
            return self._fail(context.scene, error)

    def invoke(self, context, event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        return self._start(context)

    def _start(self, context):
        """Begins work that `modal` follows."""
        self._scene, self._layer = context.scene.name, context.view_layer.name
        self._preview, self._timer, self._pictured = preview.Preview(), None, 0.0
        try:
            work = self._begin(context, self._preview)
        except Exception as error:
            return self._fail(context.scene, error)
        self._run = session.run = Run(work, self._on_main(), self.holding)
        # One that was cancelled may have left it.
        self._run.wait(lambda: not is_going())
        session.of = self._scene
        self._timer = context.window_manager.event_timer_add(_TICK, window=context.window)
        context.window_manager.modal_handler_add(self)
        return {"RUNNING_MODAL"}

    def modal(self, context, event):
        try:
            return self._followed(context, event)
        except Exception as error:
            # Blender would drop the operator as it is, and its timer, thread and preview would stay.
            self._clean(context)
            return self._fail(context.scene, error)

    def _followed(self, context, event):
        """Goes on with the work at each tick of the timer, ends it at Esc."""
        run = self._run
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            # What is deleted while Blender's render job goes through the file would end Blender.
            waits = is_read() and event.value != "NOTHING" and not _on_panels(context, event)
            return {"RUNNING_MODAL"} if waits else {"PASS_THROUGH"}
        if run.holds_file and not self._there():
            raise Refused([Finding("SCENE_GONE", "ERROR", "", "The scene or its view layer was removed.", "")])
        ended = run.advance(_STEP)
        if not ended and time.perf_counter() - self._pictured > _PICTURE:
            self._preview.refresh()
            self._pictured = time.perf_counter()
        redraw(context)
        if not ended:
            return {"PASS_THROUGH"}
        return self._ended(context)

    def _there(self) -> bool:
        """Whether the scene and the view layer are, that the work began with."""
        scene = bpy.data.scenes.get(self._scene)
        return scene is not None and self._layer in scene.view_layers

    def cancel(self, context):
        """Blender quits, or its window closes."""
        self._clean(context)

    def _ended(self, context):
        run = self._run
        self._clean(context)
        # It may have been undone, renamed or removed meanwhile.
        scene = bpy.data.scenes.get(self._scene) or context.scene
        if run.cancelled:
            self.report({"INFO"}, "Cancelled, nothing was changed")
            return {"CANCELLED"}
        if run.error:
            return self._fail(scene, run.error)
        try:
            return self._end(context, run.value)
        except Exception as error:
            return self._fail(scene, error)

    def _fail(self, scene, error):
        findings = failure(error)
        session.found(scene, findings)
        report(self, findings)
        return {"CANCELLED"}

    def _clean(self, context):
        """Leaves no timer, no thread and no preview behind."""
        self._run.close()
        if session.run is self._run:
            session.run = None
        if self._timer:
            context.window_manager.event_timer_remove(self._timer)
            self._timer = None
        self._preview.remove()
        redraw(context)


def _on_panels(context, event) -> bool:
    """Whether it is a click on panels, as on Cancel: they delete no object."""
    return event.type == "LEFTMOUSE" and any(
        0 <= event.mouse_x - region.x < region.width and 0 <= event.mouse_y - region.y < region.height
        for area in context.window.screen.areas
        for region in area.regions
        if area.type == "PROPERTIES" or region.type == "UI"
    )
