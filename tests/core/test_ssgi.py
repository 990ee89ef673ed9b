# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI as a whole: closed forms, rays through the scene as the measure of what the screen finds, light that
is out of sight, things that move."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import metrics, ssgi, surfels, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.scene import Camera, Environment
from gi_bake.gi_core.ssgi import pipeline
from gi_bake.gi_core.ssgi.frame import before, depth_map, direct_light, g_buffer, matching
from gi_bake.gi_core.ssgi.probes import bake_probes, unseen
from gi_bake.gi_core.ssgi.screen import Screen
from gi_bake.gi_core.ssgi.search import Search, searched
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.ssgi.sure import sure_pixels
from gi_bake.gi_core.trace import Tracer
from gi_bake.tests import shapes

RAW = SsgiSettings(denoise="none", fallback="none", samples=32, frames=4)


def camera(eye, target, view=25.0, resolution=(64, 64), kind="PERSPECTIVE"):
    """view: degrees across, or metres of a parallel one."""
    eye, target = np.array(eye, float), np.array(target, float)
    z = (eye - target) / np.linalg.norm(eye - target)
    x = np.cross((0, 0, 1), z) / np.linalg.norm(np.cross((0, 0, 1), z))
    matrix = np.eye(4)
    matrix[:3, :3], matrix[:3, 3] = np.stack([x, np.cross(z, x), z], -1), eye
    half = np.tan(np.radians(view) / 2) if kind == "PERSPECTIVE" else view / 2
    tall = half * resolution[1] / resolution[0]
    return Camera(kind, matrix, (-half, half, -tall, tall), resolution, (0.1, 100.0))


def corner(*lights, material=None, **more):
    """Three squares that meet at the origin, all in the picture, lit from before them."""
    floor = shapes.quad((0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), "floor")
    left = shapes.quad((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), "left")
    right = shapes.quad((0, 0, 0), (0, 0, 1), (1, 0, 1), (1, 0, 0), "right")
    lights = lights or (shapes.lamp("POINT", 10, (0.6, 0.5, 0.5)),)
    return shapes.tracer([floor, left, right], lights, material or shapes.matte(0.7), **more)


CORNER, VIEW = corner(), camera((3, 3, 3), (0.33, 0.33, 0.33))


def baked(tracer, camera, settings, **more):
    view = tiles.finish(ssgi.still(tracer, camera, settings, **more))
    return view.radiance, view.buffer.surface, view.history


@pytest.fixture(scope="module")
def traced():
    """What rays through the corner find, with one and with three bounces."""
    return {n: baked(CORNER, VIEW, replace(RAW, mode="ray_traced", samples=256, bounces=n))[0] for n in (1, 3)}


@pytest.mark.parametrize(
    "more",
    [
        {"mode": "screen_space", "steps": 256},
        {"mode": "screen_space", "steps": 256, "bounces": 3},
        {"mode": "screen_space", "steps": 256, "full_resolution": False, "samples": 512},
        {"mode": "screen_space", "steps": 24, "tracer": "bitmask", "samples": 64},
        {"mode": "mixed"},
        {"mode": "mixed", "bounces": 3},
    ],
)
def test_where_all_is_on_the_screen_the_screen_is_enough(traced, more):
    radiance, surface, _ = baked(CORNER, VIEW, replace(RAW, **{"samples": 256} | more))
    if radiance.shape != traced[1].shape:
        surface = surface & np.isfinite(radiance).all(-1)
        reference = traced[more.get("bounces", 1)][::2, ::2]
    else:
        reference = traced[more.get("bounces", 1)]
    # Not only on the whole: left, right and bottom, in the creases and at the rims.
    side = surface.shape[0] // 8

    def blocks(image):
        return (image * surface).reshape(8, side, 8, side).sum((1, 3))

    full = blocks(np.ones(surface.shape)) > side * side / 4
    off = blocks((radiance - reference).mean(-1)) / np.maximum(blocks(reference.mean(-1)), 1e-9)
    assert full.sum() > 30 and np.abs(off[full]).max() < 0.03, np.round(100 * off * full, 1)


