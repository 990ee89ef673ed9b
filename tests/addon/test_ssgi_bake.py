# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI as a bake: layers on request, lightmaps and vertices of what cameras saw, presets, refusals."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import Refused, bake
from gi_bake.addon.job import Job
from gi_bake.addon.write.results import export, store
from gi_bake.gi_core import exr, metrics, tiles
from gi_bake.gi_core.settings import SettingError
from gi_bake.gi_core.ssgi.settings import SsgiSettings

QUICK = SsgiSettings(mode="ray_traced", samples=16, frames=4, light_samples=4)


@pytest.fixture
def cornell(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 64
    return bpy.context.scene, bpy.context.view_layer


def baked(cornell, **job):
    return tiles.finish(bake(*cornell, Job("ssgi", **job)))


@pytest.mark.parametrize("full", [True, False])
def test_each_pass_is_a_layer_where_that_is_asked_for(cornell, tmp_path, full):
    settings = replace(QUICK, mode="screen_space", fallback="none", debug=True, full_resolution=full, steps=32)
    result = baked(cornell, resolution=33, settings=settings)
    seen = {"Lit", "Face", "Motion", "Hit", "Missed"}
    names = seen | {"Traced", "Accumulated", "Filtered", "Accumulated again", "Passes"}
    assert not any(name == "SSGI Sure" for name in result.layers)
    export(result, tmp_path, "ViewLayer")
    layers = exr.read_layers(tmp_path / "image.exr")
    assert {f"SSGI {name}" for name in names} <= set(layers)
    assert all(layer.shape[:2] == (33, 33) for layer in layers.values())
    assert (layers["SSGI Passes"] == 4).mean() > 0.9
    assert 0 < layers["SSGI Missed"].mean() < 1
    hit = layers["SSGI Hit"][..., 0]
    assert 0.2 < (hit >= 0).mean() < 1 and hit.max() < 33
    # A camera that stands still: nothing moves.
    assert np.nanmax(np.abs(layers["SSGI Motion"])) < 1e-2
    assert not any(name.startswith("SSGI") for name in baked(cornell, resolution=16, settings=QUICK).layers)
    sure = baked(cornell, resolution=33, settings=replace(settings, mode="mixed")).layers["SSGI Sure"]
    assert sure.shape == (33, 33) and 0.1 < sure.mean() < 0.9


def test_vertices_and_texels_of_what_cameras_saw(cornell):
    """What the camera saw has its light; what it did not says so; a second camera sees more."""
    names = ("Floor", "Tall box")
    truth = baked(cornell, target="lightmap", objects=names, resolution=32, settings=replace(QUICK, samples=64))
    floor = truth.light["Floor"]
    assert floor.coverage.shape == (32, 32)
    rsm = tiles.finish(bake(*cornell, Job("rsm", "lightmap", names, 32)))
    seen = floor.valid & (floor.coverage > 0.9)
    assert seen.sum() > 100
    assert metrics.relmse(floor.indirect[seen], rsm.light["Floor"].indirect[seen]) < 0.05
    one = baked(cornell, target="vertices", objects=names, settings=QUICK)
    coverage = one.light["Tall box"].coverage
    assert coverage.max() > 0.5 and coverage.min() == 0

    bpy.ops.object.camera_add(location=(-0.9, 0.95, 1.9), rotation=(0.7, 0, 3.6))
    bpy.context.object.data.angle = 1.6
    bpy.context.object.name = "Behind"
    both = baked(cornell, target="vertices", objects=names, settings=replace(QUICK, cameras="Camera, Behind"))
    assert both.light["Tall box"].coverage.sum() > coverage.sum() + 0.5
    store(both, cornell[0])
    attribute = bpy.data.objects["Tall box"].data.attributes["gi_coverage"]
    values = np.empty(len(attribute.data), np.float32)
    attribute.data.foreach_get("value", values)
    assert np.array_equal(values, both.light["Tall box"].coverage)
    store(truth, cornell[0])
    assert bpy.data.images["Floor Coverage"].size[0] == 32


def test_what_cannot_be_is_refused(cornell):
    with pytest.raises(SettingError, match="'Nobody' is no camera"):
        baked(cornell, target="vertices", settings=replace(QUICK, cameras="Nobody"))
    bpy.context.scene.camera = None
    with pytest.raises(Refused) as refused:
        baked(cornell, target="vertices", settings=QUICK)
    assert [f.code for f in refused.value.findings] == ["NO_CAMERA"]


def test_presets_are_hdrps():
    def of(mode, *names):
        presets = [SsgiSettings(quality=q, mode=mode, second_pass=False).preset for q in ("low", "medium", "high")]
        return [tuple(getattr(s, name) for s in presets) for name in names]

    names = "radius", "half_filter", "second_pass"
    assert of("screen_space", "steps", *names) == [
        (32, 64, 128), (0.75, 0.5, 0.5), (True, False, False), (True, True, True),
    ]  # fmt: skip
    for mode in ("mixed", "ray_traced"):
        assert of(mode, "mixed_steps", "full_resolution", *names) == [
            (32, 48, 64), (False, False, True), (1, 1, 1), (True, False, False), (True, True, True),
        ]  # fmt: skip
    own = SsgiSettings(steps=7, radius=0.3, full_resolution=False)
    assert own.preset == own
