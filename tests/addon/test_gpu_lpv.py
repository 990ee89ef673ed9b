# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light propagation volumes on the graphics card: each kernel against numpy's, and whole volumes of sample scenes."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.bvh import build
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.kernels.added import added
from gi_bake.gi_core.kernels.lpv_arriving import arriving
from gi_bake.gi_core.kernels.lpv_inject import coefficients, summed
from gi_bake.gi_core.kernels.lpv_propagate import layer_sums, step
from gi_bake.gi_core.kernels.lpv_received import received
from gi_bake.gi_core.kernels.lpv_transfer import sharpened
from gi_bake.gi_core.kernels.lpv_trilinear import trilinear
from gi_bake.gi_core.lpv import flat
from gi_bake.gi_core.lpv.settings import LpvSettings

GRIDS = [(1, 1, 1), (2, 1, 5), (5, 7, 3), (9, 8, 11)]
FLAT = LpvSettings(propagation="flat", light="indirect", map_resolution=64, cells=16, cascades=2)


def random(*shape, seed=0):
    return np.random.default_rng(seed).random(shape, np.float32)


def units(n, seed=0):
    v = np.random.default_rng(seed).normal(0, 1, (n, 3)).astype(np.float32)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


@pytest.mark.parametrize("n", [0, 1, 64, 1000])
def test_injection(same, n):
    flux, normal, towards = random(n, 3), units(n), random(n, 3, seed=1) - np.float32(0.5)
    towards[::7] = 0
    same(coefficients, flux, normal)
    same(coefficients, flux, normal, towards)
    cell = np.random.default_rng(n).integers(0, 70, n)
    for columns in ((4, 3), (7,), ()):
        # The order of summation differs.
        same(summed, cell, random(n, *columns), 75, tolerance=1e-3)


def test_more_lights_in_a_cell_than_a_loop_has_turns(same):
    """Mesa's driver in software leaves loops after 65535 turns."""
    n = 70_000
    same(summed, np.full(n, 2), random(n, 4, 3), 3, tolerance=1e-3)
    vector, rest = sharpened(coefficients(random(n, 3), units(n)))
    sent = random(n, 3, seed=1), vector, rest, rest.mean(-1) + np.float32(0.1), np.zeros((n, 4, 3), np.float32)
    same(arriving, random(2, 3, seed=2), *sent, 0, np.inf, 0.1, tolerance=1e-3)


@pytest.mark.parametrize("grid", GRIDS)
def test_a_step_of_propagation(same, grid):
    front = random(4, *grid, 3)
    front[1:] = front[1:] * 2 - 1
    same(step, front)
    same(step, front, None, None, 0.82)
    same(step, front, random(3, *grid))
    same(step, front, random(3, *grid), random(3, *grid, 3, seed=1), 0.9)


@pytest.mark.parametrize("grid", GRIDS)
def test_what_layers_hold(same, grid):
    # The order of summation differs.
    same(layer_sums, random(4, *grid, 3), tolerance=1e-3)
    same(added, random(4, *grid, 3), random(4, *grid, 3, seed=1))
    same(added, random(0, 3), random(0, 3))


@pytest.mark.parametrize("grid", GRIDS)
@pytest.mark.parametrize("n", [0, 1, 64, 1000])
@pytest.mark.parametrize("bands", [4, 9])
def test_the_look_up(same, grid, n, bands):
    values, local = random(np.prod(grid), bands, 3), random(n, 3, seed=1) * np.float32([g + 2 for g in grid]) - 1
    share = random(n, seed=2) * (random(n, seed=3) > 0.3)
    same(trilinear, values, local, grid, share)
    same(trilinear, values, local, grid, share, random(n, bands, 3, seed=4))


@pytest.mark.parametrize("cells, n", [(0, 5), (5, 0), (1, 1), (65, 3), (300, 70)])
@pytest.mark.parametrize("inner, outer", [(0, np.inf), (0, 0.8), (0.3, np.inf)])
def test_what_goes_straight_to_cells(same, cells, n, inner, outer):
    middles, centre = random(cells, 3), random(n, 3, seed=1)
    vector, rest = sharpened(coefficients(random(n, 3, seed=2), units(n)) + random(n, 4, 3, seed=3) * np.float32(0.1))
    ahead = (np.sqrt(np.einsum("nac,nac->nc", vector, vector)) + rest).mean(-1)
    corners = random(40, 1, 3, seed=4) + 0.2 * random(40, 3, 3, seed=5)
    bvh = build(corners.reshape(-1, 3), np.arange(120).reshape(-1, 3))
    starts = centre[:, None] + np.float32(0.01) * random(n, 4, 3, seed=6)
    for between in (None, bvh):
        # The order of summation differs.
        same(arriving, middles, centre, vector, rest, ahead, starts, inner, outer, 0.1, between, tolerance=1e-3)


@pytest.mark.parametrize("n", [0, 1, 64, 1000])
@pytest.mark.parametrize("bands", [4, 9])
def test_what_surfaces_get_of_it(same, n, bands):
    normal = random(n, 3) * 2 - 1
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    found, ahead = random(n, bands, 3, seed=1) - np.float32(0.3), random(n, bands, 3, seed=2)
    same(received, found, normal, random(n))
    same(received, found, normal, random(n), ahead, 1.7)


def test_all_iterations_stay_on_the_device(gpu, monkeypatch):
    front = random(4, 12, 10, 9, 3)
    walls = random(3, 12, 10, 9), random(3, 12, 10, 9, 3)
    for settings in (replace(FLAT, iterations=12), replace(FLAT, iterations=0, front_share=0.05)):
        expected = tiles.finish(flat.spread(front, settings, *walls))
        np.testing.assert_allclose(
            tiles.finish(flat.spread(front, settings, *walls, gpu)), expected, rtol=1e-3, atol=1e-4 * expected.max()
        )
    moved = []
    for iterations in (3, 12):
        before = gpu.moved
        tiles.finish(flat.spread(front, replace(FLAT, iterations=iterations), *walls, gpu))
        moved.append(gpu.moved - before)
    assert moved[0] == moved[1] > 0


@pytest.mark.parametrize("more", [{}, {"iterations": 0}, {"secondary_bounce": 0.5, "derivative_damping": 1.0}])
def test_a_bake_is_the_same_on_both(gpu, sample, more):
    found = []
    for device in ("cpu", "gpu"):
        bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
        job = Job("lpv", resolution=32, settings=replace(FLAT, device=device, **more))
        found.append(tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job)))
    assert found[0].device == NUMPY.name and found[1].device.startswith("gpu")
    expected, got = (one.layers["Diffuse Indirect"] for one in found)
    assert expected.mean() > 0.01
    assert metrics.relmse(got, expected) <= 1e-5
