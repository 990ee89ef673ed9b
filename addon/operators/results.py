# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with a result: shown, connected to materials, taken away."""

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, EnumProperty
from bpy.types import Operator

from .. import baked, preview
from ..redraw import redraw
from ..write import hookup
from .poll import busy


def line_of(context):
    """The active line in the scene's list of results; None without."""
    group = context.scene.gi_bake
    return group.results[group.active_result] if 0 <= group.active_result < len(group.results) else None


def no_line(cls, context) -> bool:
    if line_of(context) is None:
        cls.poll_message_set("There is no result yet: bake first")
        return True
    return False


class GI_OT_apply(Operator):
    """Connect the baked light to the materials, so that every renderer shows it; Remove takes it out again"""

    bl_idname = "gi.apply"
    bl_label = "Apply to Materials"
    bl_options = {"REGISTER", "UNDO"}

    gltf: BoolProperty(
        name="For glTF Export",
        description="Give lightmaps to Blender's glTF exporter too, as the materials' occlusion on a UV map of its own",
        default=False,
    )

    @classmethod
    def poll(cls, context):
        if busy(cls) or no_line(cls, context):
            return False
        if line_of(context).target not in {"LIGHTMAP", "VERTICES"}:
            cls.poll_message_set("Only lightmaps and light at vertices can be applied to materials")
            return False
        return True

    def execute(self, context):
        names = hookup.apply(context.scene, self.gltf)
        self.report({"INFO"}, rpt_("Applied to {:d} materials").format(len(names)))
        return {"FINISHED"}


class GI_OT_remove(Operator):
    """Take the result out of the materials and out of the file; files in folders stay"""

    bl_idname = "gi.remove"
    bl_label = "Remove"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return not busy(cls) and not no_line(cls, context)

    def execute(self, context):
        hookup.remove(context.scene)
        baked.drop(context.scene, context.scene.gi_bake.active_result)
        redraw(context)
        return {"FINISHED"}


class GI_OT_show(Operator):
    """Show the result in an Image Editor, in a new window where none is free"""

    bl_idname = "gi.show"
    bl_label = "Show"
    bl_options = {"INTERNAL"}

    which: EnumProperty(
        name="Which", description="Images to go through: each call shows the next one", default="RESULT",
        items=(
            ("RESULT", "Result", "What was baked"),
            ("COMPARISON", "Comparison", "Ours, Cycles and their difference, as layers of one image"),
        ), options={"SKIP_SAVE"},
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        if no_line(cls, context):
            return False
        if not line_of(context).images:
            cls.poll_message_set("This result is in the meshes or a volume and has no image")
            return False
        return True

    def execute(self, context):
        line = line_of(context)
        parts = line.images if self.which == "RESULT" else line.comparisons
        images = [part.image for part in parts if part.image]
        if not images:
            self.report({"WARNING"}, "The images are no longer there")
            return {"CANCELLED"}
        shown = next((space.image for space in preview.editors() if space.image in images), None)
        image = images[(images.index(shown) + 1) % len(images)] if shown else images[0]
        if not preview.show(image) and not bpy.app.background:
            bpy.ops.wm.window_new()
            area = context.window_manager.windows[-1].screen.areas[0]
            area.ui_type = "IMAGE_EDITOR"
            area.spaces.active.image = image
        return {"FINISHED"}


classes = (GI_OT_apply, GI_OT_remove, GI_OT_show)
