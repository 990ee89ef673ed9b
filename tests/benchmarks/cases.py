# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the benchmark measures. `suite.py` starts it and writes a case for each line, `["CASE", {"argument": …}]`; the
answer is a line of rows, name -> measure -> value, or {"failed": why}.
"""

import ctypes
import importlib
import inspect
import json
import os
import pkgutil
import sys
import threading
import time
import traceback
from pathlib import Path

from gi_bake.addon.console import find_blenders_modules
from gi_bake.addon.standard_output import quiet

with quiet():
    find_blenders_modules()
    import bpy
    from gi_bake.addon import preflight
    from gi_bake.addon.bake import Refused, bake
    from gi_bake.addon.compare import _camera, _objects, _size, comparable, maps
    from gi_bake.addon.compare.curves import CYCLES_SAMPLES, curves
    from gi_bake.addon.compare.halves import truth
    from gi_bake.addon.job import Job
    from gi_bake.addon.read.images import ImageReader
    from gi_bake.addon.write import lightmap_uvs

import convergence as falling
import lightmaps as many
import numpy as np
from camera import OURS, race, sooner
from gi_bake.gi_core import kernels, metrics, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.scene import ColorSource, Instance, Material, Mesh, Scene
from gi_bake.gi_core.techniques import METHODS
from gi_bake.gi_core.trace import Tracer
from tracer import rates

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"


def opened(name):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{name}.blend"))
    return bpy.context.scene, bpy.context.view_layer


def measured(work):
    """What a function gives, its seconds, those of all processors, and by how many MB memory rose above what it was,
    where Linux tells."""
    status = Path("/proc/self/status")
    tells = status.is_file()

    def memory(name):
        return int(status.read_text().partition(f"{name}:")[2].split()[0]) / 1024 if tells else float("nan")

    if tells:
        # What earlier cases left free goes back, or it would hide what this one takes.
        trim = getattr(ctypes.CDLL(None), "malloc_trim", None)
        if trim:
            trim(0)
        Path("/proc/self/clear_refs").write_text("5")
    before, begin, busy = memory("VmRSS"), time.perf_counter(), time.process_time()
    value = work()
    row = {"seconds": time.perf_counter() - begin, "processor [s]": time.process_time() - busy}
    return value, row | ({"memory [MB]": max(0.0, memory("VmHWM") - before)} if tells else {})


def settings_of(method, asked):
    """The settings of a method with those that were asked for and that it has."""
    kind = METHODS[method].settings
    return kind(**{k: v for k, v in asked.items() if k in kind.__dataclass_fields__})


def sample(name, method, target, side, texels, objects, reference, settings, folder):
    """A sample scene with a technique for a target, against Cycles at the same bounces.

    objects: how many are baked of those that lightmaps and light at vertices are for; Cycles bakes one after the other.
    """
    scene, view_layer = opened(name)
    # What techniques on the screen see for lightmaps and vertices is as large as a picture.
    render = scene.render
    size = render.resolution_x, render.resolution_y
    size = [max(1, round(n * side / max(size))) for n in size]
    render.resolution_x, render.resolution_y, render.resolution_percentage = *size, 100
    meshes = sorted(obj.name for obj in view_layer.objects if obj.type == "MESH" and not obj.hide_render)
    names = tuple(meshes[:objects]) if target in ("lightmap", "vertices") else ()
    key = f"{name} {target} {method}"
    try:
        job = Job(method=method, target=target, objects=names, resolution=side if target == "image" else texels,
                  settings=settings_of(method, settings))  # fmt: skip
        result, row = measured(lambda: tiles.finish(bake(scene, view_layer, job)))
    except Refused as refused:
        return {key: {"refused": ", ".join(sorted({f.code for f in refused.findings if f.severity == "ERROR"}))}}
    if target != "volume":
        row |= errors(scene, view_layer, job, result, reference[target], folder / f"{name} {target}")
    return {key: row}


def errors(scene, view_layer, job, result, samples, folder):
    """relMSE and bias of indirect light over all that counts, the reference's noise, and how long that took; of bakes
    also how long Cycles takes to a single sample."""
    (folder / "begin").mkdir(parents=True, exist_ok=True)
    lightmap_uvs.put_all({bpy.data.meshes[name, None]: uvs for name, uvs in result.uvs.items()})
    names, _ = comparable(result, view_layer) if job.target != "image" else ([], [])
    what = scene, view_layer, job, _size(result), maps(result, names)
    found = truth(*what, samples, folder)
    results = {job.method: result}
    every = _camera(results, found, None) if job.target == "image" else _objects(results, found, names, view_layer)
    every = [s for s in every if s.kind == "indirect"]
    if not every:
        return {}
    x, r, n = (
        np.concatenate([image(s)[s.mask] for s in every]).astype(np.float64)
        for image in (lambda s: s.ours[job.method], lambda s: s.reference, lambda s: s.noise)
    )
    return {
        "relMSE": metrics.relmse(x, r), "noise": metrics.relmse(r + n, r), "bias": metrics.bias(x, r),
        "Cycles' seconds": found.seconds, "Cycles' samples": found.terms["samples"],
        **({} if job.target == "image" else {"Cycles' first sample": truth(*what, 2, folder / "begin").seconds / 2}),
    }  # fmt: skip


def cycles(name, side, reference, settings, folder, counts=CYCLES_SAMPLES):
    """Error over time of Cycles' camera image, as it is and denoised."""
    scene, view_layer = opened(name)
    job = Job(resolution=side, settings=settings_of("rsm", settings | {"samples": 1, "light_samples": 1}))
    result = tiles.finish(bake(scene, view_layer, job))
    folder = folder / f"{name} image"
    folder.mkdir(parents=True, exist_ok=True)
    found = truth(scene, view_layer, job, _size(result), {}, reference["image"], folder)
    indirect = _camera({"rsm": result}, found, None)[0]
    rows = curves(scene, view_layer, {"rsm": result}, indirect.reference, indirect.mask, (), counts)
    return {
        f"{name} image {label}, {r['budget']}": {"seconds": r["seconds"], "relMSE": r["relmse"], "bias": r["bias"],
                                                 "noise": indirect.floor["relmse"]}
        for label in rows if label != "rsm" for r in rows[label]
    }  # fmt: skip


