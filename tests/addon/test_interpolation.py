# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy
import numpy as np
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.tiles import finish


def test_an_interpolated_image_says_how_much_it_reuses(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    light, notes = [], []
    for cell in (1, 2):
        job = Job(resolution=64, settings=RsmSettings(samples=64, denoise="none", interpolation=cell))
        result = finish(bake(bpy.context.scene, bpy.context.view_layer, job))
        light.append(result.layers["Diffuse Indirect"])
        notes.append([w for w in result.warnings if w.startswith("interpolation")])
    assert not notes[0] and "reuse" in notes[1][0]
    assert np.isclose(light[1].mean(), light[0].mean(), rtol=0.02)