def test_the_error_falls_with_the_samples():
    reference = baked(CORNER, VIEW, replace(RAW, mode="ray_traced", samples=512))[0]
    errors = []
    for samples in (8, 32, 128):
        radiance, surface, _ = baked(CORNER, VIEW, replace(RAW, mode="ray_traced", samples=samples, seed=1))
        errors.append(metrics.relmse(radiance[surface], reference[surface]))
    slope = np.polyfit(np.log((8, 32, 128)), np.log(errors), 1)[0]
    assert slope < -0.9


@pytest.mark.parametrize("mode", ["ray_traced", "mixed"])
def test_a_furnace(mode):
    """In a closed box that emits L everywhere and reflects ρ, k bounces bring E/π = L (ρ + … + ρᵏ), everywhere."""
    tracer = shapes.tracer([shapes.box(1)], material=shapes.matte(0.6, 1.0))
    inside = camera((-0.9, -0.8, 0.7), (0.5, 0.4, -0.3), 70, (24, 24))
    for bounces in (1, 2):
        settings = replace(RAW, mode=mode, bounces=bounces, samples=64)
        found = baked(tracer, inside, settings)[0]
        assert np.isclose(found.mean(), sum(0.6**k for k in range(1, bounces + 1)), rtol=0.02)


def test_off_is_black_and_a_picture_of_nothing_too():
    assert not baked(CORNER, VIEW, replace(RAW, mode="off"))[0].any()
    away = camera((3, 3, 3), (6, 6, 6))
    for mode in ("screen_space", "ray_traced", "mixed"):
        for denoise in ("none", "bilateral"):
            radiance, surface, _ = baked(CORNER, away, replace(RAW, mode=mode, denoise=denoise))
            assert not surface.any() and not radiance.any()


def test_the_same_settings_give_the_same_picture():
    settings = SsgiSettings(samples=4, frames=2, bounces=2)
    one, other = (baked(CORNER, VIEW, settings)[0] for _ in range(2))
    assert np.array_equal(one, other)
    assert not np.array_equal(one, baked(CORNER, VIEW, replace(settings, seed=1))[0])


def test_a_parallel_camera_sees_the_same_light():
    flat = camera((3, 3, 3), (0.33, 0.33, 0.33), 2.0, (48, 48), "ORTHOGRAPHIC")
    reference, surface, _ = baked(CORNER, flat, replace(RAW, mode="ray_traced", samples=64))
    for more in ({"steps": 256}, {"tracer": "bitmask", "steps": 32}):
        found = baked(CORNER, flat, replace(RAW, mode="screen_space", **more))[0]
        assert abs(metrics.bias(found[surface], reference[surface])) < 0.03


def test_feeding_the_previous_picture_back_adds_bounces():
    """HDRP's way: each pass sees the last one's picture, so many passes approach all bounces."""
    view = replace(VIEW, resolution=(40, 40))
    settings = replace(RAW, mode="screen_space", steps=256, feedback="previous", samples=80, frames=80)
    many, surface, _ = baked(CORNER, view, replace(settings, accumulation="hdrp"))
    reference = baked(CORNER, view, replace(RAW, mode="ray_traced", samples=128, bounces=8))[0]
    one = baked(CORNER, view, replace(RAW, mode="ray_traced", samples=128))[0]
    assert abs(metrics.bias(many[surface], reference[surface])) < 0.03
    assert metrics.bias(many[surface], one[surface]) > 0.1


def test_clamping_takes_light():
    free = baked(CORNER, VIEW, replace(RAW, mode="mixed"))[0]
    held = baked(CORNER, VIEW, replace(RAW, mode="mixed", clamp=0.05))[0]
    assert held.max() <= 0.05 + 1e-6 < free.max() and held.mean() < free.mean()


def test_the_filters_take_noise_and_keep_light_and_edges(traced):
    noisy, surface, _ = baked(CORNER, VIEW, replace(RAW, mode="ray_traced"))
    clean = baked(CORNER, VIEW, replace(RAW, mode="ray_traced", denoise="bilateral", radius=0.15))[0]
    error = [metrics.relmse(a[surface], traced[1][surface]) for a in (noisy, clean)]
    assert error[1] < 0.4 * error[0]
    assert abs(metrics.bias(clean[surface], traced[1][surface])) < 0.02


