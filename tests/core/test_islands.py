# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
from gi_bake.gi_core.islands import islands


def test_texels_that_touch_are_one_island():
    drawn = ["##..#", "#...#", "..#..", ".#..#", "....#"]
    valid = np.array([[c == "#" for c in row] for row in drawn])
    found = islands(valid)
    # The corner of two diagonal texels joins them; what is a texel apart stays so.
    assert len(found) == 4 and np.array_equal(found.label >= 0, valid)
    assert found.label[2, 2] == found.label[3, 1] != found.label[0, 0]
    k = found.label[2, 2]
    assert found.rows[k].tolist() == [2, 4] and found.columns[k].tolist() == [1, 3]
    assert len(islands(np.zeros((3, 3), bool))) == 0


def test_a_long_winding_island_is_one():
    valid = np.zeros((41, 41), bool)
    valid[::2] = True
    # A snake: rows joined at their ends in turn.
    valid[1::4, -1] = valid[3::4, 0] = True
    found = islands(valid)
    assert len(found) == 1 and found.rows.tolist() == [[0, 41]]
    valid[21] = False
    assert len(islands(valid)) == 2
