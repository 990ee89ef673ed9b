# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmaps of many objects: our bake against Cycles' `object.bake` of the same objects, both denoised alike.

    python tests/benchmarks/lightmaps.py [--scene props] [--resolution 64] [--cycles-samples 4] [--samples 4]
                                         [--interpolation 1] [--objects 60] [--reference 6] [--json FILE]

Cycles goes through the objects one after the other and builds its scene for each. Errors are measured on a few objects
(--reference of them) against two times 512 samples of Cycles. Indirect light, one bounce. Meshes that lack lightmap
UVs get them first, which no time is counted for.
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
    from gi_bake.addon.compare.reference import lightmap_reference
    from gi_bake.addon.job import Job
    from gi_bake.addon.read import read_scene
    from gi_bake.addon.write import lightmap_uvs

import numpy as np
from gi_bake.gi_core import images, metrics, surfels, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.rsm.settings import RsmSettings

SAMPLES = Path(__file__).resolve().parents[2] / "sample_blends"


def denoised(maps, geometry, uv_maps, side, passes):
    """Cycles' lightmaps through our filter."""
    out = {}
    for name, pixels in maps.items():
        points, _ = surfels.from_texels(geometry, name, uv_maps[name], (side, side))
        values = pixels[..., :3].reshape(-1, 3)[points.place]
        keep = pixels[..., 3].ravel()[points.place] > 0
        smooth = tiles.finish(images.smoothed(values[keep], points[keep], points.place[keep], (side, side), passes))
        out[name] = images.spread(smooth, points.place[keep], (side, side))
    return out


def error(maps, references, light):
    """relMSE and bias over the texels whose centre a face covers, against two references with noise of their own."""
    texels = []
    for name in maps:
        first, second = (reference[name] for reference in references)
        mask = light[name].centred & (first[..., 3] > 0)
        texels.append([image[mask][:, :3].astype(np.float64) for image in (maps[name], first, second)])
    ours, a, b = (np.concatenate(part) for part in zip(*texels))
    return {"relMSE": metrics.relmse(ours, a, b), "bias": metrics.bias(ours, (a + b) / 2)}


def pair(scene, view_layer, resolution, cycles_samples, samples, interpolation, objects, reference):
    """"GI Bake" and "Cycles" -> seconds, relMSE and bias, and how many objects were baked and compared."""
    meshes = [obj for obj in view_layer.objects if obj.type == "MESH"]
    lightmap_uvs.make(scene, view_layer, [obj.name for obj in meshes], resolution)
    # Props first: rooms and shelves come after what is baked most.
    names = [obj.name for obj in sorted(meshes, key=lambda o: (o.data.name.lower() in ("floor", "wall"), o.name))]
    names = names[:objects]
    uv_maps = {name: lightmap_uvs.chosen(bpy.data.objects[name].data) for name in names}
    settings = RsmSettings(samples=samples, interpolation=interpolation, light="indirect")
    job = Job(target="lightmap", objects=tuple(names), resolution=resolution, settings=settings)

    begin = time.perf_counter()
    result = tiles.finish(bake(scene, view_layer, job))
    our_seconds = time.perf_counter() - begin

    begin = time.perf_counter()
    cycles = lightmap_reference(scene, view_layer, uv_maps, resolution, cycles_samples, 1, 3)
    cycles_seconds = time.perf_counter() - begin

    # What is all metal has no diffuse light in Cycles.
    lit = [name for name in names if cycles[name][..., :3].any()]
    few = {name: uv_maps[name] for name in lit[:: max(1, len(lit) // reference)][:reference]}
    references = [lightmap_reference(scene, view_layer, few, resolution, 512, 1, seed) for seed in (5, 6)]
    geometry = Geometry(read_scene(scene, view_layer))
    smooth = denoised({n: cycles[n] for n in few}, geometry, few, resolution, settings.denoise_passes)
    ours = error({n: result.light[n].indirect for n in few}, references, result.light)
    theirs = error(smooth, references, result.light)
    rows = {"GI Bake": {"seconds": our_seconds, **ours}, "Cycles": {"seconds": cycles_seconds, **theirs}}
    return rows, len(names), len(few)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="props")
    parser.add_argument("--resolution", type=int, default=64)
    parser.add_argument("--cycles-samples", type=int, default=4)
    parser.add_argument("--samples", type=int, default=4)
    parser.add_argument("--interpolation", type=int, default=1)
    parser.add_argument("--objects", type=int, default=60)
    parser.add_argument("--reference", type=int, default=6)
    parser.add_argument("--json", type=Path)
    a = parser.parse_args()

    with quiet():
        bpy.ops.wm.open_mainfile(filepath=str(SAMPLES / f"{a.scene}.blend"))
        scene, view_layer = bpy.context.scene, bpy.context.view_layer
        asked = a.resolution, a.cycles_samples, a.samples, a.interpolation, a.objects, a.reference
        rows, objects, compared = pair(scene, view_layer, *asked)
    rows["GI Bake"]["settings"] = {"samples": a.samples, "interpolation": a.interpolation}
    rows["Cycles"]["settings"] = {"samples": a.cycles_samples}
    times = rows["Cycles"]["seconds"] / rows["GI Bake"]["seconds"]
    asked = {"scene": a.scene, "objects": objects, "resolution": a.resolution, "cores": os.cpu_count()}
    if a.json:
        a.json.write_text(json.dumps({**asked, **rows, "times faster": times}, indent=1))
    lines = [f"{a.scene}: {objects} lightmaps of {a.resolution}², indirect, one bounce, {os.cpu_count()} cores"]
    for name in ("GI Bake", "Cycles"):
        r = rows[name]
        lines.append(
            f"  {name:<8}{r['seconds']:8.2f} s   relMSE {r['relMSE']:.4f}   bias {r['bias']:+.2%}   {r['settings']}"
        )
    lines.append(f"  {times:.0f} times faster; errors on {compared} objects, both denoised")
    os.write(1, ("\n".join(lines) + "\n").encode())


if __name__ == "__main__":
    main()
