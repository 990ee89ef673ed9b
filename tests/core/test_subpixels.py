# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Subpixels that look at one surface ask for light once, those of silhouettes each for themselves."""

import numpy as np
import pytest
from gi_bake.gi_core import surfels
from gi_bake.gi_core.sampling import hash01
from gi_bake.gi_core.scene import Camera
from gi_bake.gi_core.subpixels import asking
from gi_bake.tests import shapes

SIDE = 64


def looking_down(slant=0.0):
    """A camera 3 m above the origin, turned about X [rad]."""
    c, s = np.cos(slant), np.sin(slant)
    matrix = np.eye(4)
    matrix[:3] = [[1, 0, 0, 0], [0, c, -s, 3 * -s], [0, s, c, 3 * c]]
    return Camera("PERSPECTIVE", matrix, (-0.4, 0.4, -0.4, 0.4), (SIDE, SIDE))


def asked(tracer, eye, subpixels, rows=slice(None), seed=0):
    rows = slice(*rows.indices(SIDE * subpixels))
    seen = surfels.from_camera(tracer, eye, subpixels, rows)
    place = seen.place - rows.start * SIDE * subpixels
    shape = rows.stop - rows.start, SIDE * subpixels
    return seen, asking(seen, place, shape, eye, subpixels, seed)


def pixel(seen, subpixels):
    row, column = np.divmod(seen.place, SIDE * subpixels)
    return row // subpixels * SIDE + column // subpixels


@pytest.mark.parametrize("slant", [0.0, 1.0])
@pytest.mark.parametrize("subpixels", [2, 3])
def test_on_a_plane_one_asks_for_each_pixel(slant, subpixels):
    seen, found = asked(shapes.tracer([shapes.plate(0, 100)]), looking_down(slant), subpixels)
    assert found.whole == len(found.rows) == SIDE**2
    assert np.array_equal(pixel(seen, subpixels), pixel(seen[found.rows], subpixels)[found.source])
    # Each as often as any, and whatever else is drawn at that place: the mean over a pixel is what it was.
    row, column = np.divmod(seen.place[found.rows], SIDE * subpixels)
    which = row % subpixels * subpixels + column % subpixels
    share = np.bincount(which, minlength=subpixels**2) / len(which)
    assert abs(share * subpixels**2 - 1).max() < 0.15
    other = [hash01(seen.place[found.rows[which == k]], 0).mean() for k in range(subpixels**2)]
    assert abs(np.array(other) - 0.5).max() < 0.06


def test_where_surfaces_meet_each_asks_for_itself():
    # A small plate half a metre above the floor.
    floor, table = shapes.plate(0, 100), shapes.plate(0.5, 0.3, name="table")
    seen, found = asked(shapes.tracer([floor, table]), looking_down(), 2)
    height = seen.position[:, 2]
    own = pixel(seen, 2)
    low, high = np.full((2, SIDE**2), [[9.0], [-9.0]])
    np.minimum.at(low, own, height)
    np.maximum.at(high, own, height)
    edge = (high - low > 0.1)[own]
    assert 0 < edge.sum() < len(seen) / 4
    assert np.array_equal(np.bincount(found.source, minlength=len(found.rows))[found.source] == 1, edge)
    assert np.array_equal(found.rows[found.source[edge]], np.flatnonzero(edge))
    assert abs(height - height[found.rows][found.source]).max() < 1e-5


def test_the_cut_into_tiles_changes_nothing():
    floor, table = shapes.plate(0, 100), shapes.plate(0.5, 0.3, name="table")
    tracer = shapes.tracer([floor, table])
    seen, whole = asked(tracer, looking_down(), 2, seed=3)
    source = seen.place[whole.rows][whole.source]
    for rows in (slice(0, 40), slice(40, 128)):
        part, found = asked(tracer, looking_down(), 2, rows, seed=3)
        here = (seen.place >= part.place[0]) & (seen.place <= part.place[-1])
        assert np.array_equal(part.place[found.rows][found.source], source[here])
