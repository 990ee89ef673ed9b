# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core.vectors import pick, put

RANDOM = np.random.default_rng(5)
WHICH = [
    np.array([4, 1, 1, 0]), np.array([[0, 1, 2], [5, 4, 3]], np.int32), np.arange(6) % 3 > 0,
    np.zeros(0, np.int64), np.zeros(6, bool), slice(1, 5, 2),
]  # fmt: skip


@pytest.mark.parametrize("shape", [(), (1,), (3,), (2, 3)])
@pytest.mark.parametrize("which", WHICH)
def test_rows_are_those_that_indexing_gives(which, shape):
    values = RANDOM.random((6, *shape), np.float32)
    assert np.array_equal(pick(values, which), values[which])


@pytest.mark.parametrize("kind", [np.float32, bool])
@pytest.mark.parametrize("shape", [(1,), (3,), (2, 3)])
@pytest.mark.parametrize("which", WHICH[:-1])
def test_rows_are_put_where_indexing_puts_them(which, shape, kind):
    into = (RANDOM.random((6, *shape)) > 0.5).astype(kind)
    expected, values = into.copy(), (RANDOM.random(into[which].shape) > 0.5).astype(kind)
    if which.dtype == int and which.ndim == 1 and len(which):
        values[2] = values[1]  # the same row twice
    put(into, which, values)
    expected[which] = values
    assert np.array_equal(into, expected)
    if which.ndim == 2:
        put(into, which, values[:, :1])
        expected[which] = values[:, :1]
        assert np.array_equal(into, expected)
