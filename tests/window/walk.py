# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A walk through the panel in Blender's own window, with the extension installed:

    blender --enable-event-simulate --python tests/window/walk.py -- FOLDER [TARGET]

Loads sunlit_room, bakes as the button does, ends that at the middle by Esc, bakes again and ends it by Cancel, bakes to
the end, compares, applies, and undoes it all: each time the file's data-blocks have to be what they were. FOLDER gets a
picture of the screen at each station, by ImageMagick. Says on standard output what held and how long one step of each
stage kept the main thread busy [processor milliseconds]; the exit code is 1 where something did not hold.
"""

import os
import subprocess
import sys
import time
import traceback
from pathlib import Path

import bpy

import addon_utils

HERE = Path(__file__).resolve()
sys.path.append(str(HERE.parents[1] / "addon"))
from blocks import contents  # noqa: E402

MODULE = "bl_ext.user_default.gi_bake"
FOLDER, TARGET, *_ = [*sys.argv[sys.argv.index("--") + 1 :], "LIGHTMAP"]
failed, longest = [], {}

# Seconds that it may take.
_PATIENCE = 340


def held(what: str, so: bool, more: object = "") -> None:
    sys.stdout.write(f"{'held' if so else 'FAILED'}: {what} {more}\n")
    sys.stdout.flush()
    if not so:
        failed.append(what)


def session():
    return sys.modules[f"{MODULE}.addon.session"].session


def area(kind: str) -> bpy.types.Area:
    areas = bpy.context.window_manager.windows[0].screen.areas
    return max((a for a in areas if a.type == kind), key=lambda a: a.width * a.height)


def over(kind: str, region: str = "WINDOW"):
    """What an operator finds as its context where the pointer is over an area."""
    window, there = bpy.context.window_manager.windows[0], area(kind)
    of = next(r for r in there.regions if r.type == region)
    return bpy.context.temp_override(window=window, screen=window.screen, area=there, region=of)


def called(operator, *arguments, **given):
    with over("PROPERTIES"):
        return operator("INVOKE_DEFAULT", True, *arguments, **given)


def picture(name: str) -> None:
    with over("PROPERTIES"):
        for _ in range(60):
            bpy.ops.view2d.scroll_down()
    bpy.ops.wm.redraw_timer(type="DRAW_WIN_SWAP", iterations=2)
    subprocess.run(["import", "-window", "root", Path(FOLDER) / f"{name}.png"], check=True)


def arranged() -> None:
    """An Image Editor beside the 3D view, and the panel in the properties."""
    with over("VIEW_3D"):
        bpy.ops.screen.area_split(direction="VERTICAL", factor=0.5)
    area("VIEW_3D").type = "IMAGE_EDITOR"
    area("PROPERTIES").spaces.active.context = "RENDER"


def timed() -> None:
    """Notes how long each step keeps the main thread."""
    modal = sys.modules[f"{MODULE}.addon.operators.modal"].Modal
    followed, ended = modal._followed, modal._ended

    def noted(name, call):
        def wrapped(self, *arguments):
            stage = f"{name} {self._run.stage}"
            begin = time.thread_time()
            try:
                return call(self, *arguments)
            finally:
                longest[stage] = max(longest.get(stage, 0), 1000 * (time.thread_time() - begin))

        return wrapped

    modal._followed, modal._ended = noted("step", followed), noted("end", ended)


def free() -> bool:
    return session().run is None


def half() -> bool:
    return free() or session().run.fraction > 0.45


def walk():
    """Waits, until it is so, for what each step yields."""
    addon_utils.extensions_refresh()
    addon_utils.enable(MODULE, default_set=True, persistent=True)
    bpy.ops.wm.open_mainfile(filepath=str(HERE.parents[2] / "sample_blends" / "sunlit_room.blend"), load_ui=False)
    yield lambda: True
    arranged()
    timed()
    yield lambda: True
    group = bpy.context.scene.gi_bake
    group.target, group.resolution, group.folder = TARGET, 64, str(Path(FOLDER) / "baked")
    # Vertices are few, and a bake is to have a middle.
    group.samples = 4096 if TARGET == "VERTICES" else 256
    group.use_render_size, group.image_resolution, group.reference_samples = False, 240, 4
    with over("PROPERTIES"):
        bpy.ops.ed.undo_push(message="Original")
    yield lambda: True
    picture("before")
    before = contents()

    for name in ("esc", "cancel"):
        called(bpy.ops.gi.bake)
        yield half
        held("a bake is on its way at its middle", not free())
        picture(f"during_{name}")
        run, begin = session().run, time.perf_counter()
        if name == "esc":
            window = bpy.context.window_manager.windows[0]
            for value in ("PRESS", "RELEASE"):
                window.event_simulate(type="ESC", value=value, x=300, y=300)
        else:
            called(bpy.ops.gi.cancel)
        yield free
        seconds = time.perf_counter() - begin
        held(f"{name} ends it within a second", run.cancelled and seconds < 1, f"{1000 * seconds:.0f} ms")
        held("the file is as it was", contents() == before)

    called(bpy.ops.gi.bake)
    yield free
    held("a bake to its end", len(group.results) == 1)
    picture("result")
    called(bpy.ops.gi.compare)
    yield lambda: free() or session().run.fraction > 0.3
    picture("comparing")
    yield free
    held("a comparison", group.results[0].compared, f"relMSE {group.results[0].error:.4f}")
    picture("compared")
    steps = 2
    if TARGET != "IMAGE":
        called(bpy.ops.gi.apply)
        yield lambda: True
        held("the light is in the materials", "GI" in str([g.name for g in bpy.data.node_groups]))
        picture("applied")
        steps = 3
    held("the file is not as it was", contents() != before)
    for _ in range(steps):
        with over("PROPERTIES"):
            bpy.ops.ed.undo()
        yield lambda: True
    after = contents()
    others = [key for key in before.keys() | after if before.get(key) != after.get(key)]
    held("undone, the file is as it was", not others, others)
    picture("undone")


class Walk:
    """Goes on with the walk at each tick, where what it waits for has come."""

    def __init__(self):
        self._work, self._until, self._begin = walk(), lambda: True, time.time()

    def tick(self):
        try:
            if self._until():
                self._until = next(self._work)
            if time.time() - self._begin < _PATIENCE:
                return 0.1
            held("the walk ends in time", False, session().run and session().run.stage)
        except StopIteration:
            pass
        except Exception:
            held("no error", False, traceback.format_exc())
        for stage, milliseconds in longest.items():
            sys.stdout.write(f"{stage}: {milliseconds:.0f} ms\n")
        sys.stdout.flush()
        # Blender would ask whether to save.
        os._exit(1 if failed else 0)


Path(FOLDER).mkdir(parents=True, exist_ok=True)
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(Walk().tick, first_interval=3, persistent=True)
