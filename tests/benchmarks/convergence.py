# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How the error of a camera image falls with samples, without a denoiser, and its bias at several bounces.

    python tests/benchmarks/convergence.py [--scenes cornell,sunlit_room,emissive] [--resolution 128]
                                           [--reference-samples 4096] [--json FILE]

Against Cycles' Diffuse Indirect at the same bounces; pixels on silhouettes are left out. Cycles renders half the
samples twice, and the error is the mean product of our differences to both: their noise, which is not ours, is not in
it. It stands beside.
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
    from gi_bake.addon.compare.edges import smooth
    from gi_bake.addon.compare.reference import camera_reference
    from gi_bake.addon.job import Job

import numpy as np
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"
COUNTS = (16, 64, 256, 1024)

# Points seen in a pixel along each axis: with two, how light changes within a pixel where surfaces meet, which is not
# what is measured, is most of what is left of the error at a thousand samples.
ANTIALIAS = 4


def measured(scene, view_layer, job, halves, mask):
    begin = time.perf_counter()
    layers = tiles.finish(bake(scene, view_layer, job)).layers
    seconds = time.perf_counter() - begin
    ours, a, b = (np.float64(image[mask]) for image in (layers["Diffuse Indirect"], *halves))
    return {"seconds": seconds, "relMSE": metrics.relmse(ours, a, b), "bias": metrics.bias(ours, (a + b) / 2)}


def one_scene(name, resolution, reference_samples, counts=COUNTS):
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{name}.blend"))
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    size = scene.render.resolution_x, scene.render.resolution_y
    size = tuple(round(n * resolution / max(size)) for n in size)

    def cycles(bounces, samples):
        halves = [camera_reference(scene, view_layer, samples // 2, bounces, seed, size) for seed in (11, 12)]
        a, b = (h["Diffuse Indirect"] for h in halves)
        mask = smooth(halves[0]["Position"], halves[0]["Normal"], halves[0]["Depth"][..., 0])
        return (a, b), metrics.relmse(a[mask], b[mask]) / 4, mask

    reference, noise, mask = cycles(1, reference_samples)
    rows = {}
    for count in counts:
        job = Job(resolution=resolution, settings=RsmSettings(samples=count, denoise="none", antialias=ANTIALIAS))
        rows[count] = measured(scene, view_layer, job, reference, mask)
    # The slope of a straight line through log error over log samples.
    own = [max(r["relMSE"], 1e-9) for r in rows.values()]
    slope = float(np.polyfit(np.log(counts), np.log(own), 1)[0])
    deep, deep_noise, _ = cycles(3, reference_samples)
    job = Job(resolution=resolution, settings=RsmSettings(samples=256, denoise="none", antialias=ANTIALIAS, bounces=3))
    three = measured(scene, view_layer, job, deep, mask) | {"noise": deep_noise}
    return {
        "samples": rows,
        "slope": slope,
        "noise": noise,
        "three bounces": three,
        "counted": float(mask.mean()),
    }


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", default="cornell,sunlit_room,emissive")
    parser.add_argument("--resolution", type=int, default=128)
    parser.add_argument("--reference-samples", type=int, default=4096)
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()
    report, lines = {"cores": os.cpu_count(), "resolution": a.resolution, "scenes": {}}, []
    for name in a.scenes.split(","):
        with quiet():
            found = one_scene(name, a.resolution, a.reference_samples)
        report["scenes"][name] = found
        lines.append(
            f"{name}, {a.resolution} px, one bounce; Cycles' {a.reference_samples} samples have relMSE "
            f"{found['noise']:.5f}; {found['counted']:.0%} of pixels count"
        )
        for count, r in found["samples"].items():
            lines.append(
                f"  {count:>5} samples {r['seconds']:7.2f} s   relMSE {r['relMSE']:.5f}   bias {r['bias']:+.2%}"
            )
        r = found["three bounces"]
        lines.append(f"  error falls as samples^{found['slope']:.2f}")
        lines.append(
            f"  three bounces, 256 samples {r['seconds']:7.2f} s   relMSE {r['relMSE']:.5f}   bias {r['bias']:+.2%}"
        )
    if a.json:
        a.json.write_text(json.dumps(report, indent=1))
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
