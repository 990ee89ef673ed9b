# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole bakes of the Cornell box against Cycles, and what a bake leaves alone."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import Refused, bake
from gi_bake.addon.compare.halves import truth
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job, NotThere
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.settings import SettingError
from gi_bake.gi_core.techniques import METHODS


@pytest.fixture
def cornell(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    return bpy.context.scene


def baked(scene, **job):
    return tiles.finish(bake(scene, bpy.context.view_layer, Job(**job)))


def against(result, size, samples, folder, maps=None):
    """Cycles' light and its noise by name, as two renders of half the samples tell it."""
    found = truth(bpy.context.scene, bpy.context.view_layer, result.job, size, maps or {}, samples, folder)
    return found.light, found.noise


def test_camera_image_equals_cycles(cornell, tmp_path):
    result = baked(cornell, resolution=128)
    ours, (cycles, noise) = result.layers, against(result, (128, 128), 256, tmp_path)
    r, n = (part["Diffuse Indirect"] for part in (cycles, noise))
    assert metrics.relmse(ours["Diffuse Indirect"], r) - metrics.relmse(r + n, r) <= 0.003
    assert abs(metrics.bias(ours["Diffuse Indirect"], r)) <= 0.02
    assert metrics.relmse(ours["Diffuse Color"], cycles["Diffuse Color"]) < 0.005


def test_geometry_layers_equal_cycles(cornell):
    ours = baked(cornell, resolution=96, settings=RsmSettings(antialias=1, samples=1)).layers
    cycles = camera_reference(cornell, bpy.context.view_layer, 1, 1, 3, (96, 96), antialias=False)
    for name, tolerance in (("Depth", 0.01), ("Position", 0.01), ("Normal", 1e-3), ("Diffuse Color", 1e-3)):
        near = np.abs(ours[name] - cycles[name]).max(-1) < tolerance
        # Cycles' narrowest filter still jitters a little: a pixel on a silhouette may show either side.
        assert near.mean() > 0.995, name


def test_three_bounces_equal_cycles(cornell):
    ours = baked(cornell, resolution=48, settings=RsmSettings(bounces=3, samples=128)).layers
    cycles = camera_reference(cornell, bpy.context.view_layer, 512, 3, 3, (48, 48))
    assert abs(metrics.bias(ours["Diffuse Indirect"], cycles["Diffuse Indirect"])) <= 0.03


def test_lightmaps_equal_cycles(cornell, tmp_path):
    settings = RsmSettings(light="indirect")
    result = baked(cornell, target="lightmap", resolution=64, settings=settings)
    coarse = baked(cornell, target="lightmap", resolution=64, settings=replace(settings, interpolation=2))
    maps = {name: (bpy.data.objects[name].data.uv_layers.active.name, 64) for name in result.light}
    assert len(maps) == 7
    cycles, noise = against(result, (64, 64), 128, tmp_path, maps)
    counted = {name: light.centred & (cycles[name, "indirect"][..., 3] > 0) for name, light in result.light.items()}
    r, n = (np.concatenate([p[name, "indirect"][m][:, :3] for name, m in counted.items()]) for p in (cycles, noise))
    assert len(r) > 0.5 * 7 * 64 * 64
    for light in (result.light, coarse.light):
        ours = np.concatenate([light[name].indirect[counted[name]] for name in counted])
        assert metrics.relmse(ours, r) - metrics.relmse(r + n, r) <= 0.007 and abs(metrics.bias(ours, r)) <= 0.02
    assert any("interpolation" in warning for warning in coarse.warnings)


def test_every_light_target_and_pattern_is_finite_and_lit(cornell):
    settings = RsmSettings(samples=8, map_resolution=32)
    for pattern in ("flux", "disk", "all"):
        image = baked(
            cornell, resolution=16, settings=RsmSettings(samples=8, map_resolution=32, pattern=pattern)
        ).layers
        assert all(np.isfinite(layer).all() for layer in image.values()) and image["Diffuse Indirect"].max() > 0
    vertices = baked(cornell, target="vertices", settings=settings).light
    assert all(np.isfinite(light.indirect).all() and light.valid.all() for light in vertices.values())


def test_a_bake_changes_nothing_in_the_file_and_repeats_exactly(cornell):
    def state():
        return {
            name: sorted(block.name_full for block in getattr(bpy.data, name))
            for name in (
                "objects",
                "meshes",
                "images",
                "materials",
                "scenes",
                "cameras",
                "lights",
                "worlds",
                "node_groups",
            )
        } | {"engine": cornell.render.engine, "camera": cornell.camera.name, "frame": cornell.frame_current}

    before = state()
    first, second = (baked(cornell, resolution=32).layers["Diffuse Indirect"] for _ in range(2))
    assert np.array_equal(first, second)
    running = bake(cornell, bpy.context.view_layer, Job(resolution=64))
    for _ in range(4):
        next(running)
    running.close()
    assert state() == before


def test_progress_rises_to_the_end(cornell):
    shares = [fraction for fraction, _ in bake(cornell, bpy.context.view_layer, Job(resolution=32))]
    assert shares == sorted(shares) and 0.9 < shares[-1] <= 1


@pytest.mark.parametrize("method", ["rsm", "lpv", "ssgi"])
def test_the_picture_so_far_becomes_the_result(cornell, method):
    seen, shares = [], []
    settings = METHODS[method].settings(samples=32, denoise="bilateral")
    work = bake(
        cornell, bpy.context.view_layer, Job(method=method, resolution=33, settings=settings), None,
        lambda name, rows, light: seen.append((name, rows, light)),
    )  # fmt: skip
    layers = tiles.finish(tiles.relayed(work, lambda step: shares.append(step[0]) or step)).layers
    assert shares == sorted(shares)
    assert all((name, rows) == ("", slice(0, 33)) for name, rows, _ in seen)
    assert np.allclose(seen[-1][2], layers["Diffuse Direct"] + layers["Diffuse Indirect"], atol=1e-5)
    lamps = [np.allclose(light, layers["Diffuse Direct"], atol=1e-5) for _, _, light in seen]
    assert lamps == [k == 0 and method == "rsm" for k in range(len(seen))], "what is known first is shown first"
    if method == "ssgi":
        assert len(seen) > settings.frames, "each pass over the picture is shown"
        # The screen's picture of a pixel is that of its middle, the result's is smooth at borders.
        last = seen[settings.frames - 1][2]
        assert metrics.relmse(last, seen[-1][2]) < 0.2 < metrics.relmse(layers["Diffuse Direct"], seen[-1][2])


def test_the_cameras_frame_is_the_one_that_is_set(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("pan")))
    scene = bpy.context.scene
    settings = RsmSettings(samples=1, map_resolution=8)
    pictures = []
    for frame in (scene.frame_start, scene.frame_end):
        scene.frame_set(frame)
        pictures.append(baked(scene, resolution=32, settings=settings).layers["Position"])
    assert np.abs(pictures[0] - pictures[1]).mean() > 0.05


