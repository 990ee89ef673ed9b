# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long light propagation volumes take: injection, geometry volume, propagation, and how it grows with cells.

    python tests/benchmarks/volumes.py [--scene FILE] [--cells 32,64,128] [--cascades 3] [--iterations 8] [--json FILE]

The scene is a .blend or a glTF file, sample_blends/sunlit_room.blend where none is given; one without lamps gets a sun
from above. The lamps' maps are there beforehand.
"""

import argparse
import json
import os
import time
from dataclasses import replace
from pathlib import Path

from gi_bake.addon.standard_output import quiet

with quiet():
    import bpy
    from gi_bake.addon.read import read_scene

import numpy as np
from gi_bake.gi_core import lpv, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.lpv import LpvSettings, hierarchy
from gi_bake.gi_core.lpv.flat import spread
from gi_bake.gi_core.lpv.geometry_volume import blockers, geometry_volume
from gi_bake.gi_core.lpv.grid import placed
from gi_bake.gi_core.lpv.injection import dense
from gi_bake.gi_core.scene import Light
from gi_bake.gi_core.sh import affine
from gi_bake.gi_core.trace import Tracer

SAMPLE = Path(__file__).resolve().parents[2] / "sample_blends" / "sunlit_room.blend"


def opened(path):
    """A file's scene and triangles to trace; a sun where it has no light."""
    with quiet():
        if path.suffix == ".blend":
            bpy.ops.wm.open_mainfile(filepath=str(path))
        else:
            bpy.ops.wm.read_homefile(use_empty=True)
            bpy.ops.import_scene.gltf(filepath=str(path))
        scene = read_scene(bpy.context.scene, bpy.context.view_layer)
    if not scene.lights:
        tilt = np.eye(4)
        tilt[:3, :3] = [[1, 0, 0], [0, 0.96, -0.28], [0, 0.28, 0.96]]
        scene = replace(scene, lights=(Light("Sun", "SUN", tilt, np.full(3, 5, np.float32)),))
    return Tracer(Geometry(scene))


def timed(work):
    begin = time.perf_counter()
    value = work()
    return value, time.perf_counter() - begin


def measured(tracer, lights, cells, cascades, iterations, whole):
    """Seconds of each step of the published scheme, and of the hierarchical one in all cells."""
    settings = LpvSettings(cells=cells, cascades=cascades, iterations=iterations, center="middle")
    grids = placed(tracer.geometry.bounds, None, None, settings)
    surfaces, seconds = timed(lambda: tiles.finish(blockers(tracer.geometry, grids[0].cell)))
    row = {"cells": sum(g.size for g in grids), "inject": 0.0, "geometry": seconds, "propagate": 0.0}
    for grid in grids:
        start, seconds = timed(lambda grid=grid: dense(lights, grid, 0.5, False))
        row["inject"] += seconds
        (blocked, _), seconds = timed(lambda grid=grid: tiles.finish(geometry_volume(surfaces, grid)))
        row["geometry"] += seconds
        _, seconds = timed(lambda a=start, b=blocked: tiles.finish(spread(affine(a), settings, b)))
        row["propagate"] += seconds
    row["published"] = row["inject"] + row["geometry"] + row["propagate"]
    if whole:
        every = [np.arange(g.size) for g in grids]
        _, row["hierarchical"] = timed(
            lambda: tiles.finish(hierarchy.propagated(tracer, lights, grids, every, settings))
        )
    return row


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", type=Path, default=SAMPLE)
    parser.add_argument("--cells", default="32,64,128")
    parser.add_argument("--cascades", type=int, default=3)
    parser.add_argument("--iterations", type=int, default=8)
    parser.add_argument("--hierarchical", type=int, default=64, help="cells up to which all are lit hierarchically too")
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    tracer = opened(a.scene)
    lights, maps = timed(lambda: tiles.finish(lpv.injected(tracer, LpvSettings())))
    report = {"scene": a.scene.name, "triangles": len(tracer.geometry.triangles), "cores": os.cpu_count(),
              "lights": len(lights), "maps": maps, "cascades": a.cascades, "iterations": a.iterations,
              "rows": {}}  # fmt: skip
    lines = [f"{a.scene.name}: {report['triangles']} triangles, {len(lights)} lights in {maps:.2f} s; "
             f"{a.cascades} cascades, {a.iterations} iterations, {os.cpu_count()} cores; seconds",
             "  cells       all   inject  geometry  propagate  published  per million   hierarchical"]  # fmt: skip
    for cells in map(int, a.cells.split(",")):
        row = measured(tracer, lights, cells, a.cascades, a.iterations, cells <= a.hierarchical)
        report["rows"][cells] = row
        line = f"  {cells:>5} {row['cells']:>9} {row['inject']:8.3f} {row['geometry']:9.3f} {row['propagate']:10.3f}"
        line += f" {row['published']:10.3f} {row['published'] / row['cells'] * 1e6:12.2f}"
        lines.append(line + (f" {row['hierarchical']:14.2f}" if "hierarchical" in row else ""))
    if a.json:
        a.json.write_text(json.dumps(report, indent=1))
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
