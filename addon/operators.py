# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.gi`: everything that the panel does, alike in a window, in the background and in scripts.

    bpy.ops.gi.bake(method="RSM", target="LIGHTMAP", resolution=512)      to its end
    bpy.ops.gi.bake("INVOKE_DEFAULT")                                     as the button does, beside a living window
"""

import json
import logging
import shutil
import time
import traceback
from pathlib import Path

import bpy
from bpy.app.translations import pgettext_rpt as rpt_
from bpy.props import BoolProperty, EnumProperty, IntProperty, StringProperty
from bpy.types import Operator

from ..gi_core.device import NUMPY
from ..gi_core.settings import SettingError
from . import asked, baked, gpu_context, preferences, preflight, preview, timing
from .bake import ON_MAIN_THREAD, Job, NotThere, Refused, Result, bake
from .compare import compare
from .properties import METHODS, TARGETS
from .run import Run
from .session import session
from .write import hookup

log = logging.getLogger(__name__)

# Seconds between two looks of a modal bake, and how long each may take.
_TICK, _STEP = 0.05, 0.04

# Seconds between two pictures of the result so far.
_PICTURE = 0.3


def names_of(text: str) -> tuple[str, ...]:
    """Names with commas between, or a JSON list of names, which may have commas in them."""
    found = json.loads(text) if text.startswith("[") else text.split(",")
    return tuple(dict.fromkeys(name for each in found if (name := each.strip())))


def _busy(cls) -> bool:
    """Whether a bake is on its way, said as `poll` says it."""
    if session.run:
        cls.poll_message_set("A bake is on its way: wait, or cancel it")
    return session.run is not None


def _report(operator: Operator, findings) -> None:
    """Errors and warnings where Blender shows and logs them: all in one, since a report in a script is an exception."""
    for severity in ("WARNING", "ERROR"):
        said = [f for f in findings if f.severity == severity]
        if said:
            text = "\n".join(f"{f.code}: {f.message} {f.remedy}" for f in said[:5])
            more = rpt_("\n… and {:d} more").format(len(said) - 5) if len(said) > 5 else ""
            operator.report({severity}, text + more)


def _failure(error: Exception) -> list[preflight.Finding]:
    """An error as findings: of the preflight, of a setting, or one that nobody foresaw."""
    if isinstance(error, Refused):
        return error.findings
    if isinstance(error, (NotThere, SettingError)):
        return [preflight.Finding("SETTING", "ERROR", "", f"{str(error)[:1].upper()}{str(error)[1:]}.", "")]
    if isinstance(error, MemoryError):
        remedy = "Lower the resolution or the setting Memory."
        return [preflight.Finding("OUT_OF_MEMORY", "ERROR", "", "The machine has no memory left.", remedy)]
    if isinstance(error, OSError):
        remedy = "Choose another output folder."
        return [preflight.Finding("NOT_WRITTEN", "ERROR", "", f"A file was not written: {error}.", remedy)]
    log.error("%s", "".join(traceback.format_exception(error)))
    remedy = "The system console says where; nothing was changed."
    return [preflight.Finding("FAILED", "ERROR", "", f"The bake failed: {error}.", remedy)]


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
        return not _busy(cls)

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
        _redraw(context)
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
        findings = _failure(error)
        session.found(scene, findings)
        _report(self, findings)
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
        _redraw(context)


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


class GI_OT_check(Operator):
    """Look for everything that would make a bake fail or come out black, without baking; takes about as long as reading the scene"""  # noqa: E501

    bl_idname = "gi.check"
    bl_label = "Check"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        return not _busy(cls)

    def execute(self, context):
        findings = check(context.scene, context.view_layer)
        _report(self, findings)
        if any(f.severity == "ERROR" for f in findings):
            return {"CANCELLED"}
        self.report({"INFO"}, "Ready to bake")
        return {"FINISHED"}


def check(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> list[preflight.Finding]:
    """What stands in the way of what the scene's properties ask for; kept for the panel."""
    try:
        job = asked.job(scene, view_layer, device=preferences.device())
        folder = scene.gi_bake.folder if asked.needs_folder(scene, job.target) else None
        findings = preflight.check(
            scene, view_layer, target=job.target, objects=job.objects, uv=job.uv, output=folder,
            denoise=job.settings.denoise, glossy=job.settings.glossy,
        )  # fmt: skip
    except Exception as error:
        findings = _failure(error)
    session.found(scene, findings)
    return findings


def _line(context):
    """The active line in the scene's list of results; None without."""
    group = context.scene.gi_bake
    return group.results[group.active_result] if 0 <= group.active_result < len(group.results) else None


def _no_line(cls, context) -> bool:
    if _line(context) is None:
        cls.poll_message_set("There is no result yet: bake first")
        return True
    return False


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
        if _busy(cls) or _no_line(cls, context):
            return False
        line = _line(context)
        if line.target == "VOLUME":
            cls.poll_message_set("Cycles has no volume of light to compare with: bake another target")
            return False
        if line.key not in session.results:
            cls.poll_message_set("The light itself is no longer in memory: bake again, then compare")
            return False
        return True

    def execute(self, context):
        scene, line = context.scene, _line(context)
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
            findings = _failure(error)
            session.found(scene, findings)
            _report(self, findings)
            return {"CANCELLED"}
        finally:
            if context.window and not bpy.app.background:
                context.window.cursor_set("DEFAULT")
        if images and not bpy.app.background:
            preview.show(images[0])
        self.report({"INFO"}, f"relMSE {line.error:.5f}, bias {line.bias:+.2%}: {page}")
        _redraw(context)
        return {"FINISHED"}

    def _folder(self, scene) -> Path:
        if self.folder:
            return Path(bpy.path.abspath(self.folder))
        if scene.gi_bake.folder.startswith("//") and not bpy.data.filepath:
            return preferences.cache_folder() / "compared"
        return asked.output(scene)


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
        if _busy(cls) or _no_line(cls, context):
            return False
        if _line(context).target not in {"LIGHTMAP", "VERTICES"}:
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
        return not _busy(cls) and not _no_line(cls, context)

    def execute(self, context):
        hookup.remove(context.scene)
        baked.drop(context.scene, context.scene.gi_bake.active_result)
        _redraw(context)
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
        if _no_line(cls, context):
            return False
        if not _line(context).images:
            cls.poll_message_set("This result is in the meshes or a volume and has no image")
            return False
        return True

    def execute(self, context):
        line = _line(context)
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


class GI_OT_clear_cache(Operator):
    """Delete what is in the cache folder: comparisons of files that are not saved, and timings"""

    bl_idname = "gi.clear_cache"
    bl_label = "Clear Cache"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        if not preferences.cached_files():
            cls.poll_message_set("The cache folder is empty")
            return False
        return True

    def execute(self, context):
        shutil.rmtree(preferences.cache_folder(), ignore_errors=True)
        return {"FINISHED"}


def _redraw(context) -> None:
    """Draws the editors that show a panel of ours or an image."""
    for window in context.window_manager.windows:
        for area in window.screen.areas:
            if area.type in {"PROPERTIES", "VIEW_3D", "IMAGE_EDITOR"}:
                area.tag_redraw()


classes = (
    GI_OT_bake, GI_OT_cancel, GI_OT_check, GI_OT_compare, GI_OT_apply, GI_OT_remove, GI_OT_show, GI_OT_clear_cache,
)  # fmt: skip
register, unregister = bpy.utils.register_classes_factory(classes)
