# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The reference of a comparison: two renders of half the samples each, kept until something changes.

Their mean is the reference, and half their difference says how noisy it is: the variance of the mean of two is a
quarter of that of their difference.
"""

import hashlib
import json
import time
import zipfile
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import bpy
import numpy as np

from ...gi_core.tiles import whole, within
from ..job import Job
from .fingerprint import fingerprinting
from .reference import camera_passes, lightmap_passes, vertex_passes

# Two sequences, neither the bakes' default, so that nothing agrees by chance.
SEEDS = (7919, 7920)


@dataclass(frozen=True)
class Truth:
    """What Cycles found.

    light: name -> (h, w, c) float32, a pass of the camera image by its name, or (object, "direct" or "indirect"): its
        lightmap, (side, side, 4), or (corners, 3) at its mesh's face corners.
    noise: the same, half the difference of two renders. seconds: that rendering took. made: when, in UTC.
    kept: whether it is of an earlier comparison. samples: of both renders together. terms: how it was rendered.
    """

    light: dict[str | tuple[str, str], np.ndarray]
    noise: dict[str | tuple[str, str], np.ndarray]
    seconds: float
    made: str
    kept: bool
    terms: dict


def truth_in_steps(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    job: Job,
    resolution: tuple[int, int],
    maps: dict[str, tuple[str, int]],
    samples: int,
    folder: Path,
    go: int = 0,
) -> Iterator[float]:
    """What Cycles makes of a job's target at the scene's current frame, at the job's bounces. A generator of progress;
    between its steps the file is as it was, and may be looked at. Returns Truth.

    resolution: (width, height) of the camera image, or of lightmaps. maps: the objects that are baked, and of each the
        UV map that its lightmap lies on, and the side of the square of texels that is its own.
    samples: of Cycles for each pixel, texel or vertex, at least 2. folder: FOLDER/reference.npz is taken where it is of
        the same scene and terms, and is written where it is not. go: as of `camera_passes`.
    Raises RuntimeError and ValueError where Cycles refuses, and where the scene was changed between steps.
    """
    half = max(1, (samples + 1) // 2)
    terms = {
        "renderer": f"Cycles, Blender {bpy.app.version_string}", "device": "CPU", "samples": 2 * half,
        "bounces": job.settings.bounces, "seeds": SEEDS, "clamping": 0, "denoising": "none",
        "antialias": job.settings.antialias > 1 if job.target == "image" else False,
        "resolution": resolution,
    }  # fmt: skip
    target = "corners" if job.target == "vertices" else job.target
    asked = {**terms, "target": target, "maps": maps, "layer": view_layer.name,
             "light": [kind for kind in ("direct", "indirect") if job.wants(kind)]}  # fmt: skip
    seen = yield from fingerprinting(scene, view_layer)
    key = hashlib.sha256(f"{seen} {json.dumps(asked)}".encode()).hexdigest()
    path = Path(folder) / "reference.npz"
    if found := _read(path, key):
        return Truth(*found, True, terms)
    begin = time.perf_counter()
    work = [_rendered(scene, view_layer, job, resolution, maps, half, seed, go) for seed in SEEDS]
    one = yield from within(0, 0.5, work[0])
    other = yield from within(0.5, 1, work[1])
    if (yield from within(1, 1, fingerprinting(scene, view_layer))) != seen:
        raise RuntimeError("The scene was changed while Cycles rendered it: compare again")
    light = {name: (one[name] + other[name]) / 2 for name in one}
    noise = {name: (one[name] - other[name]) / 2 for name in one}
    # Where surfaces lie is no matter of noise, and the mean of two places is none.
    light |= {name: one[name] for name in ("Position", "Depth") if name in one}
    found = light, noise, time.perf_counter() - begin, datetime.now(UTC).strftime("%Y-%m-%d %H:%M UTC")
    _write(path, key, *found)
    return Truth(*found, False, terms)


truth = whole(truth_in_steps)


def _rendered(scene, view_layer, job, resolution, maps, samples, seed, go) -> Iterator[float]:
    """A generator of progress; returns the light."""
    terms = {"samples": samples, "bounces": job.settings.bounces, "seed": seed, "go": go}
    if job.target == "image":
        antialias = job.settings.antialias > 1
        return (yield from camera_passes(scene, view_layer, resolution=resolution, antialias=antialias, **terms))
    found, kinds = {}, [kind for kind in ("direct", "indirect") if job.wants(kind)]
    for k, kind in enumerate(kinds):
        if job.target == "lightmap":
            uvs, sides = ({name: each[k] for name, each in maps.items()} for k in (0, 1))
            work = lightmap_passes(scene, view_layer, uvs, sides, passes=(kind.upper(),), **terms)
        else:
            work = vertex_passes(scene, view_layer, list(maps), passes=(kind.upper(),), **terms)
        baked = yield from within(k / len(kinds), (k + 1) / len(kinds), work)
        found |= {(name, kind): pixels for name, pixels in baked.items()}
    return found


def _read(path, key):
    """What was kept under a key; None where there is nothing, something else, or a file that cannot be read."""
    try:
        with np.load(path, allow_pickle=False) as file:
            about = json.loads(str(file["about"]))
            if about["key"] != key:
                return None
            names = [tuple(name) if isinstance(name, list) else name for name in about["names"]]
            light, noise = ({n: file[f"{kind}{i}"] for i, n in enumerate(names)} for kind in ("light", "noise"))
            return light, noise, about["seconds"], about["made"]
    except (OSError, ValueError, KeyError, TypeError, EOFError, zipfile.BadZipFile):
        return None


def _write(path, key, light, noise, seconds, made):
    about = json.dumps({"key": key, "names": list(light), "seconds": seconds, "made": made})
    parts = {"light": light, "noise": noise}
    arrays = {f"{kind}{i}": array for kind, found in parts.items() for i, array in enumerate(found.values())}
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_name(f".{path.name}.part")
    try:
        with part.open("wb") as file:
            np.savez(file, about=np.array(about), **arrays)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
