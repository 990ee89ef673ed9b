# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera image's error against time, RSM beside Cycles, both with Open Image Denoise.

    python tests/benchmarks/camera.py [--scene cornell] [--resolution 256] [--bounces 4] [--samples 4,8,16,64]
                                      [--reference-samples 1024] [--runs 3] [--json FILE]

Both work out direct and reflected light with as many samples of each for a pixel, and the denoiser is told the same of
albedo and normal. Times are from the open file to the picture, the least of several runs, which take turns; seconds of
all cores together stand beside and tell more where other work runs. The error is relMSE of Diffuse Indirect against two
of Cycles' images with seeds of their own, as the mean product of both differences: the references' noise is not in it.
"""

import argparse
import json
import os
import time
from pathlib import Path

from gi_bake.addon.standard_output import quiet

with quiet():
    import bpy
    from gi_bake.addon.bake import bake
    from gi_bake.addon.compare.curves import DENOISED, time_at
    from gi_bake.addon.compare.reference import camera_reference
    from gi_bake.addon.denoise import oidn
    from gi_bake.addon.job import Job

import numpy as np
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
OURS = "RSM, OIDN"


def race(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    side: int,
    bounces: int,
    counts: tuple[int, ...],
    reference: int,
    runs: int,
) -> dict[str, list[dict]]:
    """OURS and DENOISED -> a row for each of so many samples: "samples", "seconds", "processor [s]", "relmse", "bias".

    reference: samples of both references together.
    """
    render = scene.render
    size = render.resolution_x, render.resolution_y
    size = tuple(max(1, round(n * side / max(size))) for n in size)

    def ours(count):
        settings = RsmSettings(bounces=bounces, samples=count, light_samples=count, denoise="oidn")
        return tiles.finish(bake(scene, view_layer, Job(resolution=side, settings=settings))).layers["Diffuse Indirect"]

    def cycles(count):
        passes = camera_reference(scene, view_layer, count, bounces, 7, size)
        albedo = np.clip(passes["Diffuse Color"], 0, 1)
        return oidn(passes["Diffuse Indirect"], albedo, passes["Normal"])

    a, b = (
        np.float64(camera_reference(scene, view_layer, -(-reference // 2), bounces, seed, size)["Diffuse Indirect"])
        for seed in (11, 12)
    )
    found = {OURS: [], DENOISED: []}
    for count in counts:
        rows = {label: {"samples": count, "seconds": np.inf, "processor [s]": np.inf} for label in found}
        for _ in range(runs):
            for label, work in ((OURS, ours), (DENOISED, cycles)):
                begin, busy, row = time.perf_counter(), time.process_time(), rows[label]
                picture = np.float64(work(count))
                row["seconds"] = min(row["seconds"], time.perf_counter() - begin)
                row["processor [s]"] = min(row["processor [s]"], time.process_time() - busy)
                row["relmse"], row["bias"] = metrics.relmse(picture, a, b), metrics.bias(picture, (a + b) / 2)
        for label, row in rows.items():
            found[label].append(row)
    return found


def sooner(
    found: dict[str, list[dict]], clock: str = "processor [s]", ours: str = OURS, theirs: str = DENOISED
) -> list[float | None]:
    """For each of our pictures how many times as long theirs take to its error, by the clock's column; None where none
    of theirs is so near."""
    curves = {k: [{**row, "seconds": row[clock], "relmse": max(row["relmse"], 1e-9)} for row in rows]
              for k, rows in found.items()}  # fmt: skip
    there = [time_at(curves[theirs], row["relmse"]) for row in curves[ours]]
    return [seconds and seconds / row["seconds"] for seconds, row in zip(there, curves[ours])]


def verdict(found: dict[str, list[dict]], clock: str = "processor [s]") -> str:
    """At which errors who is sooner, in words: at those of all pictures that both curves reach."""
    pairs = [(row["relmse"], ratio) for row, ratio in zip(found[OURS], sooner(found, clock)) if ratio]
    back = sooner(found, clock, DENOISED, OURS)
    pairs += [(row["relmse"], 1 / ratio) for row, ratio in zip(found[DENOISED], back) if ratio]
    said = {
        "RSM": ", ".join(f"{error:.5f} ({ratio:.2f} ×)" for error, ratio in sorted(pairs) if ratio > 1),
        "Cycles": ", ".join(f"{error:.5f} ({1 / ratio:.2f} ×)" for error, ratio in sorted(pairs) if ratio <= 1),
    }
    return "; ".join(f"{who} is sooner at relMSE {errors or 'none'}" for who, errors in said.items())


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="cornell")
    parser.add_argument("--resolution", type=int, default=256)
    parser.add_argument("--bounces", type=int, default=4)
    parser.add_argument("--samples", default="4,8,16,64")
    parser.add_argument("--reference-samples", type=int, default=1024)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{a.scene}.blend"))
        counts = tuple(int(n) for n in a.samples.split(","))
        context = bpy.context
        found = race(context.scene, context.view_layer, a.resolution, a.bounces, counts, a.reference_samples, a.runs)
    lines = [f"{a.scene}, {a.resolution} px, {a.bounces} bounces, {os.cpu_count()} cores"]
    for label, rows in found.items():
        times = sooner(found) if label == OURS else [None] * len(rows)
        for row, ratio in zip(rows, times):
            lines.append(
                f"  {label:<13}{row['samples']:>4} samples {row['seconds']:7.2f} s, of all cores "
                f"{row['processor [s]']:6.2f} s   relMSE {row['relmse']:.5f}   bias {row['bias']:+.2%}"
                + (f"   Cycles takes {ratio:.2f} × as long" if ratio else "")
            )
    said = {clock: verdict(found, clock) for clock in ("seconds", "processor [s]")}
    lines += [f"  by {clock}: {text}" for clock, text in said.items()]
    if a.json:
        asked = {k: v for k, v in vars(a).items() if k != "json"}
        a.json.write_text(json.dumps({"cores": os.cpu_count(), **asked, "curves": found, "verdict": said}, indent=1))
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
