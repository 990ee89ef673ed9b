# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long a bake keeps Blender's window waiting: the longest step on the main thread of each stage, in milliseconds of
that thread's processor time, which other work on the machine does not lengthen; of "materials" also without Cycles.

    .venv/bin/python tests/benchmarks/steps.py [SCENE...]

What runs aside (see `addon/run.py`) keeps no window waiting and is left out. Small bakes: what takes long on the main
thread goes by the scene, not by the resolution.
"""

import sys
import time
from pathlib import Path

import bpy
from gi_bake.addon.bake import ON_MAIN_THREAD, bake
from gi_bake.addon.job import Job
from gi_bake.addon.read import surface_bakes
from gi_bake.addon.write.results import store
from gi_bake.gi_core.rsm.settings import RsmSettings

SCENES = Path(__file__).resolve().parents[2] / "sample_blends"
TARGETS = {"image": 64, "lightmap": 64, "vertices": None}


in_cycles = [0.0]


def timed(call):
    """Notes how long Cycles takes."""

    def wrapped(*arguments):
        begin = time.thread_time()
        try:
            return call(*arguments)
        finally:
            in_cycles[0] += time.thread_time() - begin

    return wrapped


surface_bakes._Studio._run = timed(surface_bakes._Studio._run)


def longest(target: str) -> dict[str, float]:
    """Stage -> seconds of its longest step, of the scene that is open."""
    scene, found, stage = bpy.context.scene, {}, ""
    job = Job(target=target, resolution=TARGETS[target], settings=RsmSettings(samples=4))
    work = bake(scene, bpy.context.view_layer, job)
    while True:
        begin, in_cycles[0] = time.thread_time(), 0.0
        try:
            _, following = next(work)
        except StopIteration as stop:
            begin = time.thread_time()
            store(stop.value, scene)
            found["store"] = time.thread_time() - begin
            return found
        if stage in ON_MAIN_THREAD:
            found[stage] = max(found.get(stage, 0.0), time.thread_time() - begin)
            own = f"{stage} without Cycles"
            if stage == "materials":
                found[own] = max(found.get(own, 0.0), time.thread_time() - begin - in_cycles[0])
        stage = following


def main(names: list[str]) -> None:
    for name in names or sorted(path.stem for path in SCENES.glob("*.blend")):
        for target in TARGETS:
            bpy.ops.wm.open_mainfile(filepath=str(SCENES / f"{name}.blend"), load_ui=False)
            try:
                steps = longest(target)
            except Exception as error:
                sys.stdout.write(f"{name} {target}: {error}\n")
                continue
            told = ", ".join(f"{stage} {1000 * seconds:.0f}" for stage, seconds in steps.items())
            sys.stdout.write(f"{name} {target}: {told}\n")


main(sys.argv[1:])
