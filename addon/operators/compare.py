# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A result measured against Cycles."""

from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import IntProperty, StringProperty
from bpy.types import Operator

from .. import asked, baked, preferences, preview
from ..compare import compare
from ..redraw import redraw
from ..session import session
from .findings import failure
from .poll import busy
from .results import line_of, no_line


class GI_OT_compare(Operator):
    """Render with Cycles what was baked and measure how far apart they are; takes as long as Cycles takes"""

    bl_idname = "gi.compare"
    bl_label = "Compare with Cycles"
    bl_options = {"UNDO"}

    samples: IntProperty(
        name="Cycles Samples", description="Samples that Cycles takes; 0 takes the scene's", min=0, max=65536,
        options={"SKIP_SAVE"},
    )  # fmt: skip
    folder: StringProperty(
        name="Folder", description="Folder for report.html and the pictures; empty takes the output folder, or the "
        "cache folder where the .blend is not saved", subtype="DIR_PATH", options={"SKIP_SAVE"},
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

    def execute(self, context):
        scene, line = context.scene, line_of(context)
        view_layer = scene.view_layers.get(line.view_layer)
        if view_layer is None or scene.frame_current != line.frame:
            self.report(
                {"ERROR"},
                rpt_("Go to frame {:d} and keep the view layer '{:s}': that is what was baked").format(
                    line.frame, line.view_layer
                ),
            )
            return {"CANCELLED"}
        folder = self._folder(scene)
        if context.window and not bpy.app.background:
            context.window.cursor_set("WAIT")
        try:
            report = compare(
                session.results[line.key], scene, view_layer, self.samples or scene.gi_bake.reference_samples, folder
            )
            page = next(path for path in report.paths if path.suffix == ".html")
            images = baked.compared(line, report.subjects, page, folder)
        except Exception as error:
            findings = failure(error)
            session.found(scene, findings)
            report(self, findings)
            return {"CANCELLED"}
        finally:
            if context.window and not bpy.app.background:
                context.window.cursor_set("DEFAULT")
        if images and not bpy.app.background:
            preview.show(images[0])
        self.report({"INFO"}, f"relMSE {line.error:.5f}, bias {line.bias:+.2%}: {page}")
        redraw(context)
        return {"FINISHED"}

    def _folder(self, scene) -> Path:
        if self.folder:
            return Path(bpy.path.abspath(self.folder))
        if scene.gi_bake.folder.startswith("//") and not bpy.data.filepath:
            return preferences.cache_folder() / "compared"
        return asked.output(scene)


classes = (GI_OT_compare,)
