# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Kernels on the graphics card against numpy on all cores: seconds, their ratio, what is moved, how near the ceiling.

    python tests/benchmarks/gpu.py [--scene pan] [--size 960x540] [--pairs 3] [--only TEXT] [--json FILE]

Both are timed in turn, as many pairs as asked for; ratios are the pairs' median, seconds are the least. Of a driver
that computes on the processor the ratio of processor time is told too, which says more where others use the machine.
Images lie where they are worked on before a kernel starts; a frame starts from the G-buffer in memory and ends with
the result there. What is moved is what a kernel's arrays hold, each once. The ceiling is that of texels read, where
their number is known, else that of memory; both are measured here, by shaders that do nothing else.
"""

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from gi_bake.addon import gpu_context
from gi_bake.addon.standard_output import quiet
from gi_bake.gi_core import filter as smoothing
from gi_bake.gi_core import raster, tiles
from gi_bake.gi_core.device import NUMPY, Device, GpuDevice
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_raster import Raster
from gi_bake.gi_core.kernels.bilateral import bilateral
from gi_bake.gi_core.kernels.depth_pyramid import depth_pyramid
from gi_bake.gi_core.kernels.lpv_arriving import arriving
from gi_bake.gi_core.kernels.lpv_inject import coefficients, summed
from gi_bake.gi_core.kernels.lpv_transfer import sharpened
from gi_bake.gi_core.kernels.lpv_trilinear import trilinear
from gi_bake.gi_core.kernels.reproject import reproject
from gi_bake.gi_core.lpv import flat
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.ssgi import pipeline
from gi_bake.gi_core.ssgi.frame import before, depth_map, direct_light, g_buffer
from gi_bake.gi_core.ssgi.screen import Screen
from gi_bake.gi_core.ssgi.search import Search, searched
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.surfels import TILE, camera_rays
from gi_bake.gi_core.trace import Tracer
from gi_bake.tests.benchmarks.gpu_gather import gathering

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parents[1] / "sample_blends"
ITEMS = 1 << 20

# Work that leaves its result on the device, with all that it needs there.
Work = Callable[[], Iterator[float]]


@dataclass(frozen=True)
class Case:
    """What is timed. on: makes the work for a device. reads: texels that the kernel reads in all, 0 if not known."""

    on: Callable[[Device], Work]
    reads: float = 0


def on_screen(geometry: Geometry, camera) -> dict[str, Case]:
    """The passes of screen-space GI, and whole frames of one ray per pixel, at HDRP's medium preset."""
    tracer = Tracer(geometry)
    settings = SsgiSettings(mode="screen_space", fallback="none", quality="medium", samples=1, frames=1).preset
    full = tiles.finish(g_buffer(tracer, Screen(camera)))
    direct = tiles.finish(direct_light(tracer, full, 4, 1, 0))
    n, pixels = np.count_nonzero(full.surface), full.depth.size

    def inputs(device: Device, settings: SsgiSettings = settings) -> pipeline.Inputs:
        buffer = full[1 if settings.full_resolution else 2]
        search = Search(Tracer(geometry, device), full, buffer, settings, None)
        return pipeline.Inputs(full, buffer, direct, search)

    def started(device: Device) -> tuple[pipeline.Inputs, object]:
        """A picture that has a history, all on the device."""
        there = inputs(device)
        return there, tiles.finish(pipeline.one_pass(there, None, settings))[1]

    def eyes(device: Device) -> Tracer:
        """Pictures are drawn on a card, in software too; on the processor Embree traces them."""
        tracer = Tracer(geometry, device)
        if device is not NUMPY:
            tracer.raster = Raster(geometry, np.flatnonzero(geometry.casts & ~geometry.clear), device)
        return tracer

    def primary(device):
        tracer, (origins, directions) = eyes(device), camera_rays(camera)

        def work():
            if (yield from tracer.drawn(raster.of_camera(camera), origins, directions)) is None:
                yield from tiles.run(lambda part: tracer.closest(origins[part], directions[part]),
                                     tiles.slices(pixels, TILE))  # fmt: skip

        return work

    def seen(device):
        tracer = eyes(device)
        return lambda: g_buffer(tracer, Screen(camera))

    def planes(device):
        there = inputs(device).search
        return lambda: depth_map(there.seen, device)

    def pyramid(device):
        nearest = device.array(full.depth.clip(0, 1e30), 1)
        return lambda: device.each(lambda part: device.run(depth_pyramid, nearest, 7), 1, 1)

    def march(device):
        search = started(device)[0].search
        return lambda: searched(search, None, 0)

    def light(device, **more):
        there = inputs(device, replace(settings, **more))
        found = tiles.finish(searched(there.search, None, 0))
        return lambda: found.radiance(there.lit, 0)

    def again(device):
        there, history = started(device)
        every, at = device.array(np.arange(pixels, dtype=np.int32), 1), device.array(before(full, full)[0], 3, -1e30)
        depth = there.here.depth

        def tile(part: slice):
            return device.run(reproject, every[part], at, history.picture, depth, 0.1)

        return lambda: device.each(tile, pixels, 1 << 14)

    def taps(device):
        there, history = started(device)
        return lambda: pipeline._history(there, replace(history, buffer=replace(full)))

    def mixed(device):
        there, history = started(device)
        taps = tiles.finish(pipeline._history(there, history))
        return lambda: pipeline._mixed(history.filtered, history.filtered, history, taps, there, settings)

    def filtered(device):
        there, history = started(device)
        return lambda: pipeline._filtered(there, history.filtered, settings, range(1))

    def upsampled(device):
        there = inputs(device, replace(settings, full_resolution=False))
        half = device.array(np.ascontiguousarray(direct[::2, ::2]), 3)
        tiles.finish(pipeline._upsampled(there, half))
        return lambda: pipeline._upsampled(there, half)

    def frame(device, **more):
        chosen = replace(settings, **more)

        def work():
            radiance, _, _ = yield from pipeline.one_pass(inputs(device, chosen), None, chosen)
            return device.numpy(radiance)

        return work

    def later(device):
        there, history = started(device)

        def work():
            radiance, _, _ = yield from pipeline.one_pass(there, history, settings)
            return device.numpy(radiance)

        return work

    scan = {"tracer": "bitmask", "steps": 8}
    return {
        "primary rays: Embree, drawn": Case(primary),
        "G-buffer: Embree, drawn": Case(seen),
        "pixel planes and depth pyramid": Case(planes),
        "depth pyramid": Case(pyramid, 7 * pixels),
        "screen trace (rays, march, hits)": Case(march),
        "light of hits": Case(light, 2 * n),
        "horizon scan, 8 steps": Case(lambda device: light(device, **scan), 16 * 3 * n),
        "reproject": Case(again, 4 * pixels),
        "history taps (with upload)": Case(taps, 14 * pixels),
        "temporal": Case(mixed, 11 * pixels),
        "diffuse filter, 16 taps": Case(filtered, 16 * 5 * n),
        "upsample from half": Case(upsampled, 21 * n),
        "SSGI frame": Case(frame),
        "SSGI frame, half resolution": Case(lambda device: frame(device, full_resolution=False)),
        "SSGI frame, bitmask, 8 steps": Case(lambda device: frame(device, **scan)),
        "SSGI pass with history": Case(later),
    }