def test_filters_run_where_their_result_counts(monkeypatch):
    """Once over a still, however many passes; in each pass where what they make is fed back or forgotten; and where a
    picture starts from an earlier one."""
    runs, filtered = [], pipeline._filtered
    monkeypatch.setattr(pipeline, "_filtered", lambda *a: runs.append(a[-1]) or filtered(*a))
    settings = replace(RAW, mode="ray_traced", denoise="bilateral", samples=4)
    view = replace(VIEW, resolution=(24, 24))
    _, surface, history = baked(CORNER, view, settings)
    assert runs == [range(4), None] and history.behind == 0 and (history.count[surface] == 4).all()
    for more, expected in (
        ({"feedback": "previous", "mode": "screen_space"}, 8), ({"accumulation": "hdrp"}, 8), ({"frames": 1}, 2),
    ):  # fmt: skip
        runs.clear()
        baked(CORNER, view, replace(settings, **more))
        assert len(runs) == expected
    runs.clear()
    later = baked(CORNER, view, settings, history=history)[2]
    assert runs == [range(4, 5), None, range(5, 8), None] and (later.count[surface] == 8).all()


# A room whose lamp, and most of what it shines on, is behind the camera's back.
ROOM = shapes.tracer([shapes.box(1)], [shapes.lamp("SPOT", 60, (0.5, -0.5, 0.8), spot_angle=1.5)], shapes.matte(0.6))
ASIDE = camera((-0.2, 0, 0), (-0.7, 1, 0.2), 50, (48, 48))


def test_light_from_the_corner_of_the_eye():
    """Probes bring what comes from beyond the picture: at least twice as close to the truth."""
    truth, surface, _ = baked(ROOM, ASIDE, replace(RAW, mode="ray_traced", samples=256))
    settings = replace(RAW, mode="screen_space", samples=32)
    error = {}
    for name, more in {
        "none": {"fallback": "none"}, "grid": {"fallback": "probes"}, "both": {}, "lpv": {"probes": "lpv"},
    }.items():  # fmt: skip
        found = baked(ROOM, ASIDE, replace(settings, **{"fallback": "both"} | more))[0]
        error[name] = np.sqrt(metrics.relmse(found[surface], truth[surface]))
    assert max(error["grid"], error["lpv"]) < 0.5 * error["none"] and error["both"] == error["grid"]


def test_probes_are_right_in_a_furnace_and_blind_behind_walls():
    tracer = shapes.tracer([shapes.box(1)], material=shapes.matte(0.6, 1.0))
    volume = tiles.finish(bake_probes(tracer, SsgiSettings(probe_cells=4, bounces=2)))
    inside = surfels.from_camera(tracer, camera((0, 0, 0), (1, 0.3, 0.2), 60, (8, 8)))
    irradiance, weight = volume(inside)
    assert np.allclose(weight, 1, atol=1e-5) and np.allclose(irradiance, np.pi * (0.6 + 0.36), rtol=0.05)
    # A lid close above a floor: no probe between them, none sees the gap.
    plates = [shapes.plate(0, 1), shapes.plate(0.01, 1, name="lid"), shapes.plate(2, 1, name="ceiling")]
    tracer = shapes.tracer(plates, [shapes.lamp("POINT", 9, (0, 0, 1))])
    volume = tiles.finish(bake_probes(tracer, SsgiSettings(probe_cells=4)))
    gap = surfels.at(tracer.geometry, np.zeros(1, int), np.full((1, 3), 1 / 3, np.float32), np.zeros(1))
    assert volume(gap)[1] == 0


def test_the_sky_counts_once():
    """Direct light has the sky where rays reach it; the fallback stands in only for what hides it."""
    sky = Environment(np.ones(3, np.float32))
    plate, lid = shapes.plate(0, 1), shapes.plate(0.5, 50, up=False, name="lid")
    up = np.array([[0, 0, 1]], np.float32)
    for meshes, expected in (([plate], 0.0), ([plate, lid], 1.0)):
        tracer = shapes.tracer(meshes, environment=sky)
        point = surfels.at(tracer.geometry, np.zeros(1, int), np.full((1, 3), 1 / 3, np.float32), np.zeros(1))
        assert np.allclose(unseen("sky", tracer, point, up, None), expected)
        assert not unseen("none", tracer, point, up, None).any()


