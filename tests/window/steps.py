# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long a bake keeps Blender's window waiting, with the extension installed:

    blender --python tests/window/steps.py -- [--targets image,lightmap] [--compare] [SCENE...]

A timer of Blender's looks at the clock every few milliseconds. Of each stage the longest time between two looks is
said [ms], and in brackets how much of it the main thread and whichever other held it up in Python computed: that other
work on the machine does not lengthen. Cycles is left out. Small bakes: what takes long goes by the scene, not by the
resolution. "idle" is the window without a bake.
"""

import argparse
import os
import sys
import threading
import time
import traceback
from pathlib import Path

import bpy

import addon_utils

SCENES = Path(__file__).resolve().parents[2] / "sample_blends"
MODULE = "bl_ext.user_default.gi_bake"
SIDE = 64

# Seconds between two looks.
_LOOK = 0.004


class Watch:
    """Looks at the clock; longest: stage -> seconds between two looks, and of processor time in between."""

    def __init__(self):
        self.longest: dict[str, tuple[float, float]] = {}
        self._latest, self._clocks, self._stage = None, {}, "idle"

    def look(self):
        run = sys.modules[f"{MODULE}.addon.session"].session.run
        now, clocks = time.perf_counter(), processor_times()
        if self._latest:
            wall, own = now - self._latest, threading.main_thread().ident
            took = {ident: max(0.0, clock - self._clocks.get(ident, 0.0)) for ident, clock in clocks.items()}
            computed = min(wall, took.pop(own) + max(took.values(), default=0.0))
            before = self.longest.get(self._stage, (0.0, 0.0))
            self.longest[self._stage] = max(before[0], wall), max(before[1], computed)
        self._latest, self._clocks = now, clocks
        self._stage = (run.stage or "start") if run else "idle"
        return _LOOK

    def begin(self):
        self.longest.clear()
        self._latest = None


def processor_times() -> dict[int, float]:
    """Of each thread that Python knows [s]."""
    found = {}
    for thread in threading.enumerate():
        try:
            found[thread.ident] = time.clock_gettime(time.pthread_getcpuclockid(thread.ident))
        except (OSError, TypeError):  # it has ended, or not begun
            continue
    return found


def area(kind: str) -> bpy.types.Area:
    areas = bpy.context.window_manager.windows[0].screen.areas
    return max((a for a in areas if a.type == kind), key=lambda a: a.width * a.height)


def started(operator, **given) -> None:
    window, there = bpy.context.window_manager.windows[0], area("PROPERTIES")
    region = next(r for r in there.regions if r.type == "WINDOW")
    with bpy.context.temp_override(window=window, screen=window.screen, area=there, region=region):
        operator("INVOKE_DEFAULT", True, **given)


def measured(watch: Watch, asked: argparse.Namespace):
    """Waits for what each step yields."""
    addon_utils.extensions_refresh()
    addon_utils.enable(MODULE, default_set=True, persistent=True)
    session = sys.modules[f"{MODULE}.addon.session"].session
    area("VIEW_3D").type = "IMAGE_EDITOR"
    area("PROPERTIES").spaces.active.context = "RENDER"
    bpy.app.timers.register(watch.look, persistent=True)
    for name in asked.scenes or sorted(path.stem for path in SCENES.glob("*.blend")):
        for target in asked.targets.split(","):
            bpy.ops.wm.open_mainfile(filepath=str(SCENES / f"{name}.blend"), load_ui=False)
            group = bpy.context.scene.gi_bake
            group.resolution, group.samples, group.image_resolution, group.use_render_size = SIDE, 4, SIDE, False
            group.folder, group.reference_samples = str(Path(asked.folder) / name), 2
            group.target = target.upper()
            begin = time.time()
            yield lambda begin=begin: time.time() - begin > 2
            watch.begin()
            yield lambda begin=begin: time.time() - begin > 3
            works = [bpy.ops.gi.check, bpy.ops.gi.bake, *([bpy.ops.gi.compare] if asked.compare else [])]
            for work in works:
                begin = time.time()
                started(work)
                yield lambda: session.run is None
                seconds = time.time() - begin
                told = ", ".join(f"{s} {1e3 * w:.0f} ({1e3 * own:.0f})" for s, (w, own) in watch.longest.items())
                sys.stdout.write(f"{name} {target} {work.idname_py()} {seconds:.1f} s: {told}\n")
                sys.stdout.flush()
                watch.begin()


class Walk:
    """Goes on at each tick, where what it waits for has come."""

    def __init__(self, work):
        self._work, self._until = work, lambda: True

    def tick(self):
        try:
            if self._until():
                self._until = next(self._work)
            return 0.1
        except StopIteration:
            code = 0
        except Exception:
            traceback.print_exc()
            code = 1
        sys.stdout.flush()
        # Blender would ask whether to save.
        os._exit(code)


parser = argparse.ArgumentParser()
parser.add_argument("--targets", default="image,lightmap,vertices")
parser.add_argument("--compare", action="store_true")
parser.add_argument("--folder", default="/tmp/steps")
parser.add_argument("scenes", nargs="*")
arguments = parser.parse_args(sys.argv[sys.argv.index("--") + 1 :])
bpy.context.preferences.view.show_splash = False
bpy.app.timers.register(Walk(measured(Watch(), arguments)).tick, first_interval=3, persistent=True)