def test_what_is_not_there_is_refused_before_work(cornell):
    for job in ({"method": "raytrace"}, {"target": "volume"}):
        with pytest.raises(NotThere):
            Job(**job)
    with pytest.raises(SettingError):
        Job(resolution=1)
    cornell.camera = None
    with pytest.raises(Refused, match="NO_CAMERA"):
        baked(cornell)


@pytest.mark.parametrize(
    "job, memory",
    [
        ({"resolution": 96, "settings": RsmSettings(samples=16)}, 4),
        ({"resolution": 96, "settings": RsmSettings(samples=8, interpolation=4)}, 4),
        ({"resolution": 96, "settings": RsmSettings(samples=8, denoise="oidn")}, 4),
        (
            {"target": "lightmap", "resolution": 96, "settings": RsmSettings(samples=8)}
            | {"objects": ("Floor", "Ceiling", "Tall box")},
            2,
        ),
        ({"target": "vertices", "settings": RsmSettings(samples=8)}, 1),
    ],
    ids=["image", "interpolated", "oidn", "lightmaps", "vertices"],
)
def test_the_result_does_not_depend_on_the_tiles(cornell, job, memory):
    def values(memory):
        result = baked(cornell, **job | {"settings": replace(job["settings"], memory=memory)})
        lights = [part for light in result.light.values() for part in (light.direct, light.indirect)]
        return [*result.layers.values(), *lights]

    # A megabyte has some 3500 points: bands of rows, or less than one lightmap.
    for cut, whole in zip(values(memory), values(1024), strict=True):
        assert np.allclose(cut, whole, rtol=1e-4, atol=1e-5)


def test_a_bake_ends_at_a_noise_and_shows_how_it_goes(cornell):
    shown = []

    def look(name, rows, light):
        shown.append((name, rows, light))

    settings = RsmSettings(samples=4096, noise_threshold=0.002, denoise="none", antialias=1)
    job = Job(resolution=64, settings=settings)
    result = tiles.finish(bake(cornell, bpy.context.view_layer, job, preview=look))
    [note] = [w for w in result.warnings if w.startswith("refinement")]
    assert 16 < int(note.split()[1]) < 1024
    cycles = camera_reference(cornell, bpy.context.view_layer, 1024, 1, 3, (64, 64), antialias=False)
    # On silhouettes the two see different surfaces.
    depth = cycles["Depth"][..., 0]
    same = np.ones(depth.shape, bool)
    for shift, axis in ((1, 0), (-1, 0), (1, 1), (-1, 1)):
        same &= np.abs(np.roll(depth, shift, axis) / depth - 1) < 0.05
    error = metrics.relmse(*(layers["Diffuse Indirect"][same] for layers in (result.layers, cycles)))
    assert same.mean() > 0.8 and 0.001 < error < 0.004
    assert all(name == "" and light.shape == (64, 64, 3) for name, _, light in shown)
    last = result.layers["Diffuse Direct"] + result.layers["Diffuse Indirect"]
    lit = np.any(result.layers["Diffuse Color"] > 0, -1)
    errors = [np.mean((light - last)[lit] ** 2) for _, _, light in shown]
    assert len(errors) > 2 and errors[0] > errors[1] > errors[-1] and errors[-1] < 1e-9


def test_only_what_is_asked_for_is_worked_out(cornell):
    direct, indirect = (
        baked(cornell, target="lightmap", resolution=16, settings=RsmSettings(light=light))
        for light in ("direct", "indirect")
    )
    assert "maps" not in direct.stages and "lamps" not in indirect.stages
    for result, has, lacks in ((direct, "direct", "indirect"), (indirect, "indirect", "direct")):
        lights = result.light.values()
        assert any(getattr(light, has).any() for light in lights)
        assert not any(getattr(light, lacks).any() for light in lights)