def test_any_light_at_points_can_stand_in_for_the_probes():
    def one(points):
        return np.full((len(points), 3), 2.0, np.float32), np.ones(len(points), np.float32)

    point = surfels.at(CORNER.geometry, np.zeros(1, int), np.full((1, 3), 1 / 3, np.float32), np.zeros(1))
    up = np.array([[0, 0, 1]], np.float32)
    assert np.allclose(unseen("both", CORNER, point, up, one), 2 / np.pi)
    held = baked(CORNER, VIEW, replace(RAW, mode="screen_space", fallback="probes"), probes=one)[0]
    assert held.mean() > baked(CORNER, VIEW, replace(RAW, mode="screen_space"))[0].mean() + 0.05


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_the_screen_is_the_camera(kind):
    """Pixels project back to themselves; a ray's device depth is linear; a pixel's plane is its neighbours'."""
    view = camera((3, 2, 2.5), (0.3, 0.3, 0.3), 30 if kind == "PERSPECTIVE" else 2, (40, 24), kind)
    view = replace(view, window=(view.window[0] + 0.05, view.window[1] + 0.05, *view.window[2:]))
    buffer = tiles.finish(g_buffer(CORNER, Screen(view)))
    y, x = np.nonzero(buffer.surface)
    at = buffer.screen.project(buffer.position[y, x])
    assert np.allclose(at[:, :2], np.stack([x, y], -1), atol=2e-3) and np.allclose(at[:, 2], buffer.depth[y, x])
    half = buffer[2]
    there = half.screen.project(half.position[half.surface])
    assert np.allclose(there[:, :2], np.argwhere(half.surface)[:, ::-1], atol=2e-3)

    start, way = buffer.position[y, x], np.random.default_rng(0).normal(0, 1, (len(x), 3)).astype(np.float32)
    image = np.concatenate([at[:, :2], buffer.screen.device(at[:, 2:])], -1)
    on = buffer.screen.project(start + 0.1 * way)
    moved = np.concatenate([on[:, :2], buffer.screen.device(on[:, 2:])], -1) - image
    direction = buffer.screen.march(start, way)
    moved, direction = (a / np.linalg.norm(a[:, :2], axis=-1, keepdims=True) for a in (moved, direction))
    steep = np.linalg.norm(direction, axis=-1) > 10
    assert np.allclose(moved[~steep], direction[~steep], atol=0.02)

    depth, *slope = tiles.finish(depth_map(buffer)).cells[: buffer.depth.size].T.reshape(3, *buffer.depth.shape)
    floor = buffer.surface & (buffer.position[..., 2] < 1e-4)
    pair = floor[:, 1:] & floor[:, :-1]
    step = np.diff(depth, axis=1)[pair]
    assert pair.sum() > 20 and np.allclose(step, slope[0][:, :-1][pair], rtol=0.02, atol=1e-6)


def moved_mesh(mesh, by):
    return replace(mesh, vertices=(mesh.vertices + by).astype(np.float32))


