# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space interpolation: reuse on even surfaces, none across edges, and nothing else changed."""

import logging
from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import surfels, tiles
from gi_bake.gi_core.kernels.lattice import lattice
from gi_bake.gi_core.rsm import Lighting, indirect, interpolation
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.scene import Camera
from gi_bake.gi_core.vpls import Vpls
from gi_bake.tests import shapes

# All lights for each point and no shadow rays: nothing is random.
EXACT = RsmSettings(pattern="all", visibility=False, interpolation=4)


def camera(at, to, side=48, angle=0.7):
    """A square pinhole camera; angle: of view [rad]."""
    back = np.subtract(at, to) / np.linalg.norm(np.subtract(at, to))
    right = np.cross((0, 1, 0) if abs(back[2]) > 0.99 else (0, 0, 1), back)
    right /= np.linalg.norm(right)
    matrix = np.eye(4)
    matrix[:3] = np.stack([right, np.cross(back, right), back, at], -1)
    half = np.tan(angle / 2)
    return Camera("PERSPECTIVE", matrix, (-half, half, -half, half), (side, side))


def ceiling(z, half=2.0, center=(0.0, 0.0), n=24):
    """Lights that shine down, n² over a square of radiosity 1 W/m²."""
    line = ((np.arange(n) + 0.5) / n * 2 - 1) * half
    x, y = np.meshgrid(line + center[0], line + center[1])
    at = np.stack([x.ravel(), y.ravel(), np.full(n * n, z)], -1).astype(np.float32)
    area = np.full(n * n, (2 * half / n) ** 2, np.float32)
    down = np.tile(np.float32([0, 0, -1]), (n * n, 1))
    return Lighting((), Vpls(at, at, down, np.repeat(area[:, None], 3, 1), area))


FLOOR = shapes.tracer([shapes.plate(0, 20)])
ABOVE, SLANTED = camera((0, 0, 3), (0, 0, 0)), camera((0, -3, 1.5), (0, 0, 0))


def both(tracer, eye, lighting, settings, subpixels=1):
    """What a camera sees, its light with interpolation and without, and the share that is reused."""
    seen = surfels.from_camera(tracer, eye, subpixels)
    mixed, share = tiles.finish(interpolation.interpolated_indirect(tracer, seen, lighting, settings, eye, subpixels))
    return seen, mixed[:, 0], tiles.finish(indirect(tracer, seen, lighting, settings))[:, 0], share


@pytest.mark.parametrize("eye", [ABOVE, SLANTED])
@pytest.mark.parametrize("cell, error", [(2, 0.01), (4, 0.03), (8, 0.07)])
def test_a_plane_is_reused_whole_and_nearly_exact(eye, cell, error):
    seen, mixed, full, share = both(FLOOR, eye, ceiling(2), replace(EXACT, interpolation=cell))
    lattice_line = len(set(range(0, 48, cell)) | {47})
    assert len(seen) == 48**2 and share == 1 - lattice_line**2 / 48**2
    # Light is not linear between lattice points.
    assert np.abs(mixed - full).max() < error * full.max()
    assert np.isclose(mixed.mean(), full.mean(), rtol=0.005)


def test_noise_is_the_lattices_and_the_mean_stays():
    """A lattice point takes as many samples as a pixel's subpixels together."""
    settings = RsmSettings(visibility=False, bound="disc", samples=16, interpolation=4)
    truth = both(FLOOR, ABOVE, ceiling(2), EXACT, 2)[2]
    _, mixed, full, _ = both(FLOOR, ABOVE, ceiling(2), settings, 2)
    assert np.isclose(mixed.mean(), truth.mean(), rtol=0.01)
    assert np.std(mixed - truth) < 0.5 * np.std(full - truth)


WALL = shapes.quad((0, -2, 0), (0, 2, 0), (0, 2, 2), (0, -2, 2), name="wall")
EDGES = {
    # The upper floor lies above the lights, which shine down.
    "depth": (
        shapes.tracer([shapes.plate(0, 2, center=(1, 0)), shapes.plate(1, 2, center=(-2, 0), name="upper")]),
        camera((0.3, 0.2, 4), (0, 0, 0)),
        ceiling(0.5),
        lambda p: p[:, 2] > 0.5,
    ),
    # The lights are behind the wall's back.
    "normal": (
        shapes.tracer([shapes.plate(0, 2, center=(-2, 0)), WALL]),
        camera((-3, 0.3, 2), (0, 0, 0.3)),
        ceiling(3, 2, (2.5, 0)),
        lambda p: p[:, 2] > 1e-4,
    ),
}