def smooth(geometry: Geometry, camera) -> dict[str, Case]:
    """The joint bilateral filter over an image in memory."""
    full = tiles.finish(g_buffer(Tracer(geometry), Screen(camera)))
    value = np.random.default_rng(0).random(full.position.shape, np.float32)

    footprint = smoothing.pixel_footprint(full.position, full.normal)
    h, w = full.depth.shape

    def one(device):
        images = zip((value, full.position, full.normal, footprint), (3, 3, 3, 1))
        images = [device.array(*image) for image in images]

        def tile(rows: slice):
            return device.run(bilateral, *images, 2, None, rows)

        return lambda: device.each(tile, h, max(8, (1 << 15) // w))

    def three(device):
        return lambda: smoothing.smooth(value, full.position, full.normal, 3, None, device)

    # Each invocation reads ten rows of five taps for six pixels.
    reads = 50 / 6 * 3 * full.depth.size
    return {
        "bilateral, a pass": Case(one, reads),
        "bilateral filter, 3 passes, there and back": Case(three, 3 * reads),
    }


def volume() -> dict[str, Case]:
    """Light propagation volumes: 64³ cells, and 32³, whose look-up is by a million points."""
    rng = np.random.default_rng(0)

    def steps(cells: int):
        front = rng.random((4, cells, cells, cells, 3), np.float32)
        walls = rng.random((3, cells, cells, cells), np.float32)
        settings = LpvSettings(propagation="flat", iterations=8)
        return lambda device: lambda: flat.spread(front, settings, walls, None, device)

    def look(device):
        shape = (32, 32, 32)
        values = device.array(rng.random((32**3, 4, 3), np.float32), 3)
        local, share = device.array(rng.random((ITEMS, 3), np.float32) * 32, 3), device.array(np.ones(ITEMS), 1)

        def tile(part: slice):
            return device.run(trilinear, values, local[part], shape, share[part])

        return lambda: device.each(tile, ITEMS, 1 << 13)

    def inject(device):
        cell, light = rng.integers(0, 32**3, 1 << 18), device.array(rng.random((1 << 18, 3), np.float32), 3)

        def all_(_):
            return device.run(summed, cell, device.run(coefficients, light, light), 32**3)

        return lambda: device.each(all_, 1, 1)

    return {
        "LPV, 8 steps, 32³": Case(steps(32), 8 * 6 * 5 * 32**3),
        "LPV, 8 steps, 64³": Case(steps(64), 8 * 6 * 5 * 64**3),
        "LPV look-up": Case(look, 34 * ITEMS),
        "LPV injection": Case(inject),
    }


def gathered(gpu: GpuDevice) -> dict[str, Case]:
    """Gathering from lights, there and back, without rays; interpolation; rays alone."""
    return {
        name: Case(lambda device, work=work: lambda: work(device), reads)
        for name, (work, reads) in gathering(gpu).items()
    }


def straight() -> dict[str, Case]:
    """The hierarchical volume without rays: from 2000 sources to 4096 cells."""
    rng = np.random.default_rng(1)
    middles, centre = rng.random((4096, 3), np.float32), rng.random((2000, 3), np.float32)
    vector, rest = sharpened(coefficients(rng.random((2000, 3), np.float32), centre))
    sent = centre, vector, rest, rest.mean(-1) + np.float32(0.1), centre[:, None].repeat(4, 1), 0.0, np.inf, 0.05

    def on(device):
        there = device.array(middles, 3)
        return lambda: device.each(lambda part: device.run(arriving, there[part], *sent), 4096, 64)

    return {"LPV, 2000 sources to 4096 cells": Case(on, 5 * 4096 * 2000)}


def ceilings(gpu: GpuDevice) -> dict[str, float]:
    """What the device does at most: texels read [1/s], memory moved [B/s], operations [1/s]."""
    values, result = gpu.array(np.ones((ITEMS, 4), np.float32), 4), gpu.empty((ITEMS, 4), 4)

    def seconds(name: str, output: str, defines: dict[str, int]) -> float:
        def once() -> float:
            gpu.dispatch(str(HERE / f"ceiling_{name}"), ITEMS, {"values": (values, 4)}, {output: result},
                         defines=defines, steps=1 if name == "copy" else 64)  # fmt: skip
            begin = time.perf_counter()
            tiles.finish(gpu._done())
            return time.perf_counter() - begin

        once()
        return min(once() for _ in range(3))

    return {
        "texels read": 64 * ITEMS / seconds("reads", "total", {"MASK": ITEMS - 1}),
        "memory": 32 * ITEMS / seconds("copy", "copy", {}),
        "operations": 64 * 64 * ITEMS / seconds("flops", "total", {}),
    }


def timed(case: Case, gpu: GpuDevice, pairs: int, most: dict[str, float]) -> dict:
    """Both devices in turn."""
    works = {device: case.on(device) for device in (NUMPY, gpu)}
    seconds, processor = ({device: [] for device in works} for _ in range(2))
    moved, dispatch, draw = 0, gpu.dispatch, gpu.draw

    def count(inputs, *others):
        nonlocal moved
        for values in (*(v for v, _ in inputs.values()), *others):
            moved += 4 * int(np.prod(values.shape))

    def counted(source, n, inputs, outputs, *more, **settings):
        count(inputs, *outputs.values())
        return dispatch(source, n, inputs, outputs, *more, **settings)

    def counted_draw(source, size, rectangle, inputs, *more):
        picture = draw(source, size, rectangle, inputs, *more)
        count(inputs, rectangle, picture)
        return picture

    gpu.dispatch, gpu.draw = counted, counted_draw
    tiles.finish(works[gpu]())
    del gpu.dispatch, gpu.draw
    for _ in range(pairs):
        for device, work in works.items():
            begin, busy = time.perf_counter(), time.process_time()
            tiles.finish(work())
            seconds[device].append(time.perf_counter() - begin)
            processor[device].append(time.process_time() - busy)
    least = {device: min(all_) for device, all_ in seconds.items()}
    rate = (case.reads / most["texels read"] if case.reads else moved / most["memory"]) / least[gpu]
    return {
        "numpy": least[NUMPY], "gpu": least[gpu], "moved": moved, "ceiling": rate,
        "of": "reads" if case.reads else "memory",
        "ratio": statistics.median(a / b for a, b in zip(seconds[NUMPY], seconds[gpu])),
        "processor": statistics.median(a / b for a, b in zip(processor[NUMPY], processor[gpu])),
    }  # fmt: skip


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="pan")
    parser.add_argument("--size", default="960x540")
    parser.add_argument("--pairs", type=int, default=3)
    parser.add_argument("--only", default="", help="rows whose names hold this text")
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    with quiet():
        import bpy
        from gi_bake.addon.read import read_scene

        bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{a.scene}.blend"))
        core = read_scene(bpy.context.scene, bpy.context.view_layer)
        gpu, why_not = gpu_context.device("gpu")
    if why_not:
        raise SystemExit(why_not)
    geometry, camera = Geometry(core), replace(core.camera, resolution=tuple(int(n) for n in a.size.split("x")))
    rows = {**on_screen(geometry, camera), **smooth(geometry, camera), **volume(), **straight(), **gathered(gpu)}
    most = ceilings(gpu)
    report = {"device": gpu.name, "cores": os.cpu_count(), "scene": a.scene, "size": a.size, "ceilings": most}
    report["kernels"] = {name: timed(case, gpu, a.pairs, most) for name, case in rows.items() if a.only in name}
    lines = [
        f"{gpu.name}, {os.cpu_count()} cores, {a.scene} {a.size}: {most['texels read'] / 1e6:.0f} M texels read, "
        f"{most['memory'] / 1e9:.1f} GB moved, {most['operations'] / 1e9:.1f} G operations in a second", "",
        "| kernel | numpy [s] | GPU [s] | ratio | of processor time | moved [MB] | of the ceiling |",
        "|---|---|---|---|---|---|---|",
    ]  # fmt: skip
    for name, r in report["kernels"].items():
        busy = f"{r['processor']:.1f}" if gpu.software else "–"
        lines.append(f"| {name} | {r['numpy']:.3f} | {r['gpu']:.3f} | {r['ratio']:.1f} | {busy} | "
                     f"{r['moved'] / 1e6:.0f} | {r['ceiling']:.0%} of {r['of']} |")  # fmt: skip
    if a.json:
        a.json.write_text(json.dumps(report, indent=1))
    os.write(1, ("\n".join(lines) + "\n").encode())
    os._exit(0)  # Blender 4.5 may hang while it ends with a context


if __name__ == "__main__":
    main()
