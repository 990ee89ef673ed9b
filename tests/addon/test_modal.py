# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes and comparisons beside a living window, driven by hand: to the end, to a cancel, to an error."""

import inspect
import json
import threading
import time
from types import SimpleNamespace

import bpy
import numpy as np
import pytest
from gi_bake.tests.addon.blocks import contents, names

TICK, ESC = SimpleNamespace(type="TIMER", value="NOTHING"), SimpleNamespace(type="ESC", value="PRESS")


class _Windows:
    """A window manager that counts timers and handlers."""

    def __init__(self):
        self.timers, self.handlers, self.windows = [], [], ()

    def event_timer_add(self, seconds, window):
        self.timers.append(seconds)
        return seconds

    def event_timer_remove(self, timer):
        self.timers.remove(timer)

    def modal_handler_add(self, operator):
        self.handlers.append(operator)


def driven(gi, module, name):
    """An operator as a plain object, with its context and what it reports."""
    own = getattr(gi(f"addon.operators.{module}"), name)
    classes = [cls for cls in reversed(own.__mro__) if cls.__module__.startswith(gi("addon").__name__)]
    body = {name: method for cls in classes for name, method in vars(cls).items() if inspect.isfunction(method)}
    made = type(name, (), body)()
    made.holding, made.said = own.holding, []
    made.report = lambda kind, text: made.said.append((kind, text))
    made.context = SimpleNamespace(
        scene=bpy.context.scene, view_layer=bpy.context.view_layer, window=object(), window_manager=_Windows()
    )
    return made


@pytest.fixture
def operator(gi):
    """The bake's operator."""
    made = driven(gi, "bake", "GI_OT_bake")
    made.method, made.target, made.objects, made.uv, made.folder, made.resolution = "RSM", "IMAGE", "", "", "", 0
    made.properties = SimpleNamespace(is_property_set=lambda name: False)
    return made


@pytest.fixture
def comparison(gi, tmp_path, monkeypatch):
    """The comparison's operator, after a bake; Cycles takes one sample of each pixel in a go."""
    monkeypatch.setattr(gi("addon.compare.reference"), "GO", 24 * 24)
    bpy.ops.gi.bake(target="IMAGE")
    made = driven(gi, "compare", "GI_OT_compare")
    made.samples, made.folder = 32, str(tmp_path)
    return made


def follow(operator, until=lambda: False):
    """Ticks until the operator ends, or until something is so; what it answered last."""
    for _ in range(3000):
        answer = operator.modal(operator.context, TICK)
        if answer != {"PASS_THROUGH"} or until():
            return answer
        time.sleep(0.005)
    raise AssertionError("the bake does not end")


def left_over(operator):
    # What a thread was at when it was told to stop it finishes.
    for thread in threading.enumerate():
        if thread.name == "GI Bake":
            thread.join(60)
    return [
        *operator.context.window_manager.timers,
        *(thread for thread in threading.enumerate() if thread.name == "GI Bake"),
        *(image for image in bpy.data.images if image.name == "GI Bake Preview"),
    ]


def test_to_the_end(gi, operator):
    session, group = gi("addon.session").session, bpy.context.scene.gi_bake
    bpy.ops.gi.bake(target="IMAGE")
    alone = list(bpy.data.images["Scene GI"].pixels)
    bpy.ops.gi.remove()
    assert operator._start(operator.context) == {"RUNNING_MODAL"}
    assert session.run and operator.context.window_manager.timers
    assert not bpy.ops.gi.bake.poll()
    shares = []
    assert follow(operator, lambda: shares.append(session.run.fraction if session.run else 1.0)) == {"FINISHED"}
    assert shares == sorted(shares) and session.run is None and left_over(operator) == []
    assert len(group.results) == 1 and list(bpy.data.images["Scene GI"].pixels) == alone


def test_what_touches_blender_stays_on_the_main_thread(gi, operator, monkeypatch):
    where = {}

    def noted(name, call):
        def seen(*arguments, **more):
            where[name] = threading.current_thread() is threading.main_thread()
            return call(*arguments, **more)

        return seen

    preflight, light = gi("addon.preflight"), gi("addon.bake")
    called = (
        (preflight, "reading_scene"), (preflight, "_check_geometry"), (light, "reading_cameras"), (light, "Tracer"),
    )  # fmt: skip
    for module, name in called:
        monkeypatch.setattr(module, name, noted(name, getattr(module, name)))
    denoise = gi("addon.denoise")
    monkeypatch.setattr(denoise.library, "denoised", noted("oidn", denoise.library.denoised))
    monkeypatch.setattr(denoise, "_composited", noted("compositor", denoise._composited))
    bpy.context.scene.gi_bake.denoise = "OIDN"
    operator._start(operator.context)
    assert follow(operator) == {"FINISHED"}
    on_main = {"reading_scene", "reading_cameras"}
    assert where == {name: name in on_main for name in (*on_main, "_check_geometry", "Tracer", "oidn")}
    where.clear()
    monkeypatch.setattr(denoise.library, "library", lambda: None)
    operator._start(operator.context)
    assert follow(operator) == {"FINISHED"} and where["compositor"] and "oidn" not in where


