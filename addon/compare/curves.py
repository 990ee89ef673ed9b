# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time: techniques at several budgets, Cycles at several sample counts, as it is and denoised.

All on one machine, one after the other. Times are of everything from the open file to the picture: reading, direct
light and the denoiser, for both. The error is relMSE of the camera's Diffuse Indirect.
"""

import time
from collections.abc import Iterator, Sequence
from dataclasses import replace

import bpy
import numpy as np

from ...gi_core import metrics
from ...gi_core.tiles import finish
from ..bake import bake
from ..denoise import oidn
from ..job import Job
from ..result import Result
from .reference import camera_reference

CYCLES, DENOISED = "Cycles", "Cycles, OIDN"
# What a technique's time buys, and how it is multiplied.
BUDGETS = {"rsm": ("samples", "light_samples"), "ssgi": ("samples", "light_samples"), "lpv": ("cells",)}
SHARES = (1 / 16, 1 / 4)
CYCLES_SAMPLES = (1, 4, 16, 64, 256)
_SEED = 104729


def jobs(job: Job, shares: Sequence[float] = SHARES) -> Iterator[tuple[str, Job]]:
    """The job at shares of its budget, the smallest first, each with its budget in words; none twice."""
    names = BUDGETS[job.method]
    bounds = type(job.settings).__dataclass_fields__
    told = {budget_of(job)}
    for share in sorted(shares):
        values = {n: round(getattr(job.settings, n) * share) for n in names}
        values = {n: min(max(v, bounds[n].metadata["low"]), bounds[n].metadata["high"]) for n, v in values.items()}
        cut = replace(job, settings=replace(job.settings, **values))
        if (budget := budget_of(cut)) not in told:
            told.add(budget)
            yield budget, cut


def budget_of(job: Job) -> str:
    """What a job may spend, in words."""
    name = BUDGETS[job.method][0]
    return f"{getattr(job.settings, name)} {name}"


def curves(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    results: dict[str, Result],
    reference: np.ndarray,
    mask: np.ndarray,
    shares: Sequence[float] = SHARES,
    samples: Sequence[int] = CYCLES_SAMPLES,
) -> dict[str, list[dict]]:
    """Label -> rows of "budget", "seconds", "relmse", "bias"; techniques by their labels, then CYCLES and DENOISED.

    results: of the camera image at one resolution and one number of bounces; each is the last point of its curve, which
        smaller budgets come before. reference: (h, w, 3), mask: (h, w).
    """
    found = {label: [] for label in (*results, CYCLES, DENOISED)}

    def add(label, budget, seconds, picture):
        x, r = (i[mask].astype(np.float64) for i in (picture, reference))
        found[label].append(
            {"budget": budget, "seconds": seconds, "relmse": metrics.relmse(x, r), "bias": metrics.bias(x, r)}
        )

    for label, given in results.items():
        for budget, cut in jobs(given.job, shares):
            begin = time.perf_counter()
            result = finish(bake(scene, view_layer, cut))
            add(label, budget, time.perf_counter() - begin, result.layers["Diffuse Indirect"])
        add(label, budget_of(given.job), sum(given.stages.values()), given.layers["Diffuse Indirect"])
    settings = next(iter(results.values())).job.settings
    size = reference.shape[1], reference.shape[0]
    for count in samples:
        begin = time.perf_counter()
        passes = camera_reference(scene, view_layer, count, settings.bounces, _SEED, size, settings.antialias > 1)
        seconds = time.perf_counter() - begin
        add(CYCLES, f"{count} samples", seconds, passes["Diffuse Indirect"])
        begin = time.perf_counter()
        clean = oidn(passes["Diffuse Indirect"], passes["Diffuse Color"], passes["Normal"])
        add(DENOISED, f"{count} samples", seconds + time.perf_counter() - begin, clean)
    return found


def against_cycles(found: dict[str, list[dict]], noise: float = 0.0) -> list[dict]:
    """For each technique's best picture and each of Cycles' curves: "times faster" at equal error, and "times better"
    at equal time, the ratio of the errors. None where Cycles' pictures do not reach so far: no curve is drawn on.

    noise: relMSE of the reference itself, which is taken off all errors first. "doubtful": more than half of what was
        measured is noise.
    """
    rows = []
    found = {k: [{**r, "relmse": max(r["relmse"] - noise, 1e-9)} for r in v] for k, v in found.items()}
    for label, ours in found.items():
        if label in (CYCLES, DENOISED):
            continue
        best = min(ours, key=lambda r: r["relmse"])
        for other in (CYCLES, DENOISED):
            there = time_at(found[other], best["relmse"])
            then = error_at(found[other], best["seconds"])
            rows.append({
                "technique": label, **best, "against": other, "doubtful": best["relmse"] < noise,
                "times faster": there and there / best["seconds"],
                "times better": then and best["relmse"] and then / best["relmse"],
            })  # fmt: skip
    return rows


def time_at(rows: list[dict], error: float) -> float | None:
    """Seconds [s] that a curve takes to an error at most, straight between pictures in logarithms; None where none of
    them is so near."""
    errors, seconds = _front(rows)
    if error > errors[0]:
        return float(seconds[0])
    return _between(error, errors[::-1], seconds[::-1])


def error_at(rows: list[dict], seconds: float) -> float | None:
    """relMSE that a curve has after so many seconds; None before its first picture and after its last."""
    errors, times = _front(rows)
    return _between(seconds, times, errors)


def _front(rows):
    """Errors and seconds of the pictures that no other beats in both, by time."""
    front = []
    for row in sorted(rows, key=lambda r: r["seconds"]):
        if not front or row["relmse"] < front[-1]["relmse"]:
            front.append(row)
    return tuple(np.array([r[key] for r in front]) for key in ("relmse", "seconds"))


def _between(x, xs, ys):
    if not xs[0] <= x <= xs[-1] or x <= 0:
        return None
    return float(np.exp(np.interp(np.log(x), np.log(xs), np.log(ys))))
