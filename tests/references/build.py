# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders each sample scene small with Cycles, for the tests to compare pictures with.

    python tests/references/build.py [NAME ...]

NAME.exr holds the camera's diffuse light, the mean of two renders, half their difference as "… Noise", and "Counted",
1 where a diffuse surface is. Its header says of which .blend it is.
"""

import hashlib
import os
import sys
import tempfile
from pathlib import Path

from gi_bake.addon.standard_output import quiet

with quiet():
    import bpy
    from gi_bake.addon.compare.halves import truth
    from gi_bake.addon.job import Job

from gi_bake.gi_core import exr
from gi_bake.gi_core.rsm.settings import RsmSettings

HERE = Path(__file__).resolve().parent
SAMPLES = HERE.parents[1] / "sample_blends"
SIDE, SAMPLE_COUNT, BOUNCES = 48, 1024, 1
LIGHTS = ("Diffuse Direct", "Diffuse Indirect")


def digest(name: str) -> str:
    """Of a sample's file, hexadecimal."""
    return hashlib.sha256((SAMPLES / f"{name}.blend").read_bytes()).hexdigest()


def build(name: str) -> Path:
    bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{name}.blend"))
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    size = scene.render.resolution_x, scene.render.resolution_y
    size = tuple(max(1, round(n * SIDE / max(size))) for n in size)
    # Of the centres of pixels, which everyone sees alike; the mean over a pixel that a shadow cuts is another matter.
    job = Job(settings=RsmSettings(bounces=BOUNCES, antialias=1))
    with tempfile.TemporaryDirectory() as folder:
        found = truth(scene, view_layer, job, size, {}, SAMPLE_COUNT, Path(folder))
    light = found.light
    counted = light["Diffuse Color"].any(-1)
    layers = {k: light[k] for k in LIGHTS} | {f"{k} Noise": found.noise[k] for k in LIGHTS}
    about = {"scene": digest(name), "renderer": found.terms["renderer"], "samples": str(found.terms["samples"])}
    path = HERE / f"{name}.exr"
    exr.write_layers(path, layers | {"Counted": counted.astype("f")}, metadata=about)
    return path


def main():
    for name in sys.argv[1:] or sorted(p.stem for p in SAMPLES.glob("*.blend")):
        with quiet():
            path = build(name)
        os.write(1, f"{path.name}: {path.stat().st_size >> 10} kB\n".encode())


if __name__ == "__main__":
    main()