@pytest.mark.parametrize("by", ["esc", "button"])
def test_to_a_cancel_in_the_middle(gi, operator, by):
    session, before = gi("addon.session").session, names()
    bpy.context.scene.gi_bake.samples = 4096
    operator._start(operator.context)
    follow(operator, lambda: session.run.fraction > 0.3)
    run = session.run
    if by == "esc":
        assert operator.modal(operator.context, ESC) == {"RUNNING_MODAL"}
    else:
        assert bpy.ops.gi.cancel() == {"FINISHED"}
    assert operator.modal(operator.context, TICK) == {"CANCELLED"}, "at the next tick, whatever the thread is at"
    assert session.run is None and left_over(operator) == [] and names() == before
    assert run.cancelled and run.value is None and run.error is None
    assert not bpy.context.scene.gi_bake.results


def test_input_waits_while_the_file_is_read(gi, operator, monkeypatch):
    deletes = SimpleNamespace(type="X", value="PRESS")
    operator._start(operator.context)
    assert operator.modal(operator.context, deletes) == {"PASS_THROUGH"}
    monkeypatch.setattr(gi("addon.operators.modal"), "is_read", lambda: True)
    assert operator.modal(operator.context, deletes) == {"RUNNING_MODAL"}
    assert operator.modal(operator.context, SimpleNamespace(type="MOUSEMOVE", value="NOTHING")) == {"PASS_THROUGH"}
    panels = SimpleNamespace(type="WINDOW", x=100, y=0, width=50, height=50)
    area = SimpleNamespace(type="PROPERTIES", regions=[panels])
    operator.context.window = SimpleNamespace(screen=SimpleNamespace(areas=[area]))
    for x, answer in ((120, "PASS_THROUGH"), (90, "RUNNING_MODAL"), (150, "RUNNING_MODAL")):
        click = SimpleNamespace(type="LEFTMOUSE", value="PRESS", mouse_x=x, mouse_y=20)
        assert operator.modal(operator.context, click) == {answer}, "the panel's button cancels"
    assert operator.modal(operator.context, ESC) == {"RUNNING_MODAL"}
    assert follow(operator) == {"CANCELLED"} and left_over(operator) == []


def test_to_an_error(gi, operator, monkeypatch):
    session, before = gi("addon.session").session, names()

    def broken(*arguments):
        raise MemoryError

    monkeypatch.setattr(gi("addon.bake"), "guides", broken)
    operator._start(operator.context)
    assert follow(operator) == {"CANCELLED"}
    assert [f.code for f in session.findings(bpy.context.scene)] == ["OUT_OF_MEMORY"]
    assert any(kind == {"ERROR"} and "OUT_OF_MEMORY" in text for kind, text in operator.said)
    assert session.run is None and left_over(operator) == [] and names() == before


def test_a_check_beside_a_living_window(gi):
    session, scene = gi("addon.session").session, bpy.context.scene
    scene.camera = None
    checking = driven(gi, "check", "GI_OT_check")
    assert checking._start(checking.context) == {"RUNNING_MODAL"}
    assert follow(checking) == {"CANCELLED"} and left_over(checking) == []
    assert [f.code for f in session.findings(scene)] == ["NO_CAMERA"]
    assert [kind for kind, _ in checking.said] == [{"ERROR"}]