def camera(name, side, bounces, counts, reference, runs):
    """Error over time of RSM's camera image and of Cycles', both denoised."""
    found = race(*opened(name), side, bounces, counts, reference, runs)
    for row, ratio in zip(found[OURS], sooner(found, "seconds")):
        row["Cycles, same error"] = ratio * row["seconds"] if ratio else "not reached"
    return {
        f"{name} {label}, {row.pop('samples')} samples": {"relMSE": row.pop("relmse"), **row}
        for label, rows in found.items() for row in rows
    }  # fmt: skip


def convergence(name, side, reference, counts):
    """How the error of RSM's camera image falls with samples, without a denoiser, and what three bounces are off."""
    found = falling.one_scene(name, side, reference, counts)
    rows = {f"{name} {count} samples": {**row, "noise": found["noise"]} for count, row in found["samples"].items()}
    rows[f"{name} {counts[-1]} samples"]["p of relMSE ~ Nᵖ"] = found["slope"]
    return {**rows, f"{name} 256 samples, three bounces": found["three bounces"]}


def lightmaps(name, side, cycles_samples, samples, interpolation, objects, reference):
    """Lightmaps of many objects, ours and those of Cycles' `object.bake`, both denoised."""
    asked = side, cycles_samples, samples, interpolation, objects, reference
    rows, count, _ = many.pair(*opened(name), *asked)
    rows["GI Bake"]["Cycles, seconds / ours"] = rows["Cycles"]["seconds"] / rows["GI Bake"]["seconds"]
    return {f"{name} {count} of {side}², {who}": row for who, row in rows.items()}


def reading(name):
    """Reading a scene out of Blender, and its trees."""
    scene, view_layer = opened(name)
    (_, core), row = measured(lambda: preflight.inspected(scene, view_layer, ImageReader(), target="image"))
    _, trees = measured(lambda: Tracer(Geometry(core)))
    count = sum(len(core.meshes[i.mesh].triangles) for i in core.instances)
    return {f"read {name}": {**row, "triangles": count}, f"trees {name}": {**trees, "triangles": count}}


def rays():
    return {f"rays, {name}": values for name, values in rates()["rates"].items()}


def of_kernels(side, settings):
    """Seconds of all threads in each kernel's functions while Cornell is baked with every technique."""
    found, lock = {}, threading.Lock()

    def timed(name, function):
        def run(*arguments, **more):
            begin = time.perf_counter()
            value = function(*arguments, **more)
            seconds = time.perf_counter() - begin
            with lock:
                row = found.setdefault(f"kernel {name}", {"seconds": 0.0, "calls": 0})
                row["seconds"] += seconds
                row["calls"] += 1
            return value

        return run

    replaced = {}
    for info in pkgutil.iter_modules(kernels.__path__):
        module = importlib.import_module(f"{kernels.__name__}.{info.name}")
        for name, function in vars(module).items():
            if inspect.isfunction(function) and function.__module__ == module.__name__ and name[0] != "_":
                replaced[function] = timed(name if name == info.name else f"{info.name}.{name}", function)
    for module in [m for n, m in sys.modules.items() if n.startswith("gi_bake.gi_core") and ".kernels." not in n]:
        for name, value in list(vars(module).items()):
            if inspect.isfunction(value) and value in replaced:
                setattr(module, name, replaced[value])
    scene, view_layer = opened("cornell")
    for method in METHODS:
        for more in ({}, {"propagation": "flat"}, {"tracer": "bitmask"}):
            if more.keys() <= METHODS[method].settings.__dataclass_fields__.keys():
                job = Job(method=method, resolution=side, settings=settings_of(method, settings | more))
                tiles.finish(bake(scene, view_layer, job))
    return found


