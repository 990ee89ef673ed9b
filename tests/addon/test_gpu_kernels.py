# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Every kernel that a graphics card has: each is held against numpy on fresh numbers somewhere, and here on what bakes
of sample scenes really give it."""

import importlib
import pkgutil
import re
from dataclasses import fields, is_dataclass, replace
from pathlib import Path

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.gi_core import kernels
from gi_bake.gi_core.gpu_array import GpuArray
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.tiles import finish


def named(kernel) -> str:
    return f"{kernel.__module__.rpartition('.')[2]}.{kernel.__name__.removesuffix('_on_gpu')}"


MODULES = [importlib.import_module(f"{kernels.__name__}.{m.name}") for m in pkgutil.iter_modules(kernels.__path__)]
NAMES = sorted(named(vars(m)[name]) for m in MODULES for name in vars(m) if name.endswith("_on_gpu")
               and vars(m)[name].__module__ == m.__name__)  # fmt: skip

RSM = RsmSettings(device="gpu", samples=4, light_samples=1, map_resolution=16, antialias=1, denoise="bilateral")
LPV = LpvSettings(device="gpu", cells=16, map_resolution=16, light_samples=1, antialias=1)
SSGI = SsgiSettings(
    device="gpu", mode="screen_space", fallback="none", samples=2, frames=2, light_samples=1, antialias=1, bounces=2
)
JOBS = [
    Job("rsm", settings=replace(RSM, interpolation=4)),
    Job("rsm", settings=replace(RSM, visibility=False)),
    Job("rsm", settings=replace(RSM, pattern="disk")),
    Job("lpv", settings=replace(LPV, propagation="flat", secondary_bounce=0.5)),
    Job("lpv", settings=replace(LPV, propagation="flat", iterations=0)),
    Job("lpv", settings=LPV),
    Job("ssgi", settings=replace(SSGI, full_resolution=False)),
    Job("ssgi", settings=replace(SSGI, tracer="bitmask", steps=4, clamp=2.0)),
    Job("ssgi", settings=replace(SSGI, feedback="previous", fallback="sky")),
]

# Kernels that bakes have as parts of others only.
PARTS = {"depth_march.depth_march", "surface_weight.surface_weight"}

# Kernels of cards that draw, which a driver in software leaves to Embree: see test_gpu_raster.py for sample scenes.
DRAWN = {"raster.raster", "shadow_map.shadow_map"}

# Kernels that decide: where numbers are as good as equal, rounding does, and one of some hundred items may differ.
DECIDES = {"closest", "screen_trace", "horizon_scan", "depth_march", "history_taps", "reproject", "diffuse_filter",
           "bilateral_upsample", "agreeing", "chosen", "temporal", "pixel_planes", "scan_light"}  # fmt: skip


def test_every_kernel_is_tested_on_fresh_numbers():
    tests = "".join(path.read_text() for path in Path(__file__).parent.glob("test_gpu_*.py"))
    assert len(NAMES) > 20
    aliases = dict(re.findall(r"import (\w+) as (\w+)", tests))
    names = {name: name.split(".")[1] for name in NAMES}
    run = {name: rf"(same|mostly|run)\((gpu,)?\s*({own}|{aliases.get(own, own)})\b" for name, own in names.items()}
    assert [name for name in NAMES if not re.search(run[name], tests)] == []


def test_every_shader_is_some_kernels():
    folder = Path(kernels.__file__).parent
    sources = "".join(path.read_text() for path in [*folder.glob("*.py"), *folder.parent.rglob("*.py")])
    assert [path.stem for path in folder.glob("*.glsl") if f'"{path.stem}"' not in sources] == []


def on_processor(gpu, value):
    """Whatever is on the card in a kernel's arguments, here."""
    if isinstance(value, GpuArray):
        return gpu.numpy(value)
    if is_dataclass(value) and not isinstance(value, type):
        there = {f.name: getattr(value, f.name) for f in fields(value) if f.init}
        here = {name: on_processor(gpu, one) for name, one in there.items()}
        return replace(value, **{name: one for name, one in here.items() if one is not there[name]})
    if isinstance(value, (tuple, list)):
        return tuple(on_processor(gpu, one) for one in value)
    return value


@pytest.fixture(scope="module")
def compared(gpu, sample):
    """By kernel: of each time it ran in bakes the share of numbers that numpy has too."""
    found, history = {}, None

    def run(kernel, *arguments, **settings):
        result = type(gpu).run(gpu, kernel, *arguments, **settings)
        here = dict(zip(settings, on_processor(gpu, tuple(settings.values()))))
        expected = kernel(*on_processor(gpu, arguments), **here)
        for e, f in zip(*((r if isinstance(r, tuple) else (r,)) for r in (expected, result))):
            f = gpu.numpy(f)
            assert f.shape == e.shape, named(kernel)
            e, f = (np.nan_to_num(a.astype(np.float64), posinf=1e30, neginf=-1e30) for a in (e, f))
            near = np.isclose(f, e, rtol=1e-3, atol=1e-3 * np.abs(e[np.abs(e) < 1e29]).max(initial=0))
            found.setdefault(named(kernel), []).append(near.mean() if near.size else 1.0)
        return result

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(gpu, "traces", True)
        patch.setattr(gpu, "run", run, raising=False)
        bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
        for job in JOBS:
            work = bake(bpy.context.scene, bpy.context.view_layer, replace(job, resolution=13), history=history)
            history = finish(work).history
        # With a normal map; its triangles are too many for rays in numpy.
        patch.setattr(gpu, "traces", False)
        bpy.ops.wm.open_mainfile(filepath=str(sample("materials")))
        finish(bake(bpy.context.scene, bpy.context.view_layer, Job("rsm", settings=RSM, resolution=13)))
    return found


@pytest.mark.parametrize("name", [name for name in NAMES if name not in PARTS | DRAWN])
def test_on_a_sample_scenes_data(compared, name):
    assert name in compared
    assert min(compared[name]) >= (0.97 if name.split('.')[1] in DECIDES else 1.0)
