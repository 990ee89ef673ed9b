# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What mixed finds is what rays through the scene find, in each part of the picture: at shadows' edges, on silhouettes,
in creases, far from the camera."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.read import read_scene
from gi_bake.gi_core import ssgi, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.trace import Tracer

SIDE, BLOCK, SEEDS = 64, 8, 3


def blocks(pictures):
    """Means over blocks of pixels: (k, SIDE, SIDE) -> (k, SIDE / BLOCK, SIDE / BLOCK)."""
    n = SIDE // BLOCK
    return pictures.reshape(-1, n, BLOCK, n, BLOCK).mean((2, 4))


@pytest.mark.parametrize("name", ["cornell", "sunlit_room"])
def test_mixed_is_ray_traced_in_each_block(sample, name):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    core = read_scene(bpy.context.scene, bpy.context.view_layer)
    tracer, camera = Tracer(Geometry(core)), replace(core.camera, resolution=(SIDE, SIDE))

    def light(mode):
        # The same rays in both modes, so that most of the noise is the same.
        settings = SsgiSettings(mode=mode, denoise="none", samples=64, frames=2, light_samples=64)
        views = [tiles.finish(ssgi.still(tracer, camera, replace(settings, seed=k))) for k in range(SEEDS)]
        return blocks(np.array([view.radiance.mean(-1) for view in views]))

    reference = light("ray_traced")
    # What is almost black may be so by a little more.
    whole = np.maximum(reference.mean(0), 0.02 * reference.mean())
    off = (light("mixed") - reference) / whole
    assert (off.std(0, ddof=1) / np.sqrt(SEEDS)).max() < 0.015
    assert np.abs(off.mean(0)).max() < 0.03
    # It is the screen that brings part of it.
    assert (off != 0).mean() > 0.5