def triangles(count, queries=1 << 18):
    """Trees of a bumpy sheet, and shadow rays over it."""
    side = round((count / 2) ** 0.5) + 1
    x, y = np.meshgrid(np.linspace(0, 1, side, dtype=np.float32), np.linspace(0, 1, side, dtype=np.float32))
    vertices = np.dstack([x, y, 0.1 * np.sin(40 * x) * np.cos(43 * y)]).reshape(-1, 3)
    i = np.arange(side * side, dtype=np.int32).reshape(side, side)
    a, b, c, d = i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]
    faces = np.concatenate([np.dstack([a, b, c]).reshape(-1, 3), np.dstack([a, c, d]).reshape(-1, 3)])
    mesh = Mesh("sheet", vertices, faces, np.zeros((len(faces), 3, 3), np.float32), np.zeros(len(faces), np.int32))
    white = Material("white", ColorSource(np.ones(3, np.float32)))
    scene = Scene((mesh,), (Instance("sheet", 0, np.eye(4), (0,)),), (white,))
    tracer, row = measured(lambda: Tracer(Geometry(scene)))
    rng = np.random.default_rng(0)
    origins = rng.uniform((0, 0, -0.1), (1, 1, 0.3), (queries, 3)).astype(np.float32)
    directions = rng.standard_normal((queries, 3)).astype(np.float32)
    far = np.ones(queries, np.float32)
    begin = time.perf_counter()
    shadows = tiles.run(lambda p: tracer.occluded(origins[p], directions[p], far[p]), tiles.slices(queries, 1 << 15))
    tiles.finish(shadows)
    seconds = time.perf_counter() - begin
    return {f"trees, {count} triangles": row, f"{queries} rays, {count} triangles": {"seconds": seconds}}


def texels(count):
    """A lightmap of the floor of Cornell, a sample for each texel."""
    scene, view_layer = opened("cornell")
    settings = settings_of("rsm", {"samples": 1, "light_samples": 1, "map_resolution": 128})
    job = Job(target="lightmap", objects=("Floor",), resolution=count, settings=settings)
    _, row = measured(lambda: tiles.finish(bake(scene, view_layer, job)))
    return {f"lightmap, {count}² texels": row}


def lights(count):
    """Cornell with so many lamps under its ceiling."""
    scene, view_layer = opened("cornell")
    for i in range(count):
        lamp = bpy.data.lights.new("Lamp", "POINT")
        lamp.energy = 10 / count
        obj = bpy.data.objects.new("Lamp", lamp)
        obj.location = 0.7 * np.cos(2.4 * i), 0.7 * np.sin(2.4 * i), 1.7
        scene.collection.objects.link(obj)
    job = Job(resolution=64, settings=settings_of("rsm", {"samples": 8, "light_samples": 1, "map_resolution": 64}))
    _, row = measured(lambda: tiles.finish(bake(scene, view_layer, job)))
    return {f"image, {count} lamps": row}


def cells(count):
    """A volume of one grid, light going from neighbour to neighbour."""
    scene, view_layer = opened("sunlit_room")
    settings = {"cells": count, "cascades": 1, "propagation": "flat", "map_resolution": 128}
    job = Job(method="lpv", target="volume", settings=settings_of("lpv", settings))
    _, row = measured(lambda: tiles.finish(bake(scene, view_layer, job)))
    return {f"volume, {count}³ cells": row}


_ALL = (sample, cycles, camera, convergence, lightmaps, reading, rays, of_kernels, triangles, texels, lights, cells)
CASES = {f.__name__: f for f in _ALL}


def main():
    for line in sys.stdin:
        case, arguments = json.loads(line)
        if "folder" in arguments:
            arguments["folder"] = Path(arguments["folder"])
        try:
            with quiet():
                answer = CASES[case](**arguments)
        except Exception as error:
            traceback.print_exc()
            answer = {"failed": f"{type(error).__name__}: {error}"}
        os.write(1, f"{json.dumps(answer)}\n".encode())


if __name__ == "__main__":
    main()