def test_uv_maps_are_made_beside_a_living_window(gi, monkeypatch):
    monkeypatch.setattr(gi("addon.operators.modal"), "_STEP", 1e-5)
    session, scene = gi("addon.session").session, bpy.context.scene
    chosen = [bpy.data.objects[name].data for name in ("Floor", "Ceiling")]
    for mesh in chosen:
        while mesh.uv_layers:
            mesh.uv_layers.remove(mesh.uv_layers[0])
    scene.gi_bake.target, before = "LIGHTMAP", names()
    making = driven(gi, "remedies", "GI_OT_make_uvs")
    making.objects = '["Floor", "Ceiling"]'
    assert making._start(making.context) == {"RUNNING_MODAL"}
    follow(making, lambda: session.run.stage == "unwrap")
    assert names() == before and session.run, "the maps come at the end, all at once"
    assert making.modal(making.context, ESC) == {"RUNNING_MODAL"}
    assert follow(making) == {"CANCELLED"} and names() == before and left_over(making) == []
    making._start(making.context)
    assert follow(making) == {"FINISHED"} and left_over(making) == []
    assert all([layer.name for layer in mesh.uv_layers] == ["GI Lightmap"] for mesh in chosen)
    assert session.findings(scene) == (), "and it looks again"


def test_a_comparison_to_the_end(gi, comparison, monkeypatch):
    halves, session = gi("addon.compare.halves"), gi("addon.session").session
    where = {}

    def noted(module, name):
        call = getattr(module, name)

        def seen(*arguments, **more):
            where[name] = threading.current_thread() is threading.main_thread()
            return call(*arguments, **more)

        monkeypatch.setattr(module, name, seen)

    noted(halves, "fingerprinting"), noted(gi("addon.compare"), "write_report"), noted(gi("addon.baked"), "_pictures")
    assert comparison._start(comparison.context) == {"RUNNING_MODAL"}
    shares = []
    assert follow(comparison, lambda: shares.append(session.run.fraction if session.run else 1.0)) == {"FINISHED"}
    assert len(set(shares)) > 4 and shares == sorted(shares), "each go of Cycles is a step"
    assert where == {"fingerprinting": True, "write_report": False, "_pictures": False}
    [line] = bpy.context.scene.gi_bake.results
    assert line.compared and len(line.comparisons) == 9 and session.run is None and left_over(comparison) == []


def test_a_comparison_to_a_cancel_in_the_middle(gi, comparison):
    session, before = gi("addon.session").session, names()
    comparison._start(comparison.context)
    follow(comparison, lambda: session.run.fraction > 0.3)
    assert names() == before, "between its steps the file is as it was"
    assert comparison.modal(comparison.context, ESC) == {"RUNNING_MODAL"}
    assert follow(comparison) == {"CANCELLED"}
    assert names() == before and left_over(comparison) == [] and not bpy.context.scene.gi_bake.results[0].compared


def test_a_scene_that_changes_while_cycles_renders_is_not_compared(gi, comparison, tmp_path):
    comparison._start(comparison.context)
    follow(comparison, lambda: gi("addon.session").session.run.fraction > 0.3)
    bpy.data.objects["Floor"].location.z += 1
    assert follow(comparison) == {"CANCELLED"}
    assert any(kind == {"ERROR"} and "changed" in text for kind, text in comparison.said)
    assert not (tmp_path / "reference.npz").exists()


def test_undo_ends_what_holds_on_to_the_file(gi, comparison):
    session = gi("addon.session").session
    bpy.ops.ed.undo_push(message="Before")
    bpy.ops.ed.undo_push(message="After")
    comparison._start(comparison.context)
    follow(comparison, lambda: session.run.fraction > 0.3)
    bpy.ops.ed.undo()
    comparison.context.scene = bpy.context.scene
    assert follow(comparison) == {"CANCELLED"} and left_over(comparison) == []


def test_another_file_ends_the_bake(gi, operator, sample):
    session = gi("addon.session").session
    bpy.context.scene.gi_bake.samples = 4096
    operator._start(operator.context)
    run = session.run
    follow(operator, lambda: run.fraction > 0.3)
    bpy.ops.wm.open_mainfile(filepath=str(sample("corridor")))
    assert run.ended and run.cancelled and session.run is None
    operator.context.scene = bpy.context.scene
    operator.cancel(operator.context)  # as Blender does with the operators of a window
    assert left_over(operator) == []


def test_a_scene_that_is_gone_at_the_end_is_said(gi, operator):
    operator._start(operator.context)
    follow(operator, lambda: operator._run.fraction > 0.3)
    kept, doomed = bpy.data.scenes.new("Kept"), bpy.data.scenes[operator._names[0]]
    operator.context.scene = kept
    bpy.data.scenes.remove(doomed)
    assert follow(operator) == {"CANCELLED"}
    assert any(kind == {"ERROR"} for kind, _ in operator.said) and left_over(operator) == []


