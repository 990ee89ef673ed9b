# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Dilation against a search through all texels."""

import numpy as np
import pytest
from gi_bake.gi_core.dilate import dilate

rng = np.random.default_rng(0)


@pytest.mark.parametrize("share", [0.005, 0.05, 0.5])
@pytest.mark.parametrize("margin", [0, 1, 4, 50])
def test_each_empty_texel_takes_its_nearest(share, margin):
    height, width = 21, 34
    valid = rng.random((height, width)) < share
    valid[7, 9] = True
    image = rng.random((height, width, 4)).astype(np.float32)
    grown, filled = dilate(image, valid, margin)

    rows, columns = np.nonzero(valid)
    y, x = np.mgrid[:height, :width]
    squared = (y[..., None] - rows) ** 2 + (x[..., None] - columns) ** 2
    nearest = squared.min(axis=-1)
    assert np.array_equal(filled, nearest <= margin**2)
    assert np.array_equal(grown[valid], image[valid])
    assert np.array_equal(grown[~filled], image[~filled])
    # Where two are equally near either is right.
    candidates = np.where((squared == nearest[..., None])[..., None], image[rows, columns], np.nan)
    assert (candidates == grown[..., None, :]).all(axis=-1).any(axis=-1)[filled].all()


def test_input_stays_as_it_was_and_nothing_comes_of_nothing():
    image = np.ones((5, 6, 3), np.float32)
    grown, filled = dilate(image, np.zeros((5, 6), bool), 3)
    assert not filled.any()
    assert np.array_equal(grown, image)
    assert grown is not image


def test_negative_margin():
    with pytest.raises(ValueError, match="not -1"):
        dilate(np.zeros((2, 2, 3)), np.ones((2, 2), bool), -1)
