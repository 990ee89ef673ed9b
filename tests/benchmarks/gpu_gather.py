# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gathering on the graphics card beside numpy: seconds, ratio, bytes moved, as a table.

python tests/benchmarks/gpu_gather.py [--json FILE] [--points N]

Both are timed in turns, and the ratio is the median of the turns': what else a machine does hits both. The ratio of
processor time says on a driver in software what the ratio would be on a quiet machine. Shaders are compiled before.
"""

import argparse
import json
import os
import statistics
import time
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import numpy as np
from gi_bake.addon import gpu_context
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.gathering import Every, Strided, gather
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_rays import GpuRays
from gi_bake.gi_core.kernels.lattice import agreeing, mixed, rows_of
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.scene import ColorSource, Instance, Material, Mesh, Scene
from gi_bake.gi_core.surfels import TILE, Surfels
from gi_bake.gi_core.tiles import finish
from gi_bake.gi_core.trace import Tracer
from gi_bake.gi_core.vpls import Vpls

_TURNS = 3


def unit(rng, n: int) -> np.ndarray:
    v = rng.normal(size=(n, 3)).astype(np.float32)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def gathers(points: int) -> dict[str, Callable]:
    """By what is timed: a function of a device."""
    rng = np.random.default_rng(1)

    def some(n):
        return rng.uniform(-1, 1, (n, 3)).astype(np.float32), unit(rng, n)

    position, normal = some(points)
    here = Surfels(position, normal, normal, 0 * normal, 0 * normal, np.arange(points))

    def lights(n):
        position, axis = some(n)
        return Vpls(position, position, axis, rng.random((n, 3), np.float32), np.full(n, 1e-3, np.float32))

    def gathering(vpls, pattern, candidates=1):
        def work(device):
            tracer = SimpleNamespace(device=device, on_card=None)
            return finish(gather(tracer, here, vpls, pattern, False, candidates=candidates))

        return work

    few, cloud = lights(1024), lights(1 << 17)
    return {
        "gather, all of 1024 lights": gathering(few, Every(len(few))),
        "gather, flux, 64 samples": gathering(cloud, Strided.of(cloud, Samples(64), 1)),
        "gather, flux, 64 samples of 4 candidates": gathering(cloud, Strided.of(cloud, Samples(64), 1, 4), 4),
    }


def interpolation(side: int) -> Callable:
    """Agreement with the lattice and the mix, at every pixel of a bumpy square."""
    rng = np.random.default_rng(2)
    n, size, step = side * side, (side, side), 4
    place = np.arange(n)
    position = np.stack([place % side, place // side, 0.1 * rng.random(n)], -1).astype(np.float32)
    normal = (unit(rng, n) * 0.1 + np.float32([0, 0, 1])).astype(np.float32)
    light, span = rng.random((n, 3), np.float32), np.full(n, step, np.float32)

    def work(device):
        points = place, device.array(position, 3), device.array(normal, 3), span, rows_of(place, size, step)
        found = finish(device.each(lambda part: device.run(agreeing, *points, size, step, part), n, TILE))
        return device.numpy(finish(device.each(lambda part: device.run(mixed, light, *found[:2], part), n, TILE)))

    return work


def shadow_rays(gpu, n: int) -> tuple[Callable, int]:
    """Shadow rays all over a bumpy plate, by Embree on all cores and in GLSL; the plate's triangles."""
    k = 300
    x, y = np.meshgrid(np.linspace(0, 1, k), np.linspace(0, 1, k))
    vertices = np.dstack([x, y, 0.1 * np.sin(40 * x) * np.cos(43 * y)]).reshape(-1, 3).astype(np.float32)
    i = np.arange(k * k).reshape(k, k)
    a, b, c, d = (q.ravel() for q in (i[:-1, :-1], i[:-1, 1:], i[1:, 1:], i[1:, :-1]))
    triangles = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).astype(np.int32)
    normals, slots = np.zeros((len(triangles), 3, 3), np.float32), np.zeros(len(triangles), np.int32)
    mesh = Mesh("bumps", vertices, triangles, normals, slots)
    white = Material("white", ColorSource(np.ones(3, np.float32)))
    geometry = Geometry(Scene((mesh,), (Instance("bumps", 0, np.eye(4), (0,)),), (white,)))
    tracer, card = Tracer(geometry), GpuRays(geometry, gpu)
    rng = np.random.default_rng(3)
    origins = rng.uniform((0, 0, -0.1), (1, 1, 0.3), (n, 3)).astype(np.float32)
    directions, far = unit(rng, n), np.ones(n, np.float32)

    def work(device):
        if device is not NUMPY:
            return card.occluded(origins, directions, far)
        return finish(device.each(lambda p: tracer.occluded(origins[p], directions[p], far[p]), n, TILE))

    return work, len(triangles)


def compared(work: Callable, gpu) -> dict[str, float]:
    """Medians over turns of numpy and the card."""

    def seconds(device):
        begin, busy = time.perf_counter(), time.process_time()
        work(device)
        return time.perf_counter() - begin, time.process_time() - busy

    work(gpu)
    turns = []
    for _ in range(_TURNS):
        moved = gpu.moved
        (slow, slow_busy), (fast, fast_busy) = seconds(NUMPY), seconds(gpu)
        turns.append((slow, fast, slow / fast, slow_busy / fast_busy, (gpu.moved - moved) / 1e6))
    names = "numpy [s]", "GPU [s]", "ratio", "of processor time", "moved [MB]"
    return dict(zip(names, (statistics.median(column) for column in zip(*turns))))


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--json", type=Path)
    arguments.add_argument("--points", type=int, default=1 << 16)
    asked = arguments.parse_args()
    gpu, why_not = gpu_context.device("gpu")
    if why_not:
        raise SystemExit(why_not)
    works = gathers(asked.points)
    works["interpolation, agreement and mix, 512 × 512"] = interpolation(512)
    rays, triangles = shadow_rays(gpu, 1 << 19)
    works[f"rays: Embree (for numpy), GLSL, {triangles} triangles, 2¹⁹ shadow rays"] = rays
    rows = {name: compared(work, gpu) for name, work in works.items()}
    if asked.json:
        asked.json.write_text(json.dumps({"device": gpu.name, "cores": os.cpu_count(), "rows": rows}, indent=1))
    columns = list(next(iter(rows.values())))
    lines = [f"{asked.points} points, {os.cpu_count()} cores, {gpu.name}", ""]
    lines += ["| | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    lines += [f"| {name} | " + " | ".join(f"{v:.3g}" for v in row.values()) + " |" for name, row in rows.items()]
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
