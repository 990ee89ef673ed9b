# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reading beside a living window: the file stays as it was, the window has its turns, a cancel ends it.

The wheel has no window, so Blender's render job is done at once there; where that matters a thread stands for it.
"""

import contextlib
import threading
import time
from types import SimpleNamespace

import bpy
import pytest
from gi_bake.addon import run
from gi_bake.addon.read import render_depsgraph, turns
from gi_bake.gi_core.tiles import finish, relayed
from gi_bake.tests.addon.blocks import contents


@pytest.fixture
def cornell(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    return bpy.context.scene


def begun(work):
    """A run of work that yields its progress."""
    return run.Run(relayed(work, lambda fraction: (fraction, "read")), lambda stage: True)


def until(beside, so):
    """Advances a run, until something is so."""
    for _ in range(2000):
        beside.advance(0.01)
        if so():
            return
        time.sleep(0.002)
    raise AssertionError("it does not end")


def settings(scene):
    preferences, handlers = bpy.context.preferences, bpy.app.handlers
    return (
        scene.render.engine, scene.render.use_compositing, scene.camera, [layer.use for layer in scene.view_layers],
        preferences.view.render_display_type, preferences.is_dirty, handlers.render_complete[:],
        handlers.render_cancel[:], [image.name for image in bpy.data.images],
    )  # fmt: skip


@pytest.fixture
def job(monkeypatch):
    """Has a thread of its own instead of Blender's render job; broken: whether Esc was pressed."""
    state = SimpleNamespace(broken=False, thread=None)

    def invoked():
        reader = render_depsgraph._Job.latest.reader
        engine = SimpleNamespace(test_break=lambda: state.broken)
        state.thread = threading.Thread(target=reader.engine.render, args=(engine, None), daemon=True)
        state.thread.start()
        return {"RUNNING_MODAL"}

    monkeypatch.setattr(render_depsgraph, "_invoked", invoked)
    yield state
    assert render_depsgraph._Job.latest is None and not render_depsgraph.is_read()


@pytest.mark.parametrize("camera", [True, False])
def test_beside_a_window_it_reads_the_same_and_leaves_the_file(cornell, camera):
    if not camera:
        cornell.camera = None
    layer, mesh = bpy.context.view_layer, bpy.data.objects["Floor"].data
    before = contents(), settings(cornell)

    @contextlib.contextmanager
    def lent():
        mesh.uv_layers.new(name="Lent")
        yield
        mesh.uv_layers.remove(mesh.uv_layers["Lent"])

    def read(depsgraph):
        assert depsgraph.mode == "RENDER"
        return [
            (entry.object.name, [uv.name for uv in entry.object.data.uv_layers])
            for entry in turns.in_turns(depsgraph.object_instances)
            if entry.object.type == "MESH"
        ]

    at_once = finish(render_depsgraph.reading(cornell, layer, read, lent()))
    beside = begun(render_depsgraph.reading(cornell, layer, read, lent()))
    until(beside, lambda: beside.ended)
    assert beside.error is None and beside.value == at_once and "Lent" in dict(at_once)["Floor"]
    assert (contents(), settings(cornell)) == before


def test_the_window_lives_while_it_is_read_and_has_the_file_as_it_was(cornell, job):
    before, go, where = settings(cornell), threading.Event(), []

    def read(depsgraph):
        where.append(threading.current_thread())
        go.wait(10)
        return "read"

    beside = begun(render_depsgraph.reading(cornell, bpy.context.view_layer, read))
    beside.advance()
    begin = time.perf_counter()
    assert not beside.advance(1), "nothing to do: the window's turn"
    assert time.perf_counter() - begin < 0.5 and render_depsgraph.is_read()
    assert settings(cornell) == before and where == [job.thread]
    go.set()
    until(beside, lambda: beside.ended)
    assert beside.value == "read"


@pytest.mark.parametrize("by", ["cancel", "close", "esc"])
def test_a_cancel_ends_what_reads(cornell, job, by):
    before, seen = settings(cornell), []

    def read(depsgraph):
        for number in turns.in_turns(range(1 << 30)):
            seen.append(number)
            time.sleep(0.001)

    beside = begun(render_depsgraph.reading(cornell, bpy.context.view_layer, read))
    until(beside, lambda: seen)
    if by == "esc":  # the job has it, and nobody else
        job.broken = True
    else:
        getattr(beside, by)()
    until(beside, lambda: beside.ended)
    job.thread.join(10)
    assert not job.thread.is_alive() and beside.cancelled and beside.error is None and beside.value is None
    assert settings(cornell) == before


def test_errors_come_to_the_caller(cornell, job):
    beside = begun(render_depsgraph.reading(cornell, bpy.context.view_layer, lambda depsgraph: 1 / 0))
    until(beside, lambda: beside.ended)
    assert isinstance(beside.error, ZeroDivisionError)


def test_a_blender_that_does_not_render_is_said(cornell, job, monkeypatch):
    before = settings(cornell)
    monkeypatch.setattr(render_depsgraph, "_invoked", lambda: {"CANCELLED"})
    beside = begun(render_depsgraph.reading(cornell, bpy.context.view_layer, lambda depsgraph: None))
    until(beside, lambda: beside.ended)
    assert "wait until the running render has ended" in str(beside.error) and settings(cornell) == before


def test_turns_are_taken_where_a_window_waits(monkeypatch):
    rests = []
    monkeypatch.setattr(turns, "time", SimpleNamespace(sleep=rests.append, perf_counter=iter(range(99)).__next__))
    assert list(turns.in_turns("abc")) == list("abc") and not rests, "nobody waits"
    with turns.taken(lambda: False):
        assert list(turns.in_turns("abc")) == list("abc")
    assert rests == [turns._REST] * 3, "each took a second"
    with turns.taken(lambda: True), pytest.raises(turns.Stopped):
        list(turns.in_turns("abc"))


def test_what_is_worked_out_aside():
    main = threading.main_thread()
    assert finish(run.aside(threading.current_thread)) is main, "at once, where no window waits"
    beside = begun(run.aside(threading.current_thread))
    until(beside, lambda: beside.ended)
    assert beside.value is not main
    beside = begun(run.aside(lambda: 1 / 0))
    until(beside, lambda: beside.ended)
    assert isinstance(beside.error, ZeroDivisionError)
