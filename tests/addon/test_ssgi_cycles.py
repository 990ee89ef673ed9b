# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI against Cycles' Diffuse Indirect: by rays alone it converges to it, and mixed with the screen too."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import Job, bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.ssgi.settings import SsgiSettings

SIDE, REFERENCE = 48, 1536


def smooth(depth):
    """Pixels whose depth is within 5 % of their neighbours': what lies on silhouettes is another thing in each."""
    step = [np.abs(np.diff(np.log(depth), axis=a)) > 0.05 for a in (0, 1)]
    jump = np.zeros(depth.shape, bool)
    jump[1:] |= step[0]
    jump[:-1] |= step[0]
    jump[:, 1:] |= step[1]
    jump[:, :-1] |= step[1]
    return ~jump


def indirect(**settings):
    job = Job("ssgi", resolution=SIDE, settings=SsgiSettings(denoise="none", antialias=1, frames=4, **settings))
    return tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job)).layers["Diffuse Indirect"]


@pytest.mark.parametrize("bounces", [1, 3])
@pytest.mark.parametrize("name", ["cornell", "sunlit_room"])
def test_rays_converge_to_cycles(sample, name, bounces):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    halves = [
        camera_reference(bpy.context.scene, bpy.context.view_layer, REFERENCE // 2, bounces, seed, (SIDE, SIDE), False)
        for seed in (21, 22)
    ]
    mask = smooth(halves[0]["Depth"][..., 0])
    a, b = (h["Diffuse Indirect"][mask] for h in halves)
    noise, reference = metrics.relmse(a, b) / 4, (a + b) / 2
    counts = (16, 64, 256)
    found = [indirect(mode="ray_traced", fallback="none", bounces=bounces, samples=n)[mask] for n in counts]
    errors = [metrics.relmse(x, reference) - noise for x in found]
    assert abs(metrics.bias(found[-1], reference)) < 0.015
    assert np.polyfit(np.log(counts), np.log(errors), 1)[0] < -0.85

    mixed = indirect(mode="mixed", bounces=bounces, samples=64)[mask]
    assert abs(metrics.bias(mixed, found[-1])) < 0.03
