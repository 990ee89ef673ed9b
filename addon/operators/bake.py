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
from ..bake import HOLDING, ON_MAIN_THREAD, Refused, bake
from ..job import Job
from ..properties import METHODS, TARGETS
from ..result import Result
from ..sentence import translated
from ..session import session
from .modal import Modal
from .names import names_of


class GI_OT_bake(Modal, Operator):
    """Bake the light of the scene; the file changes only when all is done"""

    bl_idname = "gi.bake"
    bl_label = "Bake"
    # Not REGISTER, whose panel would bake anew at each touch.
    bl_options = {"UNDO"}
    holding = HOLDING

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
        options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
    )  # fmt: skip

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

    def _on_main(self):
        device, _ = gpu_context.device(self._job.settings.device)
        # A graphics card is to be reached from the main thread.
        always = device is not NUMPY
        return lambda stage: always or stage in ON_MAIN_THREAD

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
            self.report({"INFO"}, translated(text, rpt_))
        self.report({"INFO"}, rpt_("Baked in {:.1f} s").format(seconds))
        return {"FINISHED"}


class GI_OT_cancel(Operator):
    """End the bake or comparison that is on its way; the file stays as it was before (Esc)"""

    bl_idname = "gi.cancel"
    bl_label = "Cancel"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        if not session.run:
            cls.poll_message_set("Nothing is on its way")
        return session.run is not None

    def execute(self, context):
        session.run.cancel()
        return {"FINISHED"}


classes = (GI_OT_bake, GI_OT_cancel)
