# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is done with a result: shown, connected to materials, taken away."""

import json

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, EnumProperty
from bpy.types import Operator

from .. import baked, preview
from ..redraw import redraw
from ..sentence import translated
from ..write import hookup
from ..write.attributes import ATTRIBUTE, CORNERS
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
        try:
            names = hookup.apply(context.scene, self.gltf, line_of(context).target == "VERTICES")
        except hookup.HookupError as error:
            self.report({"ERROR"}, translated(error.args[0], rpt_))
            return {"CANCELLED"}
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
    """Show the result in an Image Editor, in a new window where none is free; light at vertices in the 3D views, as the colour of solid shading"""  # noqa: E501

    bl_idname = "gi.show"
    bl_label = "Show"
    bl_options = {"INTERNAL"}

    which: EnumProperty(
        name="Which", description="What to show; asked for again, it is the next image", default="RESULT",
        items=(
            ("RESULT", "Result", "What was baked"),
            ("BAKED", "Baked", "The light that was compared, as it was baked"),
            ("CYCLES", "Cycles", "The same light by Cycles"),
            ("DIFFERENCE", "Difference", "Where the bake is too bright (red) and too dark (blue)"),
        ), options={"SKIP_SAVE"},
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        if no_line(cls, context):
            return False
        if line_of(context).target == "VOLUME":
            cls.poll_message_set("This result is an object, which the 3D view shows")
            return False
        return True

    def execute(self, context):
        line = line_of(context)
        if line.target == "VERTICES" and self.which == "RESULT":
            return self._in_3d_views(context, json.loads(line.objects))
        image = _following(line, self.which)
        if image is None:
            self.report({"WARNING"}, "The images are no longer there")
            return {"CANCELLED"}
        if not preview.show(image) and not bpy.app.background:
            bpy.ops.wm.window_new()
            area = context.window_manager.windows[-1].screen.areas[0]
            area.ui_type = "IMAGE_EDITOR"
            area.spaces.active.image = image
        return {"FINISHED"}

    def _in_3d_views(self, context, names):
        meshes = [context.scene.objects[name].data for name in names if name in context.scene.objects]
        every = [layer for mesh in meshes for layer in mesh.color_attributes]
        light = [layer for layer in every if layer.name in (ATTRIBUTE, CORNERS)]
        for layer in light:
            layer.id_data.color_attributes.active_color = layer
        if not light:
            self.report({"WARNING"}, "The light is no longer there")
            return {"CANCELLED"}
        for window in context.window_manager.windows:
            for area in window.screen.areas:
                if area.type == "VIEW_3D":
                    shading = area.spaces.active.shading
                    shading.type, shading.light, shading.color_type = "SOLID", "FLAT", "VERTEX"
        return {"FINISHED"}


def _following(line, which: str) -> bpy.types.Image | None:
    """The image to show: after the one that is shown, or of a comparison the same part in another layer."""
    groups = {"RESULT": [part.image for part in line.images]}
    for part in line.comparisons:
        groups.setdefault(part.name, []).append(part.image)
    images = groups.get(which, [])
    there = {space.image for space in preview.editors()} - {None}
    others = [k for name in baked.LAYERS for k, image in enumerate(groups.get(name, [])) if image in there]
    own = [k for k, image in enumerate(images) if image in there]
    first = own[0] + 1 if own else others[0] if others and which != "RESULT" else 0
    return next((image for image in images[first:] + images[:first] if image), None)


classes = (GI_OT_apply, GI_OT_remove, GI_OT_show)
