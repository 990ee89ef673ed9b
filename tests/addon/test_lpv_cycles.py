# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""LPV in the sample scenes against Cycles at the same bounces, and what leaks through a wall of a centimetre."""

import bpy
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core import metrics
from gi_bake.gi_core.lpv import LpvSettings
from gi_bake.gi_core.tiles import finish
from gi_bake.tests.addon.test_glossy_cycles import FLOORS, both, material, rendered
from gi_bake.tests.addon.test_glossy_cycles import room as room


def indirect(**settings):
    """The indirect light of the open scene, E/π: (h, w, 3)."""
    job = Job(method="lpv", resolution=48, settings=LpvSettings(denoise="none", map_resolution=256, **settings))
    return finish(bake(bpy.context.scene, bpy.context.view_layer, job)).layers["Diffuse Indirect"]


def cycles(image, bounces=1, samples=128):
    height, width = image.shape[:2]
    layers = camera_reference(bpy.context.scene, bpy.context.view_layer, samples, bounces, 7, (width, height))
    return layers["Diffuse Indirect"], layers["Position"]


@pytest.mark.parametrize("name", ["cornell", "sunlit_room", "corridor"])
def test_a_room(sample, name):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    ours = indirect()
    theirs, _ = cycles(ours)
    assert abs(metrics.bias(ours, theirs)) < 0.1
    assert metrics.relmse(ours, theirs) < 0.03


def test_three_bounces(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    ours = indirect(bounces=3, cascades=1)
    theirs, _ = cycles(ours, bounces=3)
    assert abs(metrics.bias(ours, theirs)) < 0.1
    assert metrics.relmse(ours, theirs) < 0.03


def test_what_leaks_through_a_thin_wall(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("thin_wall")))
    ours = indirect()
    _, position = cycles(ours, samples=8)

    def leak(image):
        return image[position[..., 0] > 0.05].mean() / image[position[..., 0] < -0.05].mean()

    assert leak(ours) < 0.005
    assert leak(indirect(visibility=False)) > 0.1
    published = {"propagation": "flat", "iterations": 16}
    assert leak(indirect(**published, injection_bias=0.5)) < leak(
        indirect(**published, injection_bias=0.0, geometry_volume=False)
    )


def test_rough_gloss_from_the_volume(room):
    """A rough metal floor: the volume's three bands blur more than its lobe does, and see the floor itself; by rays it
    is within 3 %."""
    kind, inputs = FLOORS["metal"]
    room.data.materials[0] = material(kind, **inputs, Roughness=0.6)
    settings = LpvSettings(glossy=True, glossy_lookup="volume", samples=64, antialias=1)
    ours = finish(bake(bpy.context.scene, bpy.context.view_layer, Job(method="lpv", settings=settings))).layers
    theirs = rendered(256)
    here = both(ours, theirs)
    found, expected = (layers["Glossy Indirect"][here] for layers in (ours, theirs))
    assert abs(metrics.bias(found, expected)) < 0.15
    assert metrics.relmse(found, expected) < 0.06
