# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import borders
from gi_bake.gi_core.dilate import spread_in
from gi_bake.gi_core.seams import Seams
from gi_bake.gi_core.surfels import from_texels
from gi_bake.tests import shapes

NONE = Seams.concatenate([])


def test_texels_under_a_box_are_inside_and_those_beside_it_are_not():
    floor = shapes.plate(0, 1, name="floor")
    hollow = shapes.box(0.5, name="box")
    # Its front is its inside; a solid one's is its outside.
    solid = replace(hollow, triangles=hollow.triangles[:, ::-1].copy(), normals=-hollow.normals[:, ::-1])
    for mesh, expected in ((solid, True), (hollow, False)):
        tracer = shapes.tracer([floor, mesh])
        points, _ = from_texels(tracer.geometry, "floor", "", (32, 32))
        beneath = (np.abs(points.position[:, :2]) < 0.45).all(1)
        beside = (np.abs(points.position[:, :2]) > 0.55).any(1)
        found = borders.inside(tracer, points)
        assert (found[beneath] == expected).all()
        # From outside a room's walls show their backs.
        assert not expected or not found[beside].any()


def test_hidden_texels_take_the_light_around_them():
    valid = np.zeros((64, 64), bool)
    valid[8:56, 8:56] = True
    hidden = np.zeros_like(valid)
    hidden[20:40, 20:40] = True
    image = np.where(valid & ~hidden, 2.0, 0.0)[..., None].astype(np.float32)
    assert np.array_equal(borders.dark(image, valid), hidden)
    done = borders.bordered(image, valid, hidden, valid, 3, NONE)
    assert np.allclose(done.image[valid], 2) and done.inside == 400
    assert done.filled[5:59, 8:56].all() and not done.filled[:5].any() and np.allclose(done.image[done.filled], 2)


def test_a_dark_map_stays_dark():
    valid = np.ones((8, 8), bool)
    assert not borders.dark(np.zeros((8, 8, 3), np.float32), valid).any()


@pytest.mark.parametrize("shape", [(128, 128), (70, 101), (1, 9)])
def test_spreading_in_is_smooth_and_reaches_all(shape):
    known = np.zeros(shape, bool)
    known[:, 0] = True
    image = np.zeros((*shape, 1), np.float32)
    image[:, 0] = 1
    assert np.allclose(spread_in(image, known, ~known), 1)
    image[:, -1], known[:, -1] = 3, True
    done = spread_in(image, known, ~known)[..., 0]
    assert done.min() == 1 and done.max() == 3 and np.all(np.diff(done, axis=1) >= -1e-6)
    wanted = np.zeros(shape, bool)
    wanted[:, 3] = True
    only = spread_in(image, known, wanted)[..., 0]
    assert np.array_equal(only[:, 3], done[:, 3]) and np.array_equal(only[~wanted], image[~wanted, 0])
    assert np.array_equal(spread_in(image, ~known & known, wanted), image)
