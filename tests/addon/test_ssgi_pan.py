# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera that travels past things that stand still: its pictures trail nothing, and hardly flicker."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.read import read_scene
from gi_bake.gi_core import metrics, ssgi, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.ssgi.frame import before
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.trace import Tracer

SIZE, FRAMES, LOOKED_AT = (80, 45), 16, (4, 16)


def change(now, then):
    """Mean absolute change of what both pictures show: of each pixel from where its surface was."""
    at, _ = before(now.buffer, then.buffer)
    h, w = now.buffer.depth.shape
    with np.errstate(invalid="ignore"):
        inside = (at[:, 0] > -0.5) & (at[:, 0] < w - 0.5) & (at[:, 1] > -0.5) & (at[:, 1] < h - 0.5)
    column, row = (np.round(np.where(inside, at[:, k], 0)).astype(int) for k in (0, 1))
    inside &= np.abs(then.buffer.depth[row, column] - np.where(inside, at[:, 2], 0)) < 0.02 * at[:, 2]
    return np.abs(now.radiance.reshape(-1, 3) - then.radiance[row, column])[inside].mean()


@pytest.mark.parametrize("mode", ["screen_space", "mixed"])
def test_a_pan_leaves_no_trail_and_does_not_flicker(sample, mode):
    bpy.ops.wm.open_mainfile(filepath=str(sample("pan")))
    settings = SsgiSettings(mode=mode, frames=1, samples=1)
    last, steady, flickering = None, [], []
    for frame in range(1, FRAMES + 1):
        bpy.context.scene.frame_set(frame)
        core = read_scene(bpy.context.scene, bpy.context.view_layer)
        tracer, camera = Tracer(Geometry(core)), replace(core.camera, resolution=SIZE)

        def still(tracer=tracer, camera=camera, history=None, **more):
            return tiles.finish(ssgi.still(tracer, camera, replace(settings, **more), history=history))

        view, noisy = still(history=last and last[0].history), still(denoise="none", seed=frame)
        if last:
            steady.append(change(view, last[0]))
            flickering.append(change(noisy, last[1]))
        last = view, noisy
        if frame not in LOOKED_AT:
            continue
        # A pixel that came into view some frames ago has as many samples as a still of that many passes.
        count, equal, standing = np.round(view.history.count), np.zeros_like(view.radiance), None
        for k in range(1, frame + 1):
            standing = still(history=standing and standing.history)
            equal[count == k] = standing.radiance[count == k]
        truth = still(mode="ray_traced", samples=512, frames=2, denoise="none", seed=99).radiance
        surface = view.buffer.surface
        error, own = (metrics.relmse(a[surface], truth[surface]) for a in (view.radiance, equal))
        assert error < 1.5 * own
    assert max(s / f for s, f in zip(steady, flickering)) < 1 / 3
