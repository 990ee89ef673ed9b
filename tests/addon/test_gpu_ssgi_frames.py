# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI on the graphics card as a whole: pictures of sample scenes are what numpy makes of them, in every
mode, and between their passes nothing comes back."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.addon.read import read_scene
from gi_bake.gi_core import metrics, ssgi, tiles
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.gpu_array import GpuArray
from gi_bake.gi_core.kernels.pixel_planes import pixel_planes
from gi_bake.gi_core.kernels.screen_trace import NO_RAY, screen_trace
from gi_bake.gi_core.ssgi import pipeline
from gi_bake.gi_core.ssgi.frame import direct_light, g_buffer
from gi_bake.gi_core.ssgi.screen import Screen
from gi_bake.gi_core.ssgi.search import Search
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.trace import Tracer
from gi_bake.gi_core.vectors import normalize

SCREEN = SsgiSettings(mode="screen_space", fallback="none", samples=8, frames=2, light_samples=4)
MODES = {
    "march": {},
    "two bounces": {"bounces": 2, "clamp": 0.4},
    "bitmask": {"tracer": "bitmask", "steps": 8, "samples": 4},
    "half": {"full_resolution": False, "bounces": 2},
    "previous": {"feedback": "previous", "frames": 4},
    "probes": {"fallback": "both", "probe_cells": 3},
    "mixed": {"mode": "mixed", "bounces": 2},
    "ray_traced": {"mode": "ray_traced"},
    "unfiltered": {"denoise": "none"},
    "hdrp": {"accumulation": "hdrp", "weights": "literal", "frames": 8},
}


@pytest.fixture(scope="module")
def scene(sample):
    """pan.blend at a size that no work group divides, read once: a Scene's geometry and its camera."""
    bpy.ops.wm.open_mainfile(filepath=str(sample("pan")))
    core = read_scene(bpy.context.scene, bpy.context.view_layer)
    return Geometry(core), replace(core.camera, resolution=(93, 51))


@pytest.mark.parametrize("mode", MODES)
def test_a_picture_is_the_same_on_both(gpu, scene, mode):
    geometry, camera = scene
    settings = replace(SCREEN, **MODES[mode])
    expected, found = (tiles.finish(ssgi.still(Tracer(geometry, d), camera, settings)) for d in (NUMPY, gpu))
    assert isinstance(found.radiance, np.ndarray) and isinstance(found.history.picture, np.ndarray)
    surface = expected.buffer.surface
    assert expected.radiance[surface].mean() > 0.01
    assert metrics.relmse(found.radiance[surface], expected.radiance[surface]) <= 1e-5
    assert metrics.relmse(found.history.picture, expected.history.picture) <= 1e-5
    np.testing.assert_array_equal(found.history.count, expected.history.count)


def test_what_each_pass_found_is_the_same(gpu, scene):
    geometry, camera = scene
    settings = replace(SCREEN, debug=True)
    expected, found = (tiles.finish(ssgi.still(Tracer(geometry, d), camera, settings)) for d in (NUMPY, gpu))
    assert set(found.layers) == set(expected.layers)
    for name, layer in expected.layers.items():
        assert np.isclose(found.layers[name], layer, rtol=1e-3, atol=1e-4, equal_nan=True).mean() > 0.995, name


def test_a_history_goes_on_from_picture_to_picture(gpu, scene):
    geometry, camera = scene
    turned = replace(camera, matrix=camera.matrix + np.pad([[0.05], [0.02], [0]], ((0, 1), (3, 0))))
    results = []
    for device in (NUMPY, gpu):
        tracer = Tracer(geometry, device)
        first = tiles.finish(ssgi.still(tracer, camera, SCREEN))
        results.append(tiles.finish(ssgi.still(tracer, turned, SCREEN, history=first.history)))
    expected, found = results
    surface = expected.buffer.surface
    assert expected.history.count[surface].mean() > 3
    assert metrics.relmse(found.radiance[surface], expected.radiance[surface]) <= 1e-5


def test_rays_of_a_sample_scene_meet_the_same_pixels(gpu, scene):
    """All of screen_trace, on what a camera really sees: sure hits and others, some pixels not to be met."""
    geometry, camera = scene
    full = tiles.finish(g_buffer(Tracer(geometry), Screen(camera)))
    valid = np.random.default_rng(0).random(full.depth.size) > 0.1
    tilted = normalize(full.normal + np.random.default_rng(1).normal(0, 0.4, full.normal.shape)).astype(np.float32)
    found = []
    for certain, known, mesh_normal in ((False, None, None), (True, valid, None), (False, None, tilted)):
        for device in (NUMPY, gpu):
            search = Search(Tracer(geometry, device), full, full, replace(SCREEN, frames=1), None)
            found.append(device.numpy(device.run(
                screen_trace, search.pixels, search.place, known, search.seen.depth, search.seen.position,
                search.seen.normal, search.seen.face, search.depth, search.sequence(3), full.screen, 7, 1 / 1.1, 64,
                certain, mesh_normal,
            )))  # fmt: skip
    assert (found[1] == found[0]).mean() > 0.9995 and (found[3] == found[2]).mean() > 0.9995
    # Rays that relief hides do not leave.
    assert (found[5] == found[4]).mean() > 0.999
    assert (found[0] == NO_RAY).mean() + 0.02 < (found[4] == NO_RAY).mean() < 0.5
    assert 0.1 < (found[1] >= 0).mean() < 0.9 and (found[0] >= 0).mean() > 1.1 * (found[2] >= 0).mean()


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
@pytest.mark.parametrize("n", [0, 1, 93 * 51])
def test_planes_of_a_sample_scene(same, scene, kind, n):
    geometry, camera = scene
    if kind == "ORTHOGRAPHIC":
        camera = replace(camera, kind=kind, window=tuple(4 * side for side in camera.window))
    full = tiles.finish(g_buffer(Tracer(geometry), Screen(camera)))
    assert 0.3 < full.surface.mean()
    images = full.depth.reshape(-1), full.position.reshape(-1, 3), full.face.reshape(-1, 3)
    same(pixel_planes, *(image[:n] for image in images), full.screen)


def test_nothing_comes_back_between_passes(gpu, scene, monkeypatch):
    geometry, camera = scene
    full = tiles.finish(g_buffer(Tracer(geometry), Screen(camera)))
    direct = tiles.finish(direct_light(Tracer(geometry), full, 4, 1, 0))
    settings = replace(SCREEN, bounces=2)
    inputs = pipeline.Inputs(full, full, direct, Search(Tracer(geometry, gpu), full, full, settings, None))
    history = None
    for _ in range(2):
        _, history, _ = tiles.finish(pipeline.one_pass(inputs, history, settings))
    before, read = gpu.moved, []
    whole = type(gpu).numpy
    monkeypatch.setattr(type(gpu), "numpy", lambda self, values: read.append(values) or whole(self, values))
    radiance, history, _ = tiles.finish(pipeline.one_pass(inputs, history, settings))
    assert isinstance(radiance, GpuArray) and isinstance(history.picture, GpuArray)
    assert not [one for one in read if isinstance(one, GpuArray)]
    # What goes there are points of disks and matrices.
    assert gpu.moved - before < 4096


def test_a_bake_says_what_computed_it(gpu, sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    found = []
    for device in ("cpu", "gpu"):
        job = Job("ssgi", resolution=48, settings=replace(SCREEN, mode="mixed", device=device))
        found.append(tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job)))
    assert found[0].device == "cpu" and found[1].device.startswith("gpu")
    expected, got = (one.layers["Diffuse Indirect"] for one in found)
    assert metrics.relmse(got, expected) <= 1e-5
