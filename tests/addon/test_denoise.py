# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Open Image Denoise through the compositor: error falls, light stays, the file is left as it was."""

from functools import partial

import bpy
import numpy as np
import pytest
from gi_bake.addon import denoise, preflight
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.denoise import oidn
from gi_bake.addon.job import Job
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.techniques import METHODS


@pytest.fixture
def cornell(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    return bpy.context.scene


@pytest.fixture
def noise():
    """Of a shape: noise of mean 1, never negative, as light has it."""
    random = np.random.default_rng(0)
    return lambda *shape: random.gamma(4, 0.25, shape).astype(np.float32)


def everything():
    """All that the file holds, and what of the scene's settings a render might turn."""
    blocks = {
        name: sorted(block.name_full for block in getattr(bpy.data, name))
        for name, kind in bpy.data.bl_rna.properties.items()
        if kind.type == "COLLECTION"
    }
    scene, render = bpy.context.scene, bpy.context.scene.render
    settings = {p.identifier: str(getattr(render, p.identifier)) for p in render.bl_rna.properties}
    result = bpy.data.images.get("Render Result")
    slot = (result.render_slots.active_index, len(result.render_slots)) if result else None
    return blocks, settings, scene.name, scene.frame_current, slot


def baked(scene, denoiser, **job):
    settings = RsmSettings(samples=8, denoise=denoiser)
    return tiles.finish(bake(scene, bpy.context.view_layer, Job(settings=settings, **job)))


def test_error_of_a_camera_image_falls_and_its_light_stays(cornell):
    cycles = camera_reference(cornell, bpy.context.view_layer, 256, 1, 3, (96, 96))["Diffuse Indirect"]
    none, bilateral, clean = (baked(cornell, d, resolution=96).layers for d in ("none", "bilateral", "oidn"))
    error = [metrics.relmse(layers["Diffuse Indirect"], cycles) for layers in (none, bilateral, clean)]
    assert error[2] < error[0] / 2 and error[2] < error[1]
    assert abs(metrics.bias(clean["Diffuse Indirect"], none["Diffuse Indirect"])) < 0.01
    for name in ("Diffuse Direct", "Diffuse Color", "Normal", "Position"):
        assert np.array_equal(clean[name], none[name]), name
    light = clean["Diffuse Direct"] + clean["Diffuse Indirect"]
    assert np.allclose(clean["Irradiance"], np.pi * light, rtol=1e-4, atol=1e-5)
    combined = clean["Diffuse Color"] * light + clean["Emission"]
    assert np.allclose(clean["Combined"][..., :3], combined, rtol=1e-4, atol=1e-5)


def test_direct_light_of_emitting_surfaces_is_denoised_too(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("emissive")))
    scene = bpy.context.scene
    cycles = camera_reference(scene, bpy.context.view_layer, 256, 1, 3, (64, 64))["Diffuse Direct"]
    none, clean = (baked(scene, d, resolution=64).layers["Diffuse Direct"] for d in ("none", "oidn"))
    assert metrics.relmse(clean, cycles) < metrics.relmse(none, cycles) / 2


def test_lightmaps_are_denoised_and_vertices_are_not(cornell):
    job = {"target": "lightmap", "objects": ("Tall box",), "resolution": 64}
    [many] = tiles.finish(
        bake(cornell, bpy.context.view_layer, Job(settings=RsmSettings(samples=1024, denoise="none"), **job))
    ).light.values()
    [none], [clean] = (baked(cornell, d, **job).light.values() for d in ("none", "oidn"))
    error = [metrics.relmse(light.indirect[many.centred], many.indirect[many.centred]) for light in (none, clean)]
    assert error[1] < error[0] / 3
    assert not clean.indirect[~clean.filled].any()

    none, clean = (baked(cornell, d, target="vertices") for d in ("none", "oidn"))
    assert all(np.array_equal(clean.light[name].indirect, none.light[name].indirect) for name in none.light)
    assert any("DENOISER_NOT_USED" in text for text in clean.warnings)


