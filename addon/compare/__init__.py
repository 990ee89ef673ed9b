# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake measured against Cycles: light, not beauty, direct and indirect apart, on equal terms."""

import os
import platform
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import metrics
from ..bake import Light, Result
from .reference import camera_reference, lightmap_reference, vertex_reference
from .report import Comparison, write_report

# Another sequence than the bakes' default, so that nothing agrees by chance.
_SEED = 7919


@dataclass(frozen=True)
class Report:
    """paths: files written. metrics: name of what was compared -> measure -> value. seconds: that Cycles took.

    comparisons: the pictures.
    """

    paths: tuple[Path, ...]
    metrics: dict[str, dict[str, float]]
    seconds: float
    comparisons: tuple[Comparison, ...] = ()


def compare(
    result: Result, scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, samples: int, folder: Path
) -> Report:
    """Renders with Cycles what was baked, at the same bounces, and writes FOLDER/report.html and .json.

    samples: of Cycles for each pixel, texel or vertex. The scene must be at the frame that was baked; it is left as it
        was.
    Raises RuntimeError where Cycles refuses.
    """
    job, begin = result.job, time.perf_counter()
    terms = {"samples": samples, "bounces": job.settings.bounces, "seed": _SEED}
    left_out: list[str] = []
    if job.target == "image":
        antialias = job.settings.antialias > 1
        comparisons = _image(
            result, camera_reference(scene, view_layer, resolution=_size(result), antialias=antialias, **terms)
        )
    else:
        # Cycles bakes meshes, and nothing else that has a surface.
        names = [name for name in result.light if view_layer.objects[name].type == "MESH"]
        if not names:
            raise RuntimeError(f"Cycles bakes meshes only: convert {', '.join(result.light)} to one")
        left_out = [f"{name} is no mesh: not compared" for name in result.light if name not in names]
        comparisons = []
        for kind in filter(job.wants, ("direct", "indirect")):
            if job.target == "lightmap":
                maps = {place.name: place.uv for page in result.pages for place in page.places if place.name in names}
                side = next(iter(result.light.values())).valid.shape[0]
                found = lightmap_reference(scene, view_layer, maps, side, passes=(kind.upper(),), **terms)
            else:
                found = vertex_reference(scene, view_layer, names, passes=(kind.upper(),), **terms)
            comparisons += [_light(name, kind, result.light[name], found[name]) for name in names]
    seconds = time.perf_counter() - begin
    facts = {
        "technique": job.method,
        "target": job.target,
        "scene": f"{Path(bpy.data.filepath).name}, {scene.name}, frame {scene.frame_current}",
        "device": result.device,
        "processor": f"{os.cpu_count()} cores, {platform.machine()}",
        "seconds": sum(result.stages.values()),
        "stages": result.stages,
        "settings": asdict(job.settings),
        "reference": {
            "renderer": f"Cycles, Blender {bpy.app.version_string}", **terms, "clamping": 0, "denoising": "none",
            "seconds": seconds,
        },
        "approximated": list(result.approximated),
        "warnings": [*result.warnings, *left_out],
    }  # fmt: skip
    folder.mkdir(parents=True, exist_ok=True)
    paths = write_report(
        folder, f"GI Bake and Cycles: {Path(bpy.data.filepath).stem or scene.name}", comparisons, facts
    )
    return Report(paths, {c.name: c.metrics for c in comparisons}, seconds, tuple(comparisons))


def _size(result: Result) -> tuple[int, int]:
    height, width = result.layers["Combined"].shape[:2]
    return width, height


def _image(result: Result, reference: dict[str, np.ndarray]) -> list[Comparison]:
    names = ("Diffuse Indirect", "Diffuse Direct")
    comparisons = [_comparison(name, result.layers[name], reference[name], None) for name in names]
    # Cycles sees more points of a pixel, and of a silhouette's it may be the only one that meets what is glossy.
    shown = result.layers.get("Glossy Color", np.zeros((1, 1, 3))).any(-1)
    if shown.any():
        names = ("Glossy Indirect", "Glossy Direct")
        comparisons += [_comparison(name, result.layers[name], reference[name], shown) for name in names]
    return comparisons


def _light(name: str, kind: str, light: Light, reference: np.ndarray) -> Comparison:
    ours = light.direct if kind == "direct" else light.indirect
    valid = light.centred
    if reference.shape[-1] == 4:
        # Cycles bakes the texels whose centre a face covers; the others it leaves to the margin.
        valid = valid & (reference[..., 3] > 0)
    if ours.ndim == 2:
        # Vertices as an image of one row.
        ours, reference, valid = ours[None], reference[None], valid[None]
    return _comparison(f"{name}, {kind}", ours, reference[..., :3], valid)


def _comparison(name: str, ours: np.ndarray, reference: np.ndarray, mask: np.ndarray | None) -> Comparison:
    return Comparison(name, ours, reference, mask, metrics.measure(ours, reference, mask))