def test_a_view_layer_that_is_removed_ends_what_holds_on_to_it(gi, comparison):
    session, scene = gi("addon.session").session, bpy.context.scene
    comparison._start(comparison.context)
    follow(comparison, lambda: session.run.fraction > 0.3)
    scene.view_layers.new("Kept")
    scene.view_layers.remove(scene.view_layers[0])
    assert follow(comparison) == {"CANCELLED"} and left_over(comparison) == []
    assert [f.code for f in session.findings(scene)] == ["SCENE_GONE"]


def test_the_picture_so_far_is_shown_and_taken_away_and_never_saved(gi, tmp_path):
    preview = gi("addon.preview").Preview()
    light = np.full((4, 8, 3), 0.5, np.float32)
    assert not preview.refresh()
    preview("", slice(4, 8), light)
    assert preview.refresh() and not preview.refresh()
    image = bpy.data.images["GI Bake Preview"]
    assert tuple(image.size) == (8, 8) and image.pixels[0] == 0 and image.pixels[4 * 8 * 4] == 0.5
    image.use_fake_user = True  # as an editor that shows it is a user
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "during.blend"), copy=True)
    with bpy.data.libraries.load(str(tmp_path / "during.blend")) as (there, _):
        assert "GI Bake Preview" not in there.images
    preview("", slice(0, 4), light)
    assert preview.refresh() and "GI Bake Preview" in bpy.data.images
    preview.remove()
    assert "GI Bake Preview" not in bpy.data.images


def test_light_at_vertices_so_far_is_drawn_over_its_surfaces(gi, operator, monkeypatch):
    monkeypatch.setattr(gi("addon.operators.modal"), "_PICTURE", 0.0)
    group = bpy.context.scene.gi_bake
    group.target, group.domain = "VERTICES", "CORNER"
    before = contents()
    operator._start(operator.context)
    drawn = operator._preview.in_views
    follow(operator, lambda: drawn._handler)
    assert drawn._handler and contents() == before, "nothing of it is in the file"
    assert follow(operator) == {"FINISHED"} and drawn._handler is None
    places, light = drawn.triangles()
    wanted = []
    for obj in (bpy.data.objects[name] for name in json.loads(group.results[0].objects)):
        values = obj.data.attributes["gi_irradiance_corner"].data
        for triangle in obj.data.loop_triangles:
            for vertex, loop in zip(triangle.vertices, triangle.loops):
                wanted.append([*obj.matrix_world @ obj.data.vertices[vertex].co, *values[loop].color[:3]])
    wanted = np.array(wanted)
    assert np.allclose(places, wanted[:, :3], atol=1e-5)
    assert np.corrcoef(light.ravel(), wanted[:, 3:].ravel())[0, 1] > 0.9, "before corners inside of boxes are filled"


def test_a_triangle_is_drawn_when_all_its_corners_are_known(gi):
    preview = gi("addon.preview").Preview()
    places, light = np.arange(12, dtype=np.float32).reshape(4, 3), np.ones((4, 1, 3), np.float32)
    preview("Floor", slice(2, 6), light, places)
    assert preview.refresh() and not preview.refresh()
    assert np.array_equal(preview.in_views.triangles()[0], places[1:])
    preview("Floor", slice(0, 2), light[:2], places[:2])
    assert len(preview.in_views.triangles()[0]) == 6
    preview.remove()


def test_a_walk_through_the_panel_is_undone_whole(gi, operator, sample, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(sample("sunlit_room")))
    group, session = bpy.context.scene.gi_bake, gi("addon.session").session
    group.samples, group.use_render_size, group.image_resolution, group.antialias = 8, False, 48, 1
    bpy.ops.ed.undo_push(message="Original")
    before = contents()

    def context():
        operator.context.scene, operator.context.view_layer = bpy.context.scene, bpy.context.view_layer
        return operator.context

    operator._start(context())
    follow(operator, lambda: session.run.fraction > 0.5)
    operator.modal(context(), ESC)
    assert follow(operator) == {"CANCELLED"} and left_over(operator) == []
    assert contents() == before

    # Blender pushes a step after each operator that was started from its interface.
    operator._start(context())
    assert follow(operator) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Bake")
    assert bpy.ops.gi.compare(samples=2, folder=str(tmp_path)) == {"FINISHED"}
    bpy.ops.ed.undo_push(message="Compare")
    steps = ["Compare", "Bake"]
    if bpy.ops.gi.apply.poll():
        assert bpy.ops.gi.apply() == {"FINISHED"}
        bpy.ops.ed.undo_push(message="Apply")
        steps.append("Apply")
    assert contents() != before
    for _ in steps:
        assert bpy.ops.ed.undo() == {"FINISHED"}
    assert contents() == before