def test_black_around_an_island_does_not_darken_it(noise):
    side = 128
    row, column = np.mgrid[:side, :side]
    valid = (column // 32 % 2 == 0) & (row % 32 < 24)
    up = np.broadcast_to(np.float32([0, 0, 1]), (side, side, 3)) * valid[..., None]
    position = (np.stack([column, row, 0 * row], -1) * valid[..., None]).astype(np.float32)
    found = {"Color": 0.8 * np.abs(up[..., 2:]).repeat(3, -1), "Normal": up, "Position": position}
    found["Coverage"] = valid[..., None].astype(np.float32)
    [clean] = tiles.finish(denoise.smoothed([noise(side, side, 3) * valid[..., None]], [found]))
    inside = valid & np.all([np.roll(valid, s, a) for s in (1, -1) for a in (0, 1)], axis=0)
    assert abs(clean[valid & ~inside].mean() - clean[inside].mean()) < 0.03
    assert abs(clean[valid].mean() - 1) < 0.03


def test_any_range_survives(noise):
    ramp = np.geomspace(1e-2, 1e3, 128, dtype=np.float32)[None, :, None] * np.ones((128, 1, 3), np.float32)
    noisy = ramp * noise(*ramp.shape)
    clean = oidn(noisy)
    columns = (clean / ramp).mean((0, 2))
    # The darkest are a hundred thousandth of the brightest.
    assert np.all(np.abs(columns[16:] - 1) < 0.1)
    assert np.allclose(oidn(noisy * 1024), clean * 1024, rtol=0.01)
    assert clean.dtype == np.float32 and np.std(clean / ramp) < np.std(noisy / ramp) / 3


def test_edges_in_either_guide_stay(noise):
    stripe = np.arange(64)[None, :, None] // 16 % 2 == 0
    grey = np.full((64, 64, 3), 0.5, np.float32)
    true, albedo, normal = (
        np.where(stripe, *values).astype(np.float32) + 0 * grey
        for values in ((1.0, 0.5), (0.8, 0.3), ([0, 0, 1], [1, 0, 0]))
    )
    noisy = true * noise(64, 64, 3)
    unguided, by_albedo, by_normal = (
        np.mean((oidn(noisy, *guides) - true) ** 2) for guides in ((), (albedo, grey), (grey, normal))
    )
    assert by_albedo < unguided / 2 and by_normal < unguided / 2


@pytest.mark.parametrize("height, width", [(1, 1), (17, 5), (3, 70), (64, 64)])
def test_sizes_and_borders_keep_their_colour(height, width):
    image = np.full((height, width, 3), (0.2, 0.4, 0.8), np.float32)
    clean = oidn(image, albedo=np.full_like(image, 0.5), normal=np.full_like(image, 3**-0.5))
    assert clean.shape == image.shape and np.abs(clean / image - 1).max() < 0.02


def test_rows_and_columns_keep_their_places():
    image = np.full((48, 80, 3), 0.1, np.float32)
    image[:16, :40], image[32:, 60:, 2] = 1, 3
    assert np.abs(oidn(image) - image).mean() < 0.01


def test_what_cannot_be_denoised_is_refused():
    image = np.ones((8, 8, 3), np.float32)
    for bad in (np.nan, np.inf):
        broken = image.copy()
        broken[2, 3, 1] = bad
        with pytest.raises(ValueError, match="Image has 1 pixels that are not finite"):
            oidn(broken)
        with pytest.raises(ValueError, match="Normal has 1 pixels"):
            oidn(image, image, broken)
    with pytest.raises(ValueError, match="albedo"):
        oidn(image, normal=image)
    for wrong, albedo in ((image, image[:4]), (image[..., :1], None), (image[:0], None)):
        with pytest.raises(ValueError, match="shape"):
            oidn(wrong, albedo)


@pytest.fixture
def unreachable(monkeypatch):
    """Blender's compositor has to call the library."""
    monkeypatch.setattr(denoise.library, "library", lambda: None)


@pytest.mark.parametrize("guided", [0, 1, 2])
def test_the_library_makes_what_blenders_node_makes(noise, monkeypatch, guided):
    row, column = np.mgrid[:40, :64].astype(np.float32)
    image = noise(40, 64, 3) * column[..., None]
    albedo = np.where(row[..., None] < 20, 0.2, 0.8) * np.ones(3, np.float32)
    normal = np.where(column[..., None] < 20, (0, 0, 1), (1, 0, 0)).astype(np.float32)
    assert denoise.library.library()
    ours = oidn(image, *(albedo, normal)[:guided])
    monkeypatch.setattr(denoise.library, "library", lambda: None)
    assert np.allclose(ours, oidn(image, *(albedo, normal)[:guided]), rtol=1e-4, atol=1e-5)


@pytest.mark.parametrize("fails", [False, True])
@pytest.mark.parametrize("rendered", [False, True])
def test_nothing_is_left_in_the_file(cornell, noise, monkeypatch, unreachable, rendered, fails):
    if rendered:
        cornell.render.engine = "CYCLES"
        cornell.cycles.samples, cornell.render.resolution_percentage = 1, 1
        bpy.ops.render.render()
    before = everything()
    image = noise(16, 16, 3)
    if fails:
        monkeypatch.setattr(denoise.exr, "read_layers", lambda path: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            oidn(image, image, image)
    else:
        oidn(image, image, image)
    assert everything() == before


def test_a_blender_without_the_library_is_found_out_before_work(cornell, monkeypatch, unreachable):
    check = partial(preflight.check, cornell, bpy.context.view_layer, denoise="oidn")
    assert not check()
    # Such a Blender's node hands its input on; so does one that is switched off.
    made = denoise._denoise_node

    def muted(tree):
        node = made(tree)
        node.mute = True
        return node

    monkeypatch.setattr(denoise, "_denoise_node", muted)
    assert [(f.code, f.severity) for f in check()] == [("DENOISER_MISSING", "ERROR")]
    with pytest.raises(denoise.DenoiserMissing, match="denoise=bilateral"):
        oidn(np.random.default_rng(0).random((8, 8, 3), np.float32))


def test_islands_take_nothing_from_each_other(noise):
    side = 64
    column = np.mgrid[:side, :side][1]
    # A lit island and a dark one two texels apart, on one plane and of one colour.
    valid = (column < 31) | (column > 32)
    true = np.where(column < 31, 1.0, 0.02)[..., None].astype(np.float32)
    flat = np.broadcast_to(np.float32([0, 0, 1]), (side, side, 3)) * valid[..., None]
    position = (np.stack([column, np.mgrid[:side, :side][0], 0 * column], -1) * valid[..., None]).astype(np.float32)
    found = {"Color": 0.8 * flat[..., 2:].repeat(3, -1), "Normal": flat, "Position": position}
    found["Coverage"] = valid[..., None].astype(np.float32)
    # So noisy that the edge alone does not tell them apart.
    noisy = true * noise(side, side, 3) * noise(side, side, 3) * valid[..., None]
    [clean] = tiles.finish(denoise.smoothed_islands([noisy], [found]))
    beside, away = clean[:, 33:35].mean(), clean[:, 45:].mean()
    assert beside < 1.3 * away and abs(clean[:, :31].mean() / noisy[:, :31].mean() - 1) < 0.05
    assert not clean[~valid].any()


def test_auto_takes_it_for_camera_images_with_noise_where_it_works(cornell, monkeypatch):
    def taken(**job):
        settings = {"samples": 4, "light_samples": 1, "map_resolution": 32}
        kind = METHODS[job.get("method", "rsm")].settings
        known = {name: value for name, value in settings.items() if name in kind.__dataclass_fields__}
        job = Job(resolution=16, settings=kind(**known), **job)
        return tiles.finish(bake(cornell, bpy.context.view_layer, job)).job.settings.denoise

    assert taken() == "oidn"
    assert taken(method="lpv") == "bilateral"
    assert taken(target="lightmap", objects=("Tall box",)) == "bilateral"
    # As while Blender renders.
    monkeypatch.setattr(denoise.library, "library", lambda: None)
    monkeypatch.setattr(denoise.exr, "read_layers", raising)
    assert taken() == "bilateral"


def raising(path):
    raise RuntimeError("Blender cannot denoise now")
