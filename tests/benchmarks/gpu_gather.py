# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gathering on the graphics card beside numpy: seconds, ratio, bytes moved, as a table.

python tests/benchmarks/gpu_gather.py [--json FILE] [--points N]

Both are timed in turns, and the ratio is the median of the turns': what else a machine does hits both. What is warm
counts: shaders are compiled before.
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
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.surfels import Surfels
from gi_bake.gi_core.tiles import finish
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
            return finish(gather(SimpleNamespace(device=device), here, vpls, pattern, False, candidates=candidates))

        return work

    few, cloud = lights(1024), lights(1 << 17)
    return {
        "gather, all of 1024 lights": gathering(few, Every(len(few))),
        "gather, flux, 64 samples": gathering(cloud, Strided.of(cloud, Samples(64), 1)),
        "gather, flux, 64 samples of 4 candidates": gathering(cloud, Strided.of(cloud, Samples(64), 1, 4), 4),
    }


def compared(work: Callable, gpu) -> dict[str, float]:
    """Medians over turns of numpy and the card."""

    def seconds(device):
        begin = time.perf_counter()
        work(device)
        return time.perf_counter() - begin

    work(gpu)
    turns = []
    for _ in range(_TURNS):
        moved = gpu.moved
        slow, fast = seconds(NUMPY), seconds(gpu)
        turns.append((slow, fast, slow / fast, gpu.moved - moved))
    slow, fast, ratio, moved = (statistics.median(column) for column in zip(*turns))
    return {"numpy [s]": slow, "GPU [s]": fast, "ratio": ratio, "moved [MB]": moved / 1e6}


def main():
    arguments = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    arguments.add_argument("--json", type=Path)
    arguments.add_argument("--points", type=int, default=1 << 16)
    asked = arguments.parse_args()
    gpu, why_not = gpu_context.device("gpu")
    if why_not:
        raise SystemExit(why_not)
    rows = {name: compared(work, gpu) for name, work in gathers(asked.points).items()}
    if asked.json:
        asked.json.write_text(json.dumps({"device": gpu.name, "cores": os.cpu_count(), "rows": rows}, indent=1))
    columns = list(next(iter(rows.values())))
    lines = [f"{asked.points} points, {os.cpu_count()} cores, {gpu.name}", ""]
    lines += ["| | " + " | ".join(columns) + " |", "|---" * (len(columns) + 1) + "|"]
    lines += [f"| {name} | " + " | ".join(f"{v:.3g}" for v in row.values()) + " |" for name, row in rows.items()]
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
