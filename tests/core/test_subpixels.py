# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pixels whose subpixels see one surface, and those that do not."""

import numpy as np
import pytest
from gi_bake.gi_core import surfels
from gi_bake.gi_core.sampling import hash01
from gi_bake.gi_core.scene import Camera
from gi_bake.gi_core.subpixels import alike
from gi_bake.tests import shapes

SIDE = 64


def looking_down(slant=0.0):
    """A camera 3 m from the origin, turned about X [rad]."""
    c, s = np.cos(slant), np.sin(slant)
    matrix = np.eye(4)
    matrix[:3] = [[1, 0, 0, 0], [0, c, -s, 3 * -s], [0, s, c, 3 * c]]
    return Camera("PERSPECTIVE", matrix, (-0.4, 0.4, -0.4, 0.4), (SIDE, SIDE))


def seen_and_alike(tracer, eye, subpixels, rows=slice(None), seed=0):
    rows = slice(*rows.indices(SIDE * subpixels))
    seen = surfels.from_camera(tracer, eye, subpixels, rows)
    place = seen.place - rows.start * SIDE * subpixels
    shape = rows.stop - rows.start, SIDE * subpixels
    return seen, alike(seen, place, shape, eye, subpixels, seed)


def pixel(seen, subpixels):
    row, column = np.divmod(seen.place, SIDE * subpixels)
    return row // subpixels * SIDE + column // subpixels


@pytest.mark.parametrize("slant", [0.0, 1.0])
@pytest.mark.parametrize("subpixels", [2, 3])
def test_on_a_plane_all_are_alike(slant, subpixels):
    seen, found = seen_and_alike(shapes.tracer([shapes.plate(0, 100)]), looking_down(slant), subpixels)
    s2 = subpixels**2
    assert found.shape == (SIDE**2, s2) and np.array_equal(np.sort(found.ravel()), np.arange(len(seen)))
    assert np.all(pixel(seen, subpixels)[found] == np.arange(SIDE**2)[:, None])
    # Each is the first as often as any, whatever else is drawn at its place: the mean over a pixel is what it was.
    first = seen.place[found[:, 0]]
    row, column = np.divmod(first, SIDE * subpixels)
    which = row % subpixels * subpixels + column % subpixels
    assert abs(np.bincount(which, minlength=s2) / len(which) * s2 - 1).max() < 0.15
    other = [hash01(first[which == k], 0).mean() for k in range(s2)]
    assert abs(np.array(other) - 0.5).max() < 0.06


def table():
    """A small plate half a metre above a floor."""
    return shapes.tracer([shapes.plate(0, 100), shapes.plate(0.5, 0.3, name="table")])


def test_where_one_surface_ends_none_are():
    seen, found = seen_and_alike(table(), looking_down(), 2)
    height, own = seen.position[:, 2], pixel(seen, 2)
    levels = np.bincount(own, height > 0.1, SIDE**2)
    edge = (levels > 0) & (levels < 4)
    assert 0 < edge.sum() < SIDE**2 / 4
    assert np.array_equal(np.unique(own[found]), np.flatnonzero(~edge))
    assert np.ptp(height[found], 1).max() < 1e-5


def test_the_cut_into_tiles_changes_nothing():
    seen, whole = seen_and_alike(table(), looking_down(), 2, seed=3)
    parts = [seen_and_alike(table(), looking_down(), 2, rows, 3) for rows in (slice(0, 40), slice(40, 128))]
    assert np.array_equal(seen.place[whole], np.concatenate([part.place[found] for part, found in parts]))
