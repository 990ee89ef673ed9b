# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchy of boxes: every triangle in one leaf, every box around what is in it, and no deeper than promised."""

import numpy as np
import pytest
from gi_bake.gi_core.bvh import DEPTH, LEAF, build

RNG = np.random.default_rng(2)


def soup(n):
    """Triangles of all sizes."""
    size = 10.0 ** RNG.uniform(-3, 0, (n, 1, 1))
    return (RNG.random((n, 1, 3)) + size * RNG.normal(size=(n, 3, 3))).astype(np.float32)


SOUPS = {
    "one": soup(1),
    "a leaf": soup(LEAF),
    "few": soup(LEAF + 1),
    "many": soup(5000),
    "all the same": np.repeat(soup(1), 300, 0),
    "a plane": soup(1000) * np.float32([1, 1, 0]),
    "ever closer": (2.0 ** -np.arange(100)[:, None, None] * soup(1)).astype(np.float32),
}


@pytest.mark.parametrize("corners", SOUPS.values(), ids=SOUPS)
def test_each_triangle_is_in_one_leaf_and_in_all_boxes_above_it(corners):
    n = len(corners)
    bvh = build(corners.reshape(-1, 3), np.arange(3 * n).reshape(-1, 3))
    assert np.array_equal(np.stack([bvh.a, bvh.b, bvh.c], 1), corners[bvh.triangle])
    seen, waiting, deepest = np.zeros(n, int), [(0, (np.full(3, -np.inf), np.full(3, np.inf)), 0)], 0
    while waiting:
        node, (low, high), depth = waiting.pop()
        deepest = max(deepest, depth)
        here = bvh.low[node, :3], bvh.high[node, :3]
        assert (here[0] >= low).all() and (here[1] <= high).all()
        first, count = int(bvh.low[node, 3]), int(bvh.high[node, 3])
        if count:
            inside = corners[bvh.triangle[first : first + count]]
            assert count <= LEAF and (inside >= here[0]).all() and (inside <= here[1]).all()
            seen[first : first + count] += 1
        else:
            waiting += [(first, here, depth + 1), (first + 1, here, depth + 1)]
    assert (seen == 1).all() and deepest <= DEPTH