def test_motion_counts_camera_objects_and_deformation():
    still_plate, sheet = shapes.plate(0, 1), shapes.plate(0.5, 0.4, name="sheet")
    then = Geometry(shapes.scene([still_plate, sheet]))
    # The sheet bends: one corner lifts. And the list of objects changes its order.
    lift = np.array([[0, 0, 0], [0, 0, 0], [0, 0, 0.2], [0, 0, 0]], np.float32)
    bent = replace(sheet, vertices=sheet.vertices + lift)
    now = Tracer(Geometry(shapes.scene([bent, still_plate, shapes.plate(0.9, 0.1, name="new", center=(-0.8, -0.8))])))
    view = camera((0, -2.5, 2), (0, 0, 0.2), 50, (48, 32))
    shifted = replace(view, matrix=view.matrix + np.pad(np.array([[0.1], [0], [0]]), ((0, 1), (3, 0))))
    earlier = tiles.finish(g_buffer(Tracer(then), Screen(shifted)))
    buffer = tiles.finish(g_buffer(now, Screen(view)))
    at, where = before(buffer, earlier)

    name = np.array([i.name for i in now.geometry.scene.instances])[now.geometry.instance[buffer.triangle.ravel()]]
    seen = buffer.surface.ravel()
    position = buffer.position.reshape(-1, 3)
    floor, moving, new = (seen & (name == n) for n in ("plate", "sheet", "new"))
    assert np.allclose(where[floor], position[floor], atol=1e-5)
    assert np.allclose(where[moving][:, 2], 0.5, atol=1e-5) and np.allclose(
        where[moving][:, :2], position[moving][:, :2], atol=1e-5
    )
    assert (position[moving][:, 2] > 0.55).any()
    assert new.any() and np.isnan(where[new]).all() and np.isnan(at[~seen]).all()
    assert np.allclose(at[floor], earlier.screen.project(position[floor]), atol=1e-4)
    assert (matching(now.geometry, then)[-2:] == -1).all()


def test_history_is_carried_to_where_things_went():
    """A plate that moves sideways keeps its passes; what it uncovers starts anew."""
    plate, lid = shapes.plate(0, 2), shapes.plate(0.5, 0.5, name="lid")
    lamp = shapes.lamp("POINT", 10, (0, 0, 2))
    view = camera((0, -0.01, 5), (0, 0, 0), 40, (48, 48))
    settings = replace(RAW, mode="ray_traced", samples=4, frames=4, motion_rejection=False)
    first = Tracer(Geometry(shapes.scene([plate, lid], [lamp])))
    history = baked(first, view, settings)[2]
    second = Tracer(Geometry(shapes.scene([plate, moved_mesh(lid, (0.35, 0, 0))], [lamp])))
    _, _, history = baked(second, view, replace(settings, frames=1, samples=1), history=history)
    count, buffer = history.count, history.buffer
    on_lid = buffer.position[..., 2] > 0.4
    x = buffer.position[..., 0]
    assert np.isclose(count[on_lid], 5).mean() > 0.9
    uncovered = ~on_lid & (x > -0.45) & (x < -0.25) & (np.abs(buffer.position[..., 1]) < 0.4)
    assert uncovered.any() and np.isclose(count[uncovered], 1).mean() > 0.9
    assert np.isclose(count[~on_lid & (x < -1)], 5).all()


def test_what_moves_may_forget():
    """With rejection a plate that moves starts anew; what stands still keeps all, also before a camera that moves."""
    plate, lid = shapes.plate(0, 2), shapes.plate(0.5, 0.5, name="lid")
    view = camera((0, -0.01, 5), (0, 0, 0), 40, (48, 48))
    settings = replace(RAW, mode="ray_traced", samples=4, frames=4)
    history = baked(Tracer(Geometry(shapes.scene([plate, lid]))), view, settings)[2]
    moved = replace(view, matrix=view.matrix + np.pad([[0.1], [0.05], [0]], ((0, 1), (3, 0))))
    once = replace(settings, frames=1, samples=1)
    for lid_now, on_camera, passes in ((lid, moved, 5), (moved_mesh(lid, (0.02, 0, 0)), view, 1)):
        now = Tracer(Geometry(shapes.scene([plate, lid_now])))
        later = baked(now, on_camera, once, history=history)[2]
        at = later.buffer.position
        assert np.isclose(later.count[at[..., 2] > 0.4], passes).all()
        open_floor = (at[..., 2] < 0.1) & (np.abs(at[..., :2]).max(-1) > 0.7) & (np.abs(at[..., :2]).max(-1) < 1.2)
        assert open_floor.any() and np.isclose(later.count[open_floor], 5).all()


