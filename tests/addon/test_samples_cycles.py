# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The albedo that surfaces of the sample `materials` have against Cycles' Diffuse Color pass."""

import bpy
import numpy as np
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.tests.shader_trees import color_errors, read_baked


def test_albedo_of_every_object_or_it_is_told(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("materials")))
    core = read_baked()
    shown = camera_reference(bpy.context.scene, bpy.context.view_layer, 1, 0, 0, antialias=False)
    errors = color_errors(core, shown["Diffuse Color"][..., :3], "albedo")
    names = {name: {core.materials[k].name for i in core.instances if i.name == name for k in i.materials}
             for name in errors}
    assert len(errors) == len({i.name for i in core.instances}) >= 17
    wrong = {name: (e.mean(), np.percentile(e, 99)) for name, e in errors.items()
             if e.mean() > 1 or np.percentile(e, 99) > 3}
    assert set(wrong) == {"Dented block"}, wrong
    told = " ".join(core.approximated)
    assert all(f"Material '{name}': " in told for thing in wrong for name in names[thing])
    assert not [note for note in core.approximated if "everywhere" in note]
