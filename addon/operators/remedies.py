# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A button for what the preflight finds, and what it does.

Each looks again after it has done its work, so that what is no longer wrong is no longer shown.
"""

from dataclasses import replace

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import StringProperty
from bpy.types import Operator
from mathutils import Vector

from .. import asked
from ..bake import ON_MAIN_THREAD, making_uvs
from ..stages import Stages
from ..write import lightmap_uvs
from .check import check
from .modal import Modal
from .names import names_of
from .poll import busy

# Code -> operator and what its button says. A finding of another code that names an object gets one that selects it.
REMEDIES = {
    "NO_UV_MAP": ("gi.make_uvs", "Make UV Maps"),
    "EMPTY_UV_MAP": ("gi.make_uvs", "Make UV Maps"),
    "UV_OVERLAP": ("gi.make_uvs", "Make UV Maps"),
    "UV_OUTSIDE": ("gi.make_uvs", "Make UV Maps"),
    "NO_CAMERA": ("gi.add_camera", "Add Camera"),
    "HIDDEN_IN_RENDER": ("gi.show_in_render", "Show in Render"),
    "VERTICES_NOT_WRITABLE": ("gi.make_single_user", "Make Single User"),
    "UNSAVED_RELATIVE_PATH": ("wm.save_mainfile", "Save .blend"),
    "DENOISER_MISSING": ("gi.use_bilateral", "Use Bilateral Filter"),
}

# What making UV maps does, and what each takes of it, roughly.
_UNWRAPPING = {"overlaps": 0.1, "unwrap": 0.9}


class _Remedy:
    """What remedies have in common."""

    bl_options = {"REGISTER", "UNDO"}

    objects: StringProperty(
        name="Objects", description="Names of the objects, with commas between; empty takes all that get light",
        options={"SKIP_SAVE"},
    )  # fmt: skip

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def _chosen(self, context) -> list[bpy.types.Object]:
        """The objects meant, those that are no longer there left out."""
        names = names_of(self.objects) or asked.chosen_objects(context.scene, context.view_layer)
        if not names:
            return asked.surfaces(context.view_layer)
        return [obj for name in names if (obj := context.scene.objects.get(name))]

    def _done(self, context, names) -> set[str]:
        if not names:
            self.report({"WARNING"}, "There was nothing to do")
            return {"CANCELLED"}
        _look_again(context)
        self.report({"INFO"}, ", ".join(names))
        return {"FINISHED"}


def _look_again(context) -> None:
    """Checks anew, beside a living window where there is one."""
    if bpy.app.background or context.window is None:
        check(context.scene, context.view_layer)
    else:
        bpy.ops.gi.check("INVOKE_DEFAULT")


class GI_OT_make_uvs(_Remedy, Modal, Operator):
    """Give each object a UV map for its lightmap, without overlaps; other UV maps stay as they are"""

    bl_idname = "gi.make_uvs"
    bl_label = "Make UV Maps"
    holding = frozenset(_UNWRAPPING)

    def _begin(self, context, seen):
        objects = tuple(obj.name for obj in self._chosen(context) if obj.type == "MESH")
        job = asked.job(context.scene, context.view_layer, target="lightmap", objects=objects)
        job = replace(job, uv="", settings=replace(job.settings, unwrap="missing"))
        return Stages().follow(making_uvs(context.scene, context.view_layer, job), 0, 1, _UNWRAPPING)

    def _on_main(self):
        return ON_MAIN_THREAD.__contains__

    def _end(self, context, made):
        lightmap_uvs.put_all(made)
        return self._done(context, [obj.name for obj in context.scene.objects if obj.data in made])


class GI_OT_show_in_render(_Remedy, Operator):
    """Let the objects render, and the collections and view layers that they are in"""

    bl_idname = "gi.show_in_render"
    bl_label = "Show in Render"

    def execute(self, context):
        objects = self._chosen(context)
        for obj in objects:
            obj.hide_render = False
            _show_collections(context.view_layer.layer_collection, obj)
        return self._done(context, [obj.name for obj in objects])


def _show_collections(layer: bpy.types.LayerCollection, obj: bpy.types.Object) -> bool:
    """Lets the collections render that lead to an object; whether there are any."""
    children = [_show_collections(child, obj) for child in layer.children]
    leads = obj.name in layer.collection.objects or any(children)
    if leads:
        layer.exclude = False
        layer.collection.hide_render = False
    return leads


class GI_OT_add_camera(Operator):
    """Add a camera that sees what the 3D view sees, or else the whole scene, and make it the active one"""

    bl_idname = "gi.add_camera"
    bl_label = "Add Camera"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return _Remedy.poll.__func__(cls, context)

    def execute(self, context):
        scene = context.scene
        data = bpy.data.cameras.new("Camera")
        camera = bpy.data.objects.new("Camera", data)
        scene.collection.objects.link(camera)
        scene.camera = camera
        if view := _view(context):
            camera.matrix_world = view.view_matrix.inverted()
        else:
            _frame(camera, scene, context.view_layer)
        _look_again(context)
        self.report({"INFO"}, camera.name)
        return {"FINISHED"}


def _view(context) -> bpy.types.RegionView3D | None:
    """The largest 3D view of the window."""
    areas = context.window.screen.areas if context.window and not bpy.app.background else ()
    views = [area for area in areas if area.type == "VIEW_3D"]
    return max(views, key=lambda a: a.width * a.height).spaces.active.region_3d if views else None


def _frame(camera: bpy.types.Object, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> None:
    """Turns and moves a camera so that it sees all surfaces, from the front, the right and above."""
    corners = [obj.matrix_world @ Vector(c) for obj in asked.surfaces(view_layer) for c in obj.bound_box]
    if not corners:
        return
    camera.rotation_euler = Vector((1, -1.5, 0.8)).to_track_quat("Z", "Y").to_euler()
    view_layer.update()
    depsgraph = view_layer.depsgraph
    depsgraph.update()
    camera.location, _ = camera.camera_fit_coords(depsgraph, [x for corner in corners for x in corner])


class GI_OT_make_single_user(_Remedy, Operator):
    """Give each object a mesh of its own: light at vertices needs one, since a shared mesh can hold one light only"""

    bl_idname = "gi.make_single_user"
    bl_label = "Make Single User"

    def execute(self, context):
        done = []
        for obj in self._chosen(context):
            if obj.type == "MESH" and obj.data.users > 1 and obj.library is None:
                obj.data = obj.data.copy()
                done.append(obj.name)
        return self._done(context, done)


class GI_OT_use_bilateral(Operator):
    """Smooth noise along surfaces instead of by Open Image Denoise, which this Blender lacks"""

    bl_idname = "gi.use_bilateral"
    bl_label = "Use Bilateral Filter"
    bl_options = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def execute(self, context):
        context.scene.gi_bake.denoise = "BILATERAL"
        _look_again(context)
        return {"FINISHED"}


class GI_OT_select(_Remedy, Operator):
    """Select the objects, to look at what is wrong with them"""

    bl_idname = "gi.select"
    bl_label = "Select"

    def execute(self, context):
        there = [obj for obj in self._chosen(context) if obj.name in context.view_layer.objects]
        for obj in context.view_layer.objects:
            obj.select_set(obj in there, view_layer=context.view_layer)
        if not there:
            self.report({"WARNING"}, "The objects are not in this view layer")
            return {"CANCELLED"}
        context.view_layer.objects.active = there[0]
        self.report({"INFO"}, rpt_("Selected {:d} objects").format(len(there)))
        return {"FINISHED"}


classes = (
    GI_OT_make_uvs, GI_OT_show_in_render, GI_OT_add_camera, GI_OT_make_single_user, GI_OT_use_bilateral, GI_OT_select,
)  # fmt: skip