def test_filtering_at_half_resolution_keeps_light_and_takes_noise(traced):
    noisy, surface, _ = baked(CORNER, VIEW, replace(RAW, mode="ray_traced"))
    error = {}
    for half in (False, True):
        more = {"denoise": "bilateral", "radius": 0.3, "half_filter": half}
        found = baked(CORNER, VIEW, replace(RAW, mode="ray_traced", **more))[0]
        error[half] = metrics.relmse(found[surface], traced[1][surface])
        assert found.shape == noisy.shape and abs(metrics.bias(found[surface], traced[1][surface])) < 0.02
    assert error[False] != error[True] and max(error.values()) < 0.5 * metrics.relmse(
        noisy[surface], traced[1][surface]
    )


def test_light_at_points_and_how_surely_it_was_seen():
    view = tiles.finish(ssgi.still(CORNER, VIEW, replace(RAW, mode="ray_traced", samples=64)))
    points = view.buffer.surfels()
    irradiance, coverage = tiles.finish(ssgi.seen([view], points))
    h, w = view.buffer.depth.shape
    assert np.allclose(irradiance, np.pi * view.radiance.reshape(h * w, 3)[points.place], rtol=1e-2, atol=1e-4)
    assert (coverage > 0.9).all()
    # The floor's underside, and a point behind the camera.
    below = points[:5].turned(np.ones(5, bool))
    behind = replace(points[:5], position=points[:5].position + np.float32(10))
    for hidden in (below, behind):
        assert (tiles.finish(ssgi.seen([view], hidden))[1] < 0.01).all()


def test_pixels_are_sure_where_their_neighbours_are_alike():
    """Against plain loops, over a picture with silhouettes, a crease, a shadow's edge and background."""
    lid = shapes.plate(0.4, 0.25, name="lid", center=(0.5, 0.5))
    wall = shapes.quad((0, 0, 0), (0, 1, 0), (0, 1, 1), (0, 0, 1), "wall")
    tracer = shapes.tracer([shapes.plate(0, 1, center=(1, 1)), lid, wall], [shapes.lamp("POINT", 10, (0.7, 0.6, 2))])
    full = tiles.finish(g_buffer(tracer, Screen(camera((3, 2.5, 3), (0.5, 0.5, 0.1), 30, (31, 22)))))
    light = full.albedo * tiles.finish(direct_light(tracer, full, 1, 1, 0))
    sure, (h, w) = sure_pixels(full, light), full.surface.shape
    for y in range(h):
        for x in range(w):
            expected = full.surface[y, x]
            for j, i in np.argwhere(np.ones((3, 3))) - 1 + (y, x):
                if (j, i) == (y, x) or not (0 <= j < h and 0 <= i < w):
                    continue
                apart = full.position[j, i] - full.position[y, x]
                off = max(abs(apart @ full.face[y, x]), abs(apart @ full.face[j, i]))
                less, more = sorted((light[y, x].max(), light[j, i].max()))
                flat = full.surface[j, i] and off <= 0.25 * np.linalg.norm(apart)
                expected &= flat and more - less <= 0.3 * less + 1e-4 * light.max(-1).mean()
            assert sure[y, x] == expected
    assert 0.2 < sure.mean() < 0.9 and not sure[~full.surface].any()


def test_a_pixel_is_met_from_afar_only():
    """Mixed leaves to the tracer what is so near that the pixels that show it have a size."""
    view = replace(VIEW, resolution=(48, 48))
    full = tiles.finish(g_buffer(CORNER, Screen(view)))
    found = {}
    for mode in ("screen_space", "mixed"):
        search = Search(CORNER, full, full, replace(RAW, mode=mode, samples=8, frames=1, mixed_steps=64), None)
        hit = tiles.finish(searched(search, None, 0)).hit.reshape(-1, 8)
        rows = np.nonzero(hit >= 0)
        there = hit[rows]
        size = full.screen.footprint(full.depth.ravel()[there])
        view_ray = full.screen.towards(full.position.reshape(-1, 3)[there])
        size = size / np.abs(np.sum(full.face.reshape(-1, 3)[there] * view_ray, -1))
        away = full.position.reshape(-1, 3)[there] - full.position.reshape(-1, 3)[search.places[rows[0]]]
        found[mode] = np.linalg.norm(away, axis=-1) / size
    assert found["screen_space"].min() < 3 and found["mixed"].min() > 3.9 and len(found["mixed"]) > 1000
