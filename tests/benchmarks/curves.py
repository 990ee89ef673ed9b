# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error against time of a camera image: ours and Cycles', each as it is and with Open Image Denoise.

    python tests/benchmarks/curves.py [--scenes cornell,sunlit_room] [--resolution 256] [--bounces 4]
                                      [--reference-samples 4096] [--json FILE]

Of the indirect diffuse light, against Cycles at many samples. Times are of everything, from the open file to the
picture: reading, direct light and the denoiser included, for both. Cycles' picture is denoised as ours is, on the pass
that is measured, with its own albedo and normal as guides. Pixels on silhouettes, where depth jumps, are left out.
"""

import argparse
import json
import os
import time
from pathlib import Path

from gi_bake.addon.standard_output import quiet

with quiet():
    import bpy
    from gi_bake.addon.bake import Job, bake
    from gi_bake.addon.compare.reference import camera_reference
    from gi_bake.addon.denoise import oidn

import numpy as np
from convergence import smooth_depth
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
OURS, CYCLES = (4, 8, 16, 32, 64, 128), (1, 2, 4, 8, 16, 32, 64)


def one_scene(name, resolution, bounces, reference_samples):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{name}.blend"))
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    size = scene.render.resolution_x, scene.render.resolution_y
    size = tuple(round(n * resolution / max(size)) for n in size)
    halves = [camera_reference(scene, view_layer, reference_samples // 2, bounces, seed, size) for seed in (11, 12)]
    mask = smooth_depth(halves[0]["Depth"][..., 0])
    a, b = (h["Diffuse Indirect"] for h in halves)
    truth, noise = (a + b) / 2, metrics.relmse(a[mask], b[mask]) / 4

    def row(samples, seconds, picture):
        error = metrics.relmse(picture[mask], truth[mask])
        return {
            "samples": samples,
            "seconds": seconds,
            "relMSE": error,
            "bias": metrics.bias(picture[mask], truth[mask]),
        }

    curves = {"GI Bake": [], "GI Bake, bilateral": [], "GI Bake, OIDN": [], "Cycles": [], "Cycles, OIDN": []}
    for samples in OURS:
        for label, denoise in (("", "none"), (", bilateral", "bilateral"), (", OIDN", "oidn")):
            # As many samples of lamps as of the rest, as Cycles takes them.
            settings = RsmSettings(samples=samples, light_samples=samples, bounces=bounces, denoise=denoise)
            begin = time.perf_counter()
            result = tiles.finish(bake(scene, view_layer, Job(resolution=resolution, settings=settings)))
            seconds = time.perf_counter() - begin
            curves["GI Bake" + label].append(row(samples, seconds, result.layers["Diffuse Indirect"]))
    for samples in CYCLES:
        begin = time.perf_counter()
        found = camera_reference(scene, view_layer, samples, bounces, 3, size)
        seconds = time.perf_counter() - begin
        curves["Cycles"].append(row(samples, seconds, found["Diffuse Indirect"]))
        begin = time.perf_counter()
        clean = oidn(found["Diffuse Indirect"], found["Diffuse Color"], found["Normal"])
        curves["Cycles, OIDN"].append(row(samples, seconds + time.perf_counter() - begin, clean))
    return {"curves": curves, "noise": noise, "counted": float(mask.mean()), "equal error": equal_error(curves)}


def equal_error(curves):
    """For each picture of ours that a denoiser cleaned: how many times as long denoised Cycles takes for its error.

    Between Cycles' pictures by a straight line through the logarithms; None where none of them is as good or as bad.
    """
    theirs = sorted((r["relMSE"], r["seconds"]) for r in curves["Cycles, OIDN"])
    error, seconds = np.log(np.array(theirs)).T
    # Of two pictures the better one may be the faster too.
    seconds = np.minimum.accumulate(seconds)
    ratios = []
    for label in ("GI Bake, bilateral", "GI Bake, OIDN"):
        for r in curves[label]:
            inside = error[0] <= np.log(r["relMSE"]) <= error[-1]
            there = float(np.exp(np.interp(np.log(r["relMSE"]), error, seconds))) if inside else None
            ratio = there and there / r["seconds"]
            ratios.append({"picture": f"{label}, {r['samples']} samples", **r, "Cycles": there, "times faster": ratio})
    return ratios


def lines_of(name, found, bounces):
    yield f"{name}, {bounces} bounces; the reference's own relMSE is {found['noise']:.5f}; {found['counted']:.0%} count"
    for label, rows in found["curves"].items():
        for r in rows:
            yield (
                f"  {label:<20}{r['samples']:>5} samples {r['seconds']:7.2f} s   relMSE {r['relMSE']:.5f}   "
                f"bias {r['bias']:+.2%}"
            )
    for r in found["equal error"]:
        there = "beyond Cycles' pictures" if r["Cycles"] is None else f"{r['Cycles']:.2f} s: {r['times faster']:.1f} ×"
        yield f"  at relMSE {r['relMSE']:.5f}: {r['picture']} {r['seconds']:.2f} s, Cycles with OIDN {there}"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="cornell,sunlit_room")
    parser.add_argument("--resolution", type=int, default=256)
    parser.add_argument("--bounces", type=int, default=4)
    parser.add_argument("--reference-samples", type=int, default=4096)
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    report = {"cores": os.cpu_count(), "resolution": a.resolution, "bounces": a.bounces, "scenes": {}}
    lines = []
    for name in a.scenes.split(","):
        with quiet():
            found = one_scene(name, a.resolution, a.bounces, a.reference_samples)
        report["scenes"][name] = found
        lines += lines_of(name, found, a.bounces)
    if a.json:
        a.json.write_text(json.dumps(report, indent=1))
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
