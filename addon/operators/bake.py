# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake, beside a living window or to its end."""

import time

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy.types import Operator

from ...gi_core.device import NUMPY
from .. import asked, baked, gpu_context, preferences, preflight, preview, timing
from ..bake import ON_MAIN_THREAD, Job, Refused, Result, bake
from ..properties import METHODS, TARGETS
from ..redraw import redraw
from ..run import Run
from ..session import session
from .findings import failure, report
from .names import names_of
from .poll import busy

# Seconds between two looks of a modal bake, and how long each may take.
_TICK, _STEP = 0.05, 0.04

# Seconds between two pictures of the result so far.
_PICTURE = 0.3


class GI_OT_bake(Operator):
    """Bake the light of the scene; the file changes only when all is done"""

    bl_idname = "gi.bake"
    bl_label = "Bake"
    # Not REGISTER, whose panel would bake anew at each touch.
    bl_options = {"UNDO"}

    method: EnumProperty(
        name="Technique", description="How reflected light is found; the scene's own where it is not given",
        items=METHODS, options={"SKIP_SAVE"},
    )  # fmt: skip
    target: EnumProperty(
        name="Target", description="What the light is baked for; the scene's own where it is not given",
        items=TARGETS, options={"SKIP_SAVE"},
    )  # fmt: skip
    objects: StringProperty(
        name="Objects", description="Names of the objects that get light, with commas between; empty takes the scene's "
        "choice", options={"SKIP_SAVE"},
    )  # fmt: skip
    resolution: IntProperty(
        name="Resolution", description="Side of lightmaps or longer side of the image; 0 takes the scene's",
        min=0, max=16384, subtype="PIXEL", options={"SKIP_SAVE"},
    )  # fmt: skip
    uv: StringProperty(
        name="UV Map", description="UV map that lightmaps lie on; empty takes the scene's choice", options={"SKIP_SAVE"}
    )
    folder: StringProperty(
        name="Output Folder", description="Folder for files; empty takes the scene's", subtype="DIR_PATH",
        options={"SKIP_SAVE"},
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def execute(self, context):
        try:
            work = self._begin(context, None)
            manager = context.window_manager
            manager.progress_begin(0, 1)
            try:
                while True:
                    fraction, _ = next(work)
                    manager.progress_update(fraction)
            except StopIteration as stop:
                result = stop.value
            finally:
                manager.progress_end()
            return self._end(context, result)
        except Exception as error:
            return self._fail(context.scene, error)

    def invoke(self, context, event):
        if bpy.app.background or context.window is None:
            return self.execute(context)
        return self._start(context)

    def _start(self, context):
        """Begins a bake that `modal` follows."""
        self._preview, self._timer, self._pictured = preview.Preview(), None, 0.0
        try:
            work = self._begin(context, self._preview)
        except Exception as error:
            return self._fail(context.scene, error)
        device, _ = gpu_context.device(self._job.settings.device)
        # A graphics card is to be reached from the main thread.
        always = device is not NUMPY
        self._run = session.run = Run(work, lambda stage: always or stage in ON_MAIN_THREAD)
        session.of = context.scene.name
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
        """Goes on with the bake at each tick of the timer, ends it at Esc."""
        run = self._run
        if event.type == "ESC" and event.value == "PRESS":
            run.cancel()
            return {"RUNNING_MODAL"}
        if event.type != "TIMER":
            return {"PASS_THROUGH"}
        ended = run.advance(_STEP)
        if not ended and time.perf_counter() - self._pictured > _PICTURE:
            self._preview.refresh()
            self._pictured = time.perf_counter()
        redraw(context)
        if not ended:
            return {"PASS_THROUGH"}
        return self._ended(context)

    def cancel(self, context):
        """Blender quits, or its window closes."""
        self._clean(context)

    def _begin(self, context, seen):
        scene, view_layer = context.scene, context.view_layer
        objects = names_of(self.objects)
        given = self.properties.is_property_set
        self._job: Job = asked.job(
            scene, view_layer,
            method=self.method.lower() if given("method") else "",
            target=self.target.lower() if given("target") else "",
            objects=objects, resolution=self.resolution, uv=self.uv, device=preferences.device(),
        )  # fmt: skip
        self._no_objects(scene, view_layer, objects)
        folder = self.folder or scene.gi_bake.folder
        wanted = bool(self.folder) or asked.needs_folder(scene, self._job.target)
        self._folder = asked.output(scene, folder) if wanted else None
        # A scene may be undone, renamed or gone when the bake ends.
        self._names, self._begun = (scene.name, view_layer.name), time.perf_counter()
        self._work = timing.work(scene, view_layer)
        return bake(scene, view_layer, self._job, folder if wanted else None, seen)

    def _no_objects(self, scene, view_layer, objects) -> None:
        none = not objects and not self._job.objects and scene.gi_bake.scope == "SELECTED"
        if none and self._job.target in {"lightmap", "vertices"}:
            message, remedy = "Nothing that renders is selected.", "Select a mesh, or bake all objects."
            raise Refused([preflight.Finding("NOTHING_SELECTED", "ERROR", "", message, remedy)])

    def _ended(self, context):
        run, name = self._run, self._names[0]
        self._clean(context)
        scene = bpy.data.scenes.get(name)
        if run.cancelled:
            self.report({"INFO"}, "Cancelled, nothing was changed")
            return {"CANCELLED"}
        if run.error:
            return self._fail(scene or context.scene, run.error)
        try:
            return self._end(context, run.value)
        except Exception as error:
            return self._fail(scene or context.scene, error)

    def _end(self, context, result: Result):
        scene = bpy.data.scenes.get(self._names[0])
        view_layer = scene and scene.view_layers.get(self._names[1])
        if view_layer is None:
            self.report({"ERROR"}, "The scene or its view layer was removed during the bake; there is no result")
            return {"CANCELLED"}
        seconds = time.perf_counter() - self._begun
        line = baked.put(result, scene, view_layer, self._folder, seconds)
        session.keep(line.key, result)
        session.found(scene, [f for f in session.findings(scene) or () if f.severity == "WARNING"])
        timing.learn(*self._work, seconds)
        if line.images and not bpy.app.background:
            preview.show(line.images[0].image)
        for text in (*result.approximated, *result.warnings):
            self.report({"INFO"}, text)
        self.report({"INFO"}, rpt_("Baked in {:.1f} s").format(seconds))
        return {"FINISHED"}

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


class GI_OT_cancel(Operator):
    """End the bake that is on its way; the file stays as it was before (Esc)"""

    bl_idname = "gi.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        if not session.run:
            cls.poll_message_set("No bake is on its way")
        return session.run is not None

    def execute(self, context):
        session.run.cancel()
        return {"FINISHED"}


classes = (GI_OT_bake, GI_OT_cancel)
