# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchical wave front: flux at every distance, closed forms before a wall, cascades, walls that stop light."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from gi_bake.gi_core import lpv, rsm, sh, tiles
from gi_bake.gi_core.lpv import hierarchy
from gi_bake.gi_core.lpv.grid import Grid, box, cascades, fitted, levels, memory, placed
from gi_bake.gi_core.lpv.lookup import coefficients
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.settings import SettingError
from gi_bake.tests import shapes
from gi_bake.tests.core.test_lpv import ROOMS, leak, lights, points
from gi_bake.tests.core.test_sh import sphere

FREE = LpvSettings(visibility=False, blend=0.0)


def look(vpls, grids, at, normals, settings=FREE):
    """Irradiance at points in empty space: (n, 3)."""
    at = np.float32(at)
    wanted = [lpv.lookup.around(g, at) for g in grids]
    found = tiles.finish(hierarchy.propagated(None, vpls, grids, wanted, settings))
    return np.maximum(sh.evaluate(coefficients(None, tuple(found), settings, at), np.float32(normals)), 0)


@pytest.mark.parametrize("radius", [2, 4, 8, 16, 32])
@pytest.mark.parametrize("at", [(36.5, 36.5, 36.2), (36.1, 36.9, 36.4)])
def test_flux_through_spheres(radius, at):
    grid = Grid(np.zeros(3), 1.0, (73, 73, 73))
    d = sphere(2000)
    inward = look(lights(at, (0.6, 0, 0.8)), [grid], np.float32(at) + radius * d, -d)
    assert np.isclose(inward[:, 0].mean() * 4 * np.pi * radius**2, 1, atol=0.05)


def form_factor(half, height):
    x = half / height
    return 8 * (x / np.hypot(1, x)) * np.arctan(x / np.hypot(1, x)) / (2 * np.pi)


def test_before_an_emitting_wall():
    """The published scheme has .14 of the truth six cells away and nothing after twelve."""
    grid = Grid(np.zeros(3), 1.0, (72, 72, 72))
    x, y = np.meshgrid(np.arange(80) / 2 + 16.25, np.arange(80) / 2 + 16.25)
    wall = lights(np.column_stack([x.ravel(), y.ravel(), np.full(x.size, 20.0)]), flux=0.25)
    heights = np.array([1, 2, 4, 6, 8, 12, 16, 24, 32])
    before = np.column_stack([np.full((9, 2), 36.0), 20 + heights])
    both = look(wall, [grid], np.tile(before, (2, 1)), np.repeat([[0, 0, -1], [0, 0, 1]], 9, 0))[:, 0]
    assert np.allclose(both[:9], form_factor(20, heights), rtol=0.07)
    assert both[9:].max() < 0.025, "a surface that looks away stays dark"


def test_each_cascade_holds_all_light():
    outer = fitted((-16, -16, -16), (16, 16, 16), 34)
    grids = cascades(outer, 34, 3, 2, np.zeros(3))
    one = lights((-14.2, 0.3, 0.1), (1, 0, 0))
    at = [[0.3, 0.2, 0.1], [1.9, 1, -1]]
    towards = np.float32([-14.2, 0.3, 0.1]) - np.float32(at)
    towards /= np.linalg.norm(towards, axis=-1, keepdims=True)
    fine, coarse = look(one, grids, at, towards), look(one, grids[2:], at, towards)
    assert np.allclose(fine, coarse, rtol=0.06)
    assert fine.min() > 0


def test_no_seam_between_cascades():
    outer = fitted((-16, -16, -16), (16, 16, 16), 34)
    grids = cascades(outer, 34, 2, 2, np.zeros(3))
    x = np.linspace(4, 12, 81)
    line = np.column_stack([x, 0 * x + 0.3, 0 * x - 0.2])
    found = look(lights((-6, 0, 0), (1, 0, 0)), grids, line, np.tile([-1.0, 0, 0], (81, 1)), replace(FREE, blend=2.0))
    relative = np.diff(found[:, 0]) / found[1:, 0]
    assert np.all(relative < 0) and relative.min() > -0.06


def test_light_moved_by_whole_cells_moves_the_grid():
    grid = Grid(np.zeros(3), 0.5, (20, 20, 20))
    every = [np.arange(grid.size)]
    at = np.float32([4.1, 5.3, 4.7])
    found = []
    for move in ((0, 0, 0), (0.5, -1.0, 0.5)):
        one = lights(at + np.float32(move), (0, 0.6, 0.8))
        # One level: the coarser grids are not moved by whole cells of theirs.
        far = replace(FREE, reach=8.0)
        [level] = tiles.finish(hierarchy.propagated(None, one, [grid], every, far))
        found.append(level.irradiance.reshape(20, 20, 20, 9, 3))
    near = [slice(5, 13), slice(8, 14), slice(6, 13)]
    moved = tuple(slice(s.start + d, s.stop + d) for s, d in zip(near, (1, -2, 1)))
    assert np.allclose(found[0][tuple(near)], found[1][moved], rtol=2e-3, atol=1e-4)


def test_a_thin_wall_stops_light():
    assert leak() < 0.003
    assert leak(visibility=False) > 0.1


def test_a_furnace():
    """In a closed box that emits everywhere and reflects half of it, n bounces bring π L (ρ + … + ρⁿ) everywhere."""
    tracer = shapes.tracer([shapes.box(1)], material=shapes.matte(0.5, 1.0))
    rng = np.random.default_rng(1)
    floor = points(np.column_stack([rng.uniform(-0.95, 0.95, (64, 2)), np.full(64, -1.0)]))
    for bounces, expected in ((1, 0.5), (3, 0.875)):
        settings = LpvSettings(cells=16, cascades=1, bounces=bounces)
        volume = tiles.finish(lpv.emit(tracer, floor, settings))
        found = tiles.finish(lpv.indirect(tracer, floor, volume, settings))
        assert np.isclose(found.mean(), np.pi * expected, rtol=0.1)
        assert found.std() < 0.15 * found.mean()


