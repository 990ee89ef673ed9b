# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A thin homogeneous medium in the Cornell box against Cycles' volume passes, and how it gets into the picture."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core.lpv import LpvSettings
from gi_bake.gi_core.settings import SettingError
from gi_bake.gi_core.tiles import finish

SIZE, DENSITY = 24, 0.02


def ours(**settings):
    job = Job(method="lpv", resolution=SIZE, settings=LpvSettings(map_resolution=128, cells=16, **settings))
    return finish(bake(bpy.context.scene, bpy.context.view_layer, job)).layers


def cycles(anisotropy, samples):
    """The same view with a cube of smoke in the room, light once reflected or scattered at the most before."""
    scene, layer = bpy.context.scene, bpy.context.view_layer
    bpy.ops.mesh.primitive_cube_add(size=1.999, location=(0, 0, 1))
    smoke = bpy.data.materials.new("Smoke")
    smoke.use_nodes = True
    tree = smoke.node_tree
    tree.nodes.clear()
    scatter, output = tree.nodes.new("ShaderNodeVolumeScatter"), tree.nodes.new("ShaderNodeOutputMaterial")
    scatter.inputs["Color"].default_value = (1, 1, 1, 1)
    scatter.inputs["Density"].default_value = DENSITY
    scatter.inputs["Anisotropy"].default_value = anisotropy
    tree.links.new(scatter.outputs[0], output.inputs["Volume"])
    bpy.context.object.data.materials.append(smoke)
    layer.cycles.use_pass_volume_direct = layer.cycles.use_pass_volume_indirect = True
    return camera_reference(scene, layer, samples, 1, 3, (SIZE, SIZE))


@pytest.mark.parametrize("anisotropy", [0.0, 0.5])
def test_what_a_medium_scatters(sample, anisotropy):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    found = ours(fog_density=DENSITY, fog_steps=32, fog_anisotropy=anisotropy)
    theirs = cycles(anisotropy, 1536)
    for name, limit in (("Volume Direct", 0.05), ("Volume Indirect", 0.15)):
        a, b = found[name], theirs[name][..., :3]
        assert abs(a.mean() / b.mean() - 1) < limit, (name, a.mean(), b.mean())
    # Not the upper third: at the lamp itself, where light is singular, rows differ by more than this.
    rows, reference = (x["Volume Direct"][: 2 * SIZE // 3, :, :3].mean((1, 2)) for x in (found, theirs))
    assert np.allclose(rows, reference, rtol=0.12)


def test_the_picture_shows_it(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    clear = ours()
    thick = ours(fog_density=50.0, fog_albedo=0.0)
    assert "Volume Direct" not in clear
    assert not thick["Volume Direct"].any() and not thick["Volume Indirect"].any()
    # Where the walls begin the way through it is short.
    middle = np.s_[8:-8, 8:-8, :3]
    assert thick["Combined"][middle].max() < 1e-6 < clear["Combined"][middle].max()
    foggy = ours(fog_density=0.5)
    light = foggy["Volume Direct"] + foggy["Volume Indirect"]
    behind = foggy["Combined"][..., :3] - light
    share = behind / clear["Combined"][..., :3]
    assert light.min() > 0 and share.min() > np.exp(-0.5 * 2.5) and share.max() < 1.001


def test_it_needs_a_view():
    with pytest.raises(SettingError, match="fog_density"):
        Job(method="lpv", target="volume", settings=LpvSettings(fog_density=1.0))
