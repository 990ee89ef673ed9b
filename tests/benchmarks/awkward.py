# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that are too much, or too little: what a bake says of them, how long it takes and its peak memory.

    python tests/benchmarks/awkward.py [CASE ...]

Each case is built and baked in a process of its own. Memory is the whole process's, Blender and the file included.
"""

import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import bpy
import numpy as np
from gi_bake.addon.bake import Refused, bake
from gi_bake.addon.job import Job
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.tiles import finish


def link(data, name, **attributes):
    obj = bpy.data.objects.new(name, data)
    bpy.context.collection.objects.link(obj)
    for key, value in attributes.items():
        setattr(obj, key, value)
    return obj


def grid(name, n, size=1.0):
    """A rough square of 2 (n - 1)² triangles."""
    x, y = np.meshgrid(np.linspace(0, size, n, dtype=np.float32), np.linspace(0, size, n, dtype=np.float32))
    z = 0.02 * size * np.sin(40 * x / size) * np.cos(30 * y / size)
    k = np.arange(n * n, dtype=np.int32).reshape(n, n)
    faces = np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], -1).reshape(-1, 4)
    mesh = bpy.data.meshes.new(name)
    mesh.vertices.add(n * n)
    mesh.vertices.foreach_set("co", np.stack([x, y, z], -1).ravel())
    mesh.loops.add(faces.size)
    mesh.loops.foreach_set("vertex_index", faces.ravel())
    mesh.polygons.add(len(faces))
    mesh.polygons.foreach_set("loop_start", np.arange(0, faces.size, 4, dtype=np.int32))
    mesh.uv_layers.new(name="UVMap")
    uv = np.stack([x, y], -1).reshape(-1, 2)[faces.ravel()] / size
    mesh.uv_layers[0].uv.foreach_set("vector", uv.ravel())
    mesh.update()
    return mesh


def lit():
    bpy.ops.wm.read_homefile(use_empty=True)
    link(bpy.data.lights.new("sun", "SUN"), "sun", rotation_euler=(0.5, 0.3, 0))


def linked():
    lit()
    collection = bpy.data.collections.new("furniture")
    thing = bpy.data.objects.new("thing", grid("thing", 9))
    collection.objects.link(thing)
    path = Path(tempfile.mkdtemp()) / "library.blend"
    bpy.data.libraries.write(str(path), {collection})
    lit()
    with bpy.data.libraries.load(str(path), link=True) as (_, to):
        to.collections = ["furniture"]
    bpy.context.scene.collection.children.link(to.collections[0])
    link(grid("floor", 9, 4), "floor", location=(-1, -1, -1))


def hidden():
    lit()
    link(grid("floor", 9), "floor")
    collection = bpy.data.collections.new("hidden")
    bpy.context.scene.collection.children.link(collection)
    collection.objects.link(bpy.data.objects.new("hidden thing", grid("thing", 9)))
    collection.hide_render = True


def instances():
    """An object at each of 10 000 vertices."""
    lit()
    parent = link(grid("points", 100, 20), "points", instance_type="VERTS", show_instancer_for_render=False)
    link(grid("copied", 9, 0.1), "copied", parent=parent)
    link(grid("floor", 9, 20), "floor", location=(0, 0, -1))


def array():
    """An Array modifier of 10 000."""
    lit()
    obj = link(grid("row", 3, 0.1), "row")
    obj.modifiers.new("Array", "ARRAY").count = 10_000
    link(grid("floor", 9, 4), "floor", location=(0, 0, -1))


def no_faces():
    lit()
    link(grid("floor", 9), "floor")
    edges = bpy.data.meshes.new("edges")
    edges.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    link(edges, "edges")


def triangles():
    """Ten million triangles."""
    lit()
    link(grid("large", 2237), "large")


# Case -> how it is built, and the objects that get light, by target.
CASES = {
    "linked": (linked, {"lightmap": ("floor",), "vertices": ("thing",)}),
    "hidden": (hidden, {"lightmap": ("floor",), "vertices": ("hidden thing",)}),
    "instances": (instances, {"lightmap": ("floor",), "vertices": ("floor",)}),
    "array": (array, {"lightmap": ("floor",), "vertices": ("row",)}),
    "no faces": (no_faces, {"lightmap": ("floor",), "vertices": ("edges",)}),
    "triangles": (triangles, {"lightmap": ("large",), "vertices": ("large",)}),
}


def one(case, target):
    build, objects = CASES[case]
    build()
    before, begin = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024, time.perf_counter()
    settings = RsmSettings(samples=8, light_samples=2, map_resolution=128, unwrap="never")
    job = Job(target=target, objects=objects[target], resolution=256, settings=settings)
    try:
        result = finish(bake(bpy.context.scene, bpy.context.view_layer, job))
        said = f"baked {sum(light.valid.sum() for light in result.light.values())} places"
    except Refused as refused:
        said = ", ".join(sorted({f.code for f in refused.findings if f.severity == "ERROR"}))
    seconds, peak = time.perf_counter() - begin, resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    return {"case": case, "target": target, "said": said, "seconds": seconds, "file MB": before, "peak MB": peak}


def say(text):
    sys.stdout.write(f"{text}\n")
    sys.stdout.flush()


def main():
    if sys.argv[1:2] == ["--one"]:
        say(json.dumps(one(*sys.argv[2:4])))
        return
    say("| case | target | what came of it | seconds | before [MB] | peak [MB] |\n|---|---|---|---|---|---|")
    for case in sys.argv[1:] or CASES:
        for target in CASES[case][1]:
            done = subprocess.run([sys.executable, __file__, "--one", case, target], capture_output=True, text=True)
            line = next((text for text in done.stdout.splitlines() if text.startswith("{")), "")
            if not line:
                say(f"| {case} | {target} | failed: {done.stderr.strip().splitlines()[-1:]} |")
                continue
            r = json.loads(line)
            say(f"| {r['case']} | {r['target']} | {r['said']} | {r['seconds']:.1f} | {r['file MB']:.0f} | "
                f"{r['peak MB']:.0f} |")  # fmt: skip


if __name__ == "__main__":
    main()