def test_emissive_surfaces_are_in_the_volume_where_they_are_asked_for():
    tracer = shapes.tracer([shapes.box(1)], material=shapes.matte(0.0, 1.0))
    at = points([[0.1, 0.2, -1.0]])
    for share in (0.0, 0.5, 1.0):
        settings = LpvSettings(cells=16, cascades=1, emissive=share)
        volume = tiles.finish(lpv.emit(tracer, at, settings))
        assert np.isclose(tiles.finish(lpv.indirect(tracer, at, volume, settings)).mean(), np.pi * share, rtol=0.12)


def test_against_gathering_from_every_light():
    """A lit corner of a box, where gathering with shadow rays is exact."""
    tracer = shapes.tracer([shapes.box(1)], [shapes.lamp("SPOT", 20, (0.4, 0, 0.9), spot_angle=1.2)])
    rng = np.random.default_rng(2)
    wall = points(np.column_stack([np.full(256, -1.0), rng.uniform(-0.9, 0.9, (256, 2))]), (1, 0, 0))
    exact = RsmSettings(samples=512)
    truth = tiles.finish(rsm.indirect(tracer, wall, tiles.finish(rsm.emit(tracer, wall, exact)), exact)).mean(-1)
    settings = LpvSettings(cells=32, cascades=1)
    found = tiles.finish(lpv.indirect(tracer, wall, tiles.finish(lpv.emit(tracer, wall, settings)), settings)).mean(-1)
    assert abs(found.mean() / truth.mean() - 1) < 0.05
    assert np.mean(((found - truth) / truth.mean()) ** 2) < 0.01


def test_a_scene_without_light_or_geometry():
    at = points([[0, 0, 0]])
    for tracer in (shapes.tracer([shapes.box(1)]), shapes.tracer([])):
        volume = tiles.finish(lpv.emit(tracer, at, LpvSettings()))
        assert not tiles.finish(lpv.indirect(tracer, at, volume, LpvSettings())).any()


def test_directional_occlusion_and_intensity():
    at = points([[-0.5, 0, -0.9]])
    settings = LpvSettings(cells=16, cascades=1, map_resolution=64)
    volume = tiles.finish(lpv.emit(ROOMS, at, settings))
    plain = tiles.finish(lpv.indirect(ROOMS, at, volume, settings))
    twice = tiles.finish(lpv.indirect(ROOMS, at, volume, replace(settings, intensity=2.0)))
    assert np.allclose(twice, 2 * plain)
    hidden = replace(settings, directional_occlusion=0.75, occlusion_radius=64.0)
    assert np.allclose(tiles.finish(lpv.indirect(ROOMS, at, volume, hidden)), 0.25 * plain)
    near = replace(settings, directional_occlusion=0.75, occlusion_radius=0.5)
    assert np.allclose(tiles.finish(lpv.indirect(ROOMS, at, volume, near)), plain)


def test_grids():
    grid = fitted((0, 0, 0), (16, 2, 2.5), 32)
    assert grid.shape[0] == 32 and max(grid.shape[1:]) < 8
    assert np.all(grid.low < 0) and np.all(grid.high > (16, 2, 2.5))
    nested = cascades(grid, 32, 4, 2, np.array([3.0, 1, 1]))
    assert [round(nested[k + 1].cell / nested[k].cell) for k in range(3)] == [2, 2, 2]
    for fine, coarse in pairwise(nested):
        snapped = (fine.low - coarse.low) / coarse.cell
        assert np.allclose(snapped, np.round(snapped), atol=1e-6)
        assert np.all(fine.low >= coarse.low - 1e-9) and np.all(fine.high <= coarse.high + 1e-9)
        assert max(fine.shape) <= 32
    assert max(levels([grid], 2)[-1].shape) <= 4


def test_where_the_volume_lies():
    bounds, eye = np.array([[-8, -8, 0], [8, 8, 4]]), np.array([7.0, 7, 1])
    lit = np.float32([[-7, -7, 1]] * 3)
    assert placed(bounds, eye, lit, LpvSettings(center="camera"))[0].high[0] > 7
    assert placed(bounds, eye, lit, LpvSettings(center="receivers"))[0].low[0] < -7
    assert np.allclose((placed(bounds, eye, lit, LpvSettings(box="0 0 0, 2 2 2"))[-1].low + 1) / 2, 0.5, atol=0.1)
    for text in ("0 0 0", "a b c d e f", "0 0 0 0 1 1"):
        with pytest.raises(SettingError):
            box(text)


def test_as_many_cascades_as_hold_what_is_lit():
    bounds, rng = np.array([[-8, -8, 0], [8, 8, 4]]), np.random.default_rng(4)
    everywhere = rng.uniform(*bounds, (999, 3)).astype(np.float32)
    for lit, count in ((everywhere, 1), (everywhere / 2 * [1, 1, 2], 2), (everywhere / 8, 4), (everywhere[:1], 6)):
        assert len(placed(bounds, None, np.float32(lit), LpvSettings())) == count
    assert len(placed(bounds, None, None, LpvSettings())) == 1, "a volume of everything"
    assert len(placed(bounds, None, everywhere, LpvSettings(cascades=3))) == 3


def test_memory_is_known_before():
    settings = LpvSettings(cells=16, cascades=2, map_resolution=32)
    volume = tiles.finish(lpv.emit(ROOMS, points([[0.3, 0, 0]]), settings))
    assert volume.nbytes == memory(settings)
    assert memory(replace(settings, cascades=0)) == memory(replace(settings, cascades=6)), "at the most"
