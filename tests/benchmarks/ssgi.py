# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI: what a frame costs in each mode, in seconds by pass, those of all cores in brackets, and in memory.

    python tests/benchmarks/ssgi.py [--scene pan] [--size 960x540] [--json FILE]

One pass of one ray per pixel at HDRP's medium preset for the screen, in all modes at full resolution but where it says
so, both filters. Each mode runs in a process of its own, whose peak of memory is told less what it had before the first
pixel.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
MODES = {
    "screen_space": {"mode": "screen_space"},
    "half resolution": {"mode": "screen_space", "full_resolution": False},
    "bitmask, 8 steps": {"mode": "screen_space", "tracer": "bitmask", "quality": "custom", "steps": 8},
    "mixed": {"mode": "mixed", "quality": "custom"},
    "ray_traced": {"mode": "ray_traced", "quality": "custom"},
}


def one(scene: str, size: tuple[int, int], mode: str) -> dict:
    """Seconds by pass, and memory, of a mode; run in a process of its own."""
    from gi_bake.addon.standard_output import quiet

    with quiet():
        import bpy
        from gi_bake.addon.read import read_scene

        bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{scene}.blend"))
        core = read_scene(bpy.context.scene, bpy.context.view_layer)
    from gi_bake.gi_core import tiles
    from gi_bake.gi_core.geometry import Geometry
    from gi_bake.gi_core.ssgi import pipeline
    from gi_bake.gi_core.ssgi.settings import SsgiSettings
    from gi_bake.gi_core.trace import Tracer

    settings = SsgiSettings(**{"quality": "medium", "samples": 1, "frames": 1, "light_samples": 4} | MODES[mode])
    tracer, camera = Tracer(Geometry(core)), replace(core.camera, resolution=size)
    seconds, processor = {}, {}

    def timed(name, function):
        def run(*arguments, **more):
            begin = time.perf_counter(), time.process_time()
            value = yield from function(*arguments, **more)
            for spent, clock, start in zip((seconds, processor), (time.perf_counter, time.process_time), begin):
                spent[name] = spent.get(name, 0) + clock() - start
            return value

        return run

    for name, function in (
        ("probes", "bake_probes"), ("G-buffer", "g_buffer"), ("direct light", "direct_light"), ("search", "searched"),
        ("diffuse filters", "_filtered"), ("frame", "one_pass"),
    ):  # fmt: skip
        setattr(pipeline, function, timed(name, getattr(pipeline, function)))
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    tiles.finish(pipeline.still(tracer, camera, settings))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    return {"seconds": seconds, "processor seconds": processor, "memory [MB]": (peak - before) / 1024}


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="pan")
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--json", type=Path)
    parser.add_argument("--one", help=argparse.SUPPRESS)
    a = parser.parse_args()
    size = tuple(int(n) for n in a.size.split("x"))
    if a.one:
        os.write(1, json.dumps(one(a.scene, size, a.one)).encode())
        return
    report, lines = {"cores": os.cpu_count(), "scene": a.scene, "size": size, "modes": {}}, [f"{a.scene}, {a.size}"]
    for mode in MODES:
        command = [sys.executable, __file__, "--scene", a.scene, "--size", a.size, "--one", mode]
        report["modes"][mode] = found = json.loads(subprocess.run(command, capture_output=True, check=True).stdout)
        spent = found["processor seconds"]
        each = "  ".join(f"{k} {v:.2f} ({spent[k]:.2f}) s" for k, v in found["seconds"].items())
        lines.append(f"  {mode:<17}{found['memory [MB]']:6.0f} MB  {each}")
    if a.json:
        a.json.write_text(json.dumps(report, indent=1))
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
