# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A result measured against Cycles."""

from pathlib import Path

import bpy
from bpy.props import IntProperty, StringProperty
from bpy.types import Operator

from .. import asked, baked, preferences, preview
from ..bake import Refused
from ..compare import HOLDING, ON_MAIN_THREAD, compare_in_steps, reference
from ..preflight import Finding
from ..sentence import Sentence
from ..session import session
from .modal import Modal
from .poll import busy
from .results import line_of, no_line


class GI_OT_compare(Modal, Operator):
    """Render with Cycles what was baked and measure how far apart they are; takes as long as Cycles takes"""

    bl_idname = "gi.compare"
    bl_label = "Compare with Cycles"
    bl_options = {"UNDO"}
    holding = HOLDING

    samples: IntProperty(
        name="Cycles Samples", description="Samples that Cycles takes; 0 takes the scene's", min=0, max=65536,
        options={"SKIP_SAVE"},
    )  # fmt: skip
    folder: StringProperty(
        name="Folder", description="Folder for report.html and the pictures; empty takes the output folder, or the "
        "cache folder where the .blend is not saved", subtype="DIR_PATH",
        options={"SKIP_SAVE", "PATH_SUPPORTS_BLEND_RELATIVE"},
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        if busy(cls) or no_line(cls, context):
            return False
        line = line_of(context)
        if line.target == "VOLUME":
            cls.poll_message_set("Cycles has no volume of light to compare with: bake another target")
            return False
        if line.key not in session.results:
            cls.poll_message_set("The light itself is no longer in memory: bake again, then compare")
            return False
        return True

    def _begin(self, context, seen):
        scene, line = context.scene, line_of(context)
        view_layer = scene.view_layers.get(line.view_layer)
        if view_layer is None or scene.frame_current != line.frame:
            message = Sentence(
                "Frame {frame} of the view layer '{layer}' was baked.", frame=line.frame, layer=line.view_layer
            )
            remedy = "Go to that frame, and keep the view layer."
            raise Refused([Finding("ELSEWHERE", "ERROR", "", message, remedy)])
        self._layer = line.view_layer
        self._names, self._folder = (scene.name, line.key), self._chosen_folder(scene)
        return _compared(
            session.results[line.key], scene, view_layer, self.samples or scene.gi_bake.reference_samples, self._folder
        )

    def _on_main(self):
        return ON_MAIN_THREAD.__contains__

    def _end(self, context, value):
        report, pictures = value
        name, key = self._names
        scene = bpy.data.scenes.get(name)
        line = scene and next((line for line in scene.gi_bake.results if line.key == key), None)
        if line is None:
            self.report({"ERROR"}, "The result was removed during the comparison")
            return {"CANCELLED"}
        page = next(path for path in report.paths if path.suffix == ".html")
        images = baked.compared(line, report.subjects, page, pictures)
        if images and not bpy.app.background:
            preview.show(images[0])
        self.report({"INFO"}, f"relMSE {line.error:.5f}, bias {line.bias:+.2%}: {page}")
        return {"FINISHED"}

    def _chosen_folder(self, scene) -> Path:
        if self.folder:
            return Path(bpy.path.abspath(self.folder))
        if scene.gi_bake.folder.startswith("//") and not bpy.data.filepath:
            return preferences.cache_folder() / "compared"
        return asked.output(scene)


def _compared(result, scene, view_layer, samples, folder):
    """A comparison and the files of its pictures; a generator of (fraction, stage)."""
    report = yield from compare_in_steps(result, scene, view_layer, samples, folder, go=reference.GO)
    return report, baked.pictured(report.subjects, folder)


classes = (GI_OT_compare,)
