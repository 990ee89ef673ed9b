# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Propagation as published, against what is known of it: conservation, its loss along the axis, symmetry, leaks."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import lpv, sh, tiles
from gi_bake.gi_core.kernels.lpv_inject import coefficients
from gi_bake.gi_core.kernels.lpv_propagate import FRONT, SIDE, step
from gi_bake.gi_core.lpv import flat
from gi_bake.gi_core.lpv.grid import Grid
from gi_bake.gi_core.lpv.injection import dense
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.surfels import Surfels
from gi_bake.gi_core.vpls import Vpls
from gi_bake.tests import shapes

FLAT = LpvSettings(propagation="flat", geometry_volume=False, injection_bias=0.0)


def lights(position, normal=(0, 0, 1), flux=1.0):
    position = np.float32(position).reshape(-1, 3)
    normal = np.broadcast_to(np.float32(normal), position.shape)
    return Vpls(position, position, normal, np.full_like(position, flux), np.ones(len(position), np.float32))


def spread(start, **changes):
    """The sum of all steps from coefficients (x, y, z, 4, 3): (4, x, y, z, 3)."""
    return tiles.finish(flat.spread(sh.affine(start), replace(FLAT, **changes)))


def one_cell(n, lobe):
    start = np.zeros((n, n, n, 4, 3), np.float32)
    start[n // 2, n // 2, n // 2] = lobe[:, None]
    return start


UP = sh.cosine_lobe(np.float32([0, 0, 1])) / np.float32(np.pi)


def flux(front):
    return 4 * np.pi * front[0].sum(dtype=np.float64) / 3


def test_solid_angles():
    assert np.isclose(6 * (FRONT + 4 * SIDE), 4 * np.pi, rtol=1e-9)
    # A unit square at half a unit, and a side face from its corners (Van Oosterom & Strackee 1983).
    assert np.isclose(FRONT, 4 * np.arctan(0.25 / (1.5 * np.sqrt(1.5**2 + 0.5))), rtol=1e-6)


def test_an_isotropic_cell_conserves_flux_whatever_the_steps():
    front = np.zeros((4, 21, 21, 21, 3), np.float32)
    front[0, 10, 10, 10] = 1 / (4 * np.pi)
    front = step(front)
    assert np.isclose(flux(front), 1, rtol=1e-5)
    # What has gone on is lobes, so isotropic cells again, with the same flux.
    for _ in range(5):
        isotropic = np.zeros_like(front)
        isotropic[0] = front[0]
        front = step(isotropic)
        assert np.isclose(flux(front), 1, rtol=1e-5)


def test_a_cosine_lobe_gains_13_8_percent_in_its_first_step():
    front = sh.affine(one_cell(5, UP))
    assert np.isclose(flux(front), 1, rtol=1e-5)
    assert np.isclose(flux(step(front)), 1.138, rtol=0.001)


def on_axis(total, n):
    """E over the truth before a lobe in the middle cell: 4 (u − n·v), n down, over Φ/(π d²)."""
    c = n // 2
    distance = np.arange(1, n - c)
    return 4 * (total[0, c, c, c + 1 :, 0] + total[3, c, c, c + 1 :, 0]) * np.pi * distance**2


def test_the_loss_along_the_axis():
    found = on_axis(spread(one_cell(33, UP), iterations=16), 33)[:8]
    assert np.allclose(found, [0.88, 1.15, 0.92, 0.65, 0.37, 0.21, 0.09, 0.04], rtol=0.02, atol=0.005)


def test_an_emitting_wall():
    """32 × 32 cells of radiosity 1: twice as bright as it should be before the wall, and gone after eight cells."""
    start = np.zeros((40, 40, 32, 4, 3), np.float32)
    start[4:36, 4:36, 2] = UP[:, None]
    total = spread(start, iterations=24)
    d = np.array([1, 2, 3, 4, 6, 8])
    x = 16 / d
    form_factor = 8 * (x / np.hypot(1, x)) * np.arctan(x / np.hypot(1, x)) / (2 * np.pi)
    found = 4 * (total[0, 20, 20, 2 + d, 0] + total[3, 20, 20, 2 + d, 0]) / form_factor
    assert np.allclose(found, [2.0, 1.33, 0.84, 0.50, 0.14, 0.03], rtol=0.02, atol=0.01)


def test_mirrored_light_gives_a_mirrored_grid():
    lobe = sh.cosine_lobe(np.float32([0.6, 0, 0.8]))
    mirrored = sh.cosine_lobe(np.float32([-0.6, 0, 0.8]))
    a, b = (spread(one_cell(11, c), iterations=6) for c in (lobe, mirrored))
    b = b[:, ::-1] * np.float32([1, -1, 1, 1])[:, None, None, None, None]
    assert np.allclose(a, b, atol=1e-7)


def test_light_moved_by_whole_cells_moves_the_grid():
    grid = Grid(np.zeros(3), 0.25, (16, 16, 16))
    at = np.float32([[1.6, 1.7, 1.3]])
    a, b = (dense(lights(p, (0.6, 0, 0.8)), grid, 0.5, False) for p in (at, at + np.float32([0.5, -0.25, 0.75])))
    a, b = (spread(x, iterations=3) for x in (a, b))
    assert a.any()
    assert np.allclose(np.roll(a, (2, -1, 3), (1, 2, 3)), b, atol=1e-7)


def test_iterations_end_when_the_front_is_spent():
    start = sh.affine(one_cell(17, UP))
    totals = [
        tiles.finish(flat.spread(start, replace(FLAT, iterations=0, front_share=share)))[0].sum()
        for share in (0.5, 0.1, 0.01)
    ]
    assert totals[0] < totals[1] < totals[2]
    assert np.isclose(totals[2], tiles.finish(flat.spread(start, replace(FLAT, iterations=256)))[0].sum(), rtol=0.05)


def test_tiles_do_not_show(monkeypatch):
    start = one_cell(13, sh.cosine_lobe(np.float32([0.48, -0.6, 0.64])))
    whole = spread(start, iterations=5)
    monkeypatch.setattr(flat, "_LAYERS", 3)
    assert np.array_equal(whole, spread(start, iterations=5))


def test_damping():
    weak = spread(one_cell(9, UP), iterations=1, damping=0.5) - sh.affine(one_cell(9, UP))
    full = spread(one_cell(9, UP), iterations=1) - sh.affine(one_cell(9, UP))
    assert np.allclose(weak, 0.5 * full)


def test_the_lobe_keeps_flux_and_the_other_form_does_not():
    grid = Grid(np.zeros(3), 1.0, (4, 4, 4))
    for at, share in (((1.5, 1.5, 1.2), 1.0), ((1.5, 1.5, 1.5), 0.0), ((1.5, 1.1, 1.5), 0.0)):
        one = lights(at, flux=3.0)
        assert np.isclose(sh.integral(dense(one, grid, 0.0, False))[1, 1, 1, 0], 3.0, rtol=1e-5)
        literal = sh.integral(dense(one, grid, 0.0, True))[1, 1, 1, 0]
        assert np.isclose(literal, 3.0 * share, atol=1e-5), "right only for a light straight below the middle"


def test_lambert_through_a_kernel():
    """The lobe's integral is the flux, its vector 2/3 of it along the normal."""
    found = coefficients(np.float32([[2, 4, 6]]), np.float32([[0, 0.6, 0.8]]))
    assert np.allclose(sh.integral(found), [[2, 4, 6]], rtol=1e-5)
    assert np.allclose(sh.vector(found)[0, 2], np.array([2, 4, 6]) * 0.8 * 2 / 3, rtol=1e-5)


def two_rooms():
    """A box with a wall across the middle and a lamp on one side of it, shining on the wall that faces it."""
    wall = shapes.quad((0, -1, -1), (0, 1, -1), (0, 1, 1), (0, -1, 1), name="wall")
    return shapes.tracer([shapes.box(1), wall], [shapes.lamp("POINT", 20, (-0.5, 0.1, 0.2))])


ROOMS = two_rooms()


def leak(**changes):
    """Light in the middle of the dark room over that in the lit one."""
    settings = LpvSettings(cells=16, cascades=1, map_resolution=64, **changes)
    both = points([[-0.5, 0, -0.9], [0.5, 0, -0.9], [-0.4, 0.3, -0.9], [0.4, 0.3, -0.9]])
    volume = tiles.finish(lpv.emit(ROOMS, both, settings))
    lit, dark, lit2, dark2 = tiles.finish(lpv.indirect(ROOMS, both, volume, settings)).mean(-1)
    return (dark + dark2) / (lit + lit2)


def points(positions, normal=(0, 0, 1)):
    here = np.float32(positions)
    up = np.broadcast_to(np.float32(normal), here.shape).copy()
    return Surfels(here, up, up, 0 * here, 0 * here, np.arange(len(here)))


def test_a_thin_wall_stops_light():
    assert leak(propagation="flat", injection_bias=0.5, iterations=16) < 0.03
    assert leak(propagation="flat", injection_bias=0.5, iterations=16, geometry_volume=False) > 0.06


def test_secondary_bounce_adds_light_and_less_than_came():
    at = points([[-0.5, 0, -0.9]])
    found = []
    for bounce in (0.0, 0.5, 1.0):
        settings = replace(FLAT, geometry_volume=True, cells=16, cascades=1, iterations=24, secondary_bounce=bounce)
        volume = tiles.finish(lpv.emit(ROOMS, at, settings))
        found.append(tiles.finish(lpv.indirect(ROOMS, at, volume, settings)).mean())
    assert found[0] * 1.02 < found[1] * 1.01 < found[2] < 3 * found[0]


@pytest.mark.parametrize("propagation", ["flat", "hierarchical"])
def test_the_same_settings_give_the_same_bytes(propagation):
    settings = LpvSettings(propagation=propagation, cells=16, cascades=2, map_resolution=32)
    at = points([[-0.5, 0, -0.9], [0.2, 0.3, -0.9]])
    a, b = (tiles.finish(lpv.emit(ROOMS, at, settings)) for _ in range(2))
    for one, other in zip(a.levels, b.levels):
        assert one.irradiance.tobytes() == other.irradiance.tobytes()
