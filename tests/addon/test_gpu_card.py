# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Whole bakes as a card that is one makes them, with all rays its own: the processor's result, without Embree."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.gi_core import trace
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.metrics import relmse
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.tiles import finish

RSM = RsmSettings(samples=16, map_resolution=64, light_samples=4)
LPV = LpvSettings(cells=16, map_resolution=64, light_samples=4)
SSGI = SsgiSettings(samples=4, frames=2, light_samples=4)
JOBS = {
    "rsm, lightmap": ("cornell", Job("rsm", "lightmap", ("Floor",), resolution=16, settings=RSM)),
    "rsm, alpha and gloss": ("cornell", Job("rsm", resolution=24, settings=replace(RSM, glossy=True))),
    "rsm, emitters": ("emissive", Job("rsm", "vertices", settings=RSM)),
    "lpv": ("sunlit_room", Job("lpv", resolution=24, settings=LPV)),
    "lpv, flat": ("sunlit_room", Job("lpv", resolution=24, settings=replace(LPV, propagation="flat"))),
    "lpv, fog, alpha": ("pan", Job("lpv", resolution=16, settings=replace(LPV, fog_density=0.1))),
    "ssgi, mixed": ("pan", Job("ssgi", resolution=48, settings=replace(SSGI, mode="mixed"))),
    "ssgi, probes": ("sunlit_room", Job("ssgi", resolution=32, settings=replace(SSGI, fallback="both", probe_cells=3))),
    "ssgi, rays": ("sunlit_room", Job("ssgi", resolution=32, settings=replace(SSGI, mode="ray_traced"))),
    "rsm, two bounces": ("cornell", Job("rsm", resolution=24, settings=replace(RSM, bounces=2))),
    "rsm, four bounces": ("sunlit_room", Job("rsm", "vertices", settings=replace(RSM, bounces=4, seed=3))),
    "rsm, alpha, two bounces": ("thin_wall", Job("rsm", resolution=24, settings=replace(RSM, bounces=2))),
    "lpv, alpha and gloss": ("thin_wall", Job("lpv", resolution=24, settings=replace(LPV, glossy=True))),
    "ssgi, screen, alpha": ("cornell", Job("ssgi", resolution=32, settings=replace(SSGI, mode="screen_space"))),
    "ssgi, mixed, alpha": ("cornell", Job("ssgi", resolution=32, settings=replace(SSGI, mode="mixed"))),
    "ssgi, rays, alpha and gloss": (
        "cornell",
        Job("ssgi", resolution=32, settings=replace(SSGI, mode="ray_traced", glossy=True, bounces=2)),
    ),
}


def light_of(job, device):
    """Every light that a bake finds, by its name."""
    job = replace(job, settings=replace(job.settings, device=device))
    result = finish(bake(bpy.context.scene, bpy.context.view_layer, job))
    assert result.device.startswith(device)
    kinds = [(f"{name} {kind}", getattr(light, kind)) for name, light in result.light.items()
             for kind in ("direct", "indirect")]  # fmt: skip
    return dict(kinds) | {k: v for k, v in result.layers.items() if k.split()[0] in ("Diffuse", "Glossy", "Volume")}


def half_clear():
    """All surfaces let a third of the light through, and shine."""
    for material in bpy.data.materials:
        tree = material.node_tree
        shader = tree.nodes.new("ShaderNodeBsdfPrincipled")
        shader.inputs["Base Color"].default_value = 0.5, 0.5, 0.5, 1
        shader.inputs["Roughness"].default_value, shader.inputs["Alpha"].default_value = 0.4, 2 / 3
        tree.links.new(shader.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])


def no_embree(*_, **__):
    raise AssertionError("a ray went back to the processor")


@pytest.mark.parametrize("name", JOBS)
def test_no_ray_goes_back_to_the_processor(gpu, sample, monkeypatch, name):
    scene, job = JOBS[name]
    bpy.ops.wm.open_mainfile(filepath=str(sample(scene)))
    if "alpha" in name:
        half_clear()
    expected = light_of(job, "cpu")
    monkeypatch.setattr(gpu, "traces", True)
    monkeypatch.setattr(trace, "EmbreeScene", no_embree)
    found = light_of(job, "gpu")
    assert expected.keys() == found.keys()
    assert max(light.mean() for light in expected.values()) > 1e-3
    for kind, light in expected.items():
        assert relmse(found[kind].astype(np.float64), light.astype(np.float64)) <= 1e-5, kind
