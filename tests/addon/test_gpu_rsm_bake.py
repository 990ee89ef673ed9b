# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole bakes with RSM on the graphics card: the processor's result, in bounded memory."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.metrics import relmse
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.tiles import finish

SETTINGS = RsmSettings(samples=16, map_resolution=64, light_samples=4)


def light_of(job):
    """Every light that a bake finds, by its name."""
    result = finish(bake(bpy.context.scene, bpy.context.view_layer, job))
    kinds = [(f"{name} {kind}", getattr(light, kind)) for name, light in result.light.items()
             for kind in ("direct", "indirect")]  # fmt: skip
    kinds += [(k, v) for k, v in result.layers.items() if k.startswith("Diffuse") and "Color" not in k]
    return result.device, dict(kinds)


def agrees(job):
    device, expected = light_of(replace(job, settings=replace(job.settings, device="cpu")))
    assert device == "cpu"
    device, found = light_of(replace(job, settings=replace(job.settings, device="gpu")))
    assert device.startswith("gpu")
    for name, light in expected.items():
        assert relmse(found[name].astype(np.float64), light.astype(np.float64)) <= 1e-5, name
    assert max(light.mean() for name, light in expected.items() if name.lower().endswith("indirect")) > 1e-3


@pytest.mark.parametrize("name", ["cornell", "emissive", "materials", "pan"])
def test_an_image_as_the_processor_has_it(gpu, sample, name):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    agrees(Job(resolution=48, settings=SETTINGS))


@pytest.mark.parametrize("target", ["lightmap", "vertices"])
def test_light_on_objects_as_the_processor_has_it(gpu, sample, target):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    agrees(Job(target=target, resolution=32, settings=SETTINGS))


def test_an_interpolated_image_as_the_processor_has_it(gpu, sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    agrees(Job(resolution=64, settings=replace(SETTINGS, interpolation=4)))


def peak(gpu, memory, job):
    """Bytes on the card while something is baked, at the most."""
    forgotten(gpu)
    gpu.peak = gpu.bytes
    job = replace(job, settings=replace(job.settings, device="gpu", memory=memory))
    finish(bake(bpy.context.scene, bpy.context.view_layer, job))
    return gpu.peak


def forgotten(gpu):
    """Nothing that was kept for later is."""
    budget, gpu.budget = gpu.budget, 0
    assert gpu.array(np.zeros(1, np.float32), 1).texture
    gpu.budget = budget


JOBS = {
    "lightmap": Job(target="lightmap", resolution=96, settings=SETTINGS),
    "image": Job(resolution=96, settings=replace(SETTINGS, interpolation=4)),
    "ssgi": Job("ssgi", resolution=96, settings=SsgiSettings(mode="screen_space", samples=4, frames=2)),
    "lpv": Job("lpv", resolution=96, settings=LpvSettings(propagation="flat", map_resolution=64, cells=32)),
}


@pytest.mark.parametrize("name", JOBS)
def test_memory_bounds_what_is_on_the_card(gpu, sample, name):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    small, large = peak(gpu, 2, JOBS[name]), peak(gpu, 1024, JOBS[name])
    # What one dispatch works on is there, whatever the memory: a step through 34³ cells, with walls, takes 6 MB, and a
    # band of subpixels with all rows that its filters look at 2.2 MB.
    most = {"lpv": 13 << 19, "ssgi": 9 << 18}.get(name, 2 << 20)
    assert small <= most < large


def test_textures_that_are_gone_do_not_count(gpu):
    forgotten(gpu)
    before = gpu.bytes
    there = [gpu.array(np.zeros((1000, 4), np.float32), 4), gpu.empty((1000, 4), 4)]
    assert gpu.bytes == before and all(one.texture for one in there)
    assert gpu.bytes == before + 2 * 16000
    del there
    assert gpu.bytes == before + 16000  # one is kept
    forgotten(gpu)
    assert gpu.bytes == before


def test_a_card_of_small_textures_takes_more_tiles(gpu, sample, monkeypatch):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    job = Job(resolution=48, settings=replace(SETTINGS, device="gpu", denoise="bilateral"))
    most = []
    array = type(gpu).array

    def watched(self, values, channels, *more):
        most.append(len(values) if isinstance(values, np.ndarray) and values.ndim == 3 else 0)
        return array(self, values, channels, *more)

    monkeypatch.setattr(type(gpu), "array", watched)
    _, whole = light_of(job)
    rows = max(most)
    most.clear()
    monkeypatch.setattr(gpu, "most", 1)
    _, cut = light_of(job)
    assert max(most) < rows
    for name, light in whole.items():
        assert relmse(cut[name].astype(np.float64), light.astype(np.float64)) <= 1e-7, name