@pytest.mark.parametrize("edge", EDGES)
@pytest.mark.parametrize("cell", [2, 5, 8])
def test_nothing_is_mixed_across_an_edge(edge, cell):
    tracer, eye, lighting, dark = EDGES[edge]
    seen, mixed, full, share = both(tracer, eye, lighting, replace(EXACT, interpolation=cell))
    dark = dark(seen.position)
    assert min(dark.sum(), (~dark).sum()) > 200
    assert (mixed[dark] == 0).all()
    assert np.allclose(mixed[~dark], full[~dark], rtol=0.03) and full[~dark].min() > 0.01
    # And only near the edge is there a reason to gather.
    assert 0.4 < share < 1


def test_points_beside_nothing_gather_for_themselves():
    tracer = shapes.tracer([shapes.plate(0, 0.5)])
    seen, mixed, full, share = both(tracer, ABOVE, ceiling(2), replace(EXACT, interpolation=8))
    assert 0.2 < share < 0.9 and len(seen) < 48**2
    row, column = np.divmod(seen.place, 48)
    rim = (row == row.min()) | (row == row.max()) | (column == column.min()) | (column == column.max())
    assert np.allclose(mixed[rim], full[rim], rtol=1e-6)
    assert np.allclose(mixed, full, rtol=0.02)


@pytest.mark.parametrize("scale", [0.01, 100])
def test_the_scenes_unit_does_not_matter(scale):
    tracer, eye, lighting, _ = EDGES["depth"]
    low, high = (
        shapes.plate(z * scale, 2 * scale, center=(x * scale, 0), name=name)
        for z, x, name in ((0, 1, "plate"), (1, -2, "upper"))
    )
    matrix = eye.matrix.copy()
    matrix[:3, 3] *= scale
    near = both(tracer, eye, lighting, EXACT)[3]
    far = both(shapes.tracer([low, high]), replace(eye, matrix=matrix), lighting, EXACT)[3]
    assert np.isclose(near, far, atol=0.002)


def test_a_parallel_camera_reuses_too():
    eye = replace(ABOVE, kind="ORTHOGRAPHIC", window=(-1.0, 1.0, -1.0, 1.0))
    _, mixed, full, share = both(FLOOR, eye, ceiling(2), EXACT)
    assert share > 0.9 and np.allclose(mixed, full, rtol=0.02)


def test_a_cell_of_one_pixel_is_the_plain_gather():
    settings = RsmSettings(samples=16, bound="disc")
    _, mixed, full, share = both(FLOOR, SLANTED, ceiling(2), settings, 2)
    assert np.array_equal(mixed, full) and share == 0


def test_neither_tiles_nor_runs_show(monkeypatch):
    settings = RsmSettings(samples=16, bound="disc", interpolation=4)
    tracer, eye, lighting, _ = EDGES["depth"]
    first = both(tracer, eye, lighting, settings)[1]
    assert np.array_equal(first, both(tracer, eye, lighting, settings)[1])
    monkeypatch.setattr(interpolation, "TILE", 97)
    monkeypatch.setattr("gi_bake.gi_core.gathering._PAIRS", 7 * settings.samples)
    assert np.allclose(first, both(tracer, eye, lighting, settings)[1], rtol=1e-6)


def test_the_share_is_logged_and_progress_rises(caplog):
    seen = surfels.from_camera(FLOOR, ABOVE)
    with caplog.at_level(logging.INFO):
        work = interpolation.interpolated_indirect(FLOOR, seen, ceiling(2), EXACT, ABOVE, 1)
        progress = list(work)
    assert all(0 <= p <= 1 for p in progress) and progress == sorted(progress)
    assert "92.7 % of the points" in caplog.text


@pytest.mark.parametrize("size, step", [((13, 7), 4), ((16, 9), 8), ((5, 5), 64), ((1, 3), 2)])
def test_the_lattice_reproduces_what_is_linear(size, step):
    place = np.arange(size[0] * size[1])
    around, weight = lattice(place, size, step)
    for coordinate in (place % size[0], place // size[0]):
        assert np.allclose((weight * coordinate[around]).sum(-1), coordinate, atol=1e-5)
    assert np.allclose(weight.sum(-1), 1) and (weight >= 0).all()
    # All neighbours are points that gather, and those that gather are their own.
    own = weight.max(-1) == 1
    assert own[around].all()
    assert np.array_equal(around[own, weight[own].argmax(-1)], place[own])


def test_a_camera_that_sees_nothing():
    eye = camera((0, 0, 3), (0, 0, 6))
    _, mixed, _, share = both(FLOOR, eye, ceiling(2), EXACT)
    assert mixed.shape == (0,) and share == 0
