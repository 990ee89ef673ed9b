# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every sample scene with every technique, small, against Cycles' pictures in tests/references (`make references`).

A test of statistics over blocks of pixels: each block's mean may differ from Cycles' by what noise explains, on both
sides, by one pixel that an edge passes on its other side, and by what the technique leaves out; the whole picture's by
the last alone. Each block's noise is known from two renders each. Direct light is the same for all techniques and is
looked at once. What fails leaves a report in out/pictures/VERSION/.
"""

import statistics
from pathlib import Path

import bpy
import numpy as np
import OpenEXR
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.report import write_report
from gi_bake.addon.compare.subject import Subject
from gi_bake.addon.job import Job
from gi_bake.gi_core import exr, metrics, tiles
from gi_bake.gi_core.techniques import METHODS
from gi_bake.tests.references import build

EVIDENCE = Path(__file__).resolve().parents[2] / "out" / "pictures" / bpy.app.version_string.split()[0]
BLOCK = 6
# How likely one picture fails that is right.
ALPHA = 0.001
SETTINGS = {
    "rsm": {"samples": 32, "light_samples": 16, "map_resolution": 128, "denoise": "none"},
    "lpv": {"light_samples": 16, "map_resolution": 128, "cells": 32, "cascades": 1, "denoise": "none"},
    "ssgi": {"samples": 16, "light_samples": 16, "frames": 2, "denoise": "none"},
}
# By how much of its light a block, and the whole picture, may be off for what a technique leaves out, and what share of
# blocks by more. RSM and SSGI with rays leave out nothing but what is between two of their samples; LPV's light is that
# of a whole cell.
MODEL = {"rsm": (0.03, 0.025), "ssgi": (0.03, 0.025), "lpv": (0.12, 0.12)}
# Where that is more: what gloss reflects onto others is counted as if it were diffuse; a window's light is smaller than
# a cell.
MODEL_OF = {("materials", method): (known + 0.03, rest + 0.05) for method, (known, rest) in MODEL.items()}
MODEL_OF["sunlit_room", "lpv"] = 0.2, 0.12
# What share of the picture's mean counts besides in the dark.
DARK = 0.1
NAMES = sorted(p.stem for p in build.SAMPLES.glob("*.blend"))


def reference(name):
    file = build.HERE / f"{name}.exr"
    with OpenEXR.File(str(file)) as opened:
        of = opened.header()["scene"]
    assert of == build.digest(name), f"{file} is of an earlier {name}.blend: make references ARGS={name}"
    return exr.read_layers(file)


def baked(method, seed):
    settings = METHODS[method].settings(seed=seed, bounces=build.BOUNCES, antialias=1, **SETTINGS[method])
    job = Job(method=method, resolution=build.SIDE, settings=settings)
    return tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job)).layers


def blocks(image, mask, value=lambda part: part.mean(0)):
    """Means, or another value, of what counts in blocks of pixels, where it is at least a quarter: (n, c)."""
    found = []
    for row in range(0, mask.shape[0], BLOCK):
        for column in range(0, mask.shape[1], BLOCK):
            part = slice(row, row + BLOCK), slice(column, column + BLOCK)
            if mask[part].sum() >= BLOCK**2 / 4:
                found.append(value(image[part][mask[part]]))
    return np.array(found)


def share_off(ours, noise, theirs, spread, mask, known):
    """Share of blocks that are off by more than noise and what is known explain.

    ours, theirs: (h, w, 3). noise, spread: half the differences of two renders, of each side.
    """
    n = len(blocks(mask[..., None], mask))
    # Of n blocks and three channels none, by chance, but with the probability ALPHA (Šidák).
    z = statistics.NormalDist().inv_cdf(1 - (1 - (1 - ALPHA) ** (1 / (3 * n))) / 2)
    r = blocks(theirs, mask)
    deviation = np.hypot(*(_deviation(part, r, mask) for part in (noise, spread)))
    edge = blocks(theirs, mask, lambda part: np.ptp(part, axis=0) / len(part))
    allowed = known * (r + DARK * r.mean()) + z * deviation + edge
    return float((np.abs(blocks(ours, mask) - r) > allowed).any(-1).mean())


def _deviation(halves, light, mask):
    """Standard deviation of each block's mean, from half the differences of two renders: (n, c).

    The larger of two: what the block's own pixels tell, as if no pixel's noise were its neighbours', and what all
    blocks' means tell together, as a line over their light.
    """
    own = np.sqrt(blocks(halves, mask, lambda part: (part**2).mean(0) / len(part)))
    size = np.abs(blocks(halves, mask))
    line = np.polyval(np.polyfit(light.ravel(), size.ravel(), 1), light)
    # The mean size of a normal deviate is √(2/π) of its deviation.
    return np.maximum(own, np.sqrt(np.pi / 2) * np.maximum(line, size.mean() / 4))


def evidence(name, method, truth, layers, mask, off):
    """A report of what does not agree, into EVIDENCE; its page."""
    subjects = [
        Subject(k, k.split()[1].lower(), truth[k], truth[f"{k} Noise"], mask, mask, {method: layers[k]}) for k in off
    ]
    folder = EVIDENCE / f"{name} {method}"
    folder.mkdir(parents=True, exist_ok=True)
    told = {"device": "cpu", "settings": SETTINGS[method], "stages": {}, "approximated": [], "warnings": []}
    return write_report(folder, f"{name}, {method}", subjects, {method: told}, {}, {"off": str(off)})[0]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("name", NAMES)
def test_the_picture_is_cycles_own(sample, name, method):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    truth = reference(name)
    mask = truth["Counted"][..., 0] > 0
    found = [baked(method, seed) for seed in (1, 2)]
    known, rest = MODEL_OF.get((name, method), MODEL[method])
    off = {}
    for kind in build.LIGHTS if method == "rsm" else ("Diffuse Indirect",):
        ours, noise = (found[0][kind] + found[-1][kind]) / 2, (found[0][kind] - found[-1][kind]) / 2
        # Of the whole picture noise is next to nothing.
        whole = metrics.bias(ours[mask], truth[kind][mask])
        off[kind] = share_off(ours, noise, truth[kind], truth[f"{kind} Noise"], mask, known), whole
    if any(share > rest or abs(whole) > known for share, whole in off.values()):
        page = evidence(name, method, truth, found[0], mask, off)
        pytest.fail(f"share of blocks that are off, and how much the whole: {off}; look at {page}")
