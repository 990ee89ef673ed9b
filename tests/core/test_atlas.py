# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core import texels
from gi_bake.gi_core.atlas import Asked, Place, pack, single, together

SQUARE = np.float32([[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]]])


def test_packed_rectangles_lie_inside_and_apart():
    random = np.random.default_rng(1)
    sizes = [tuple(map(int, random.integers(3, 40, 2))) for _ in range(60)]
    taken = np.zeros((256, 256), int)
    for (w, h), corner in zip(sizes, pack(sizes, 256), strict=True):
        x, y = corner
        assert x >= 0 and y >= 0 and x + w <= 256 and y + h <= 256
        taken[y : y + h, x : x + w] += 1
    assert taken.max() == 1 and taken[taken.any(1)].mean() > 0.8
    assert pack([(10, 10), (300, 1), (256, 250)], 256) == [None, None, (0, 0)]


def test_density_is_one_number_for_all_on_a_page():
    asked = [Asked("large", "uv", 16, 1), Asked("small", "uv", 1, 1), Asked("fine", "uv", 1, 1, factor=2)]
    [page] = together("all", asked, 256, 0, 2)
    large, small, fine = (place.side for place in page.places)
    assert abs(large - 4 * small) <= 4 and abs(fine - 2 * small) <= 2
    assert large**2 + small**2 + fine**2 > 0.5 * 256**2
    assert [p.side for p in together("all", asked, 256, 20, 2)[0].places] == [80, 20, 40]
    several = together("all", asked, 90, 20, 2)
    assert [[p.name for p in page.places] for page in several] == [["large"], ["small", "fine"]]
    with pytest.raises(ValueError, match="'large' needs 80²"):
        together("all", asked, 64, 20, 2)


def test_a_page_of_one_follows_its_factor_or_the_density():
    asked = Asked("cube", "uv", 4, 0.25, factor=0.5)
    assert single(asked, 256, 0).width == 128
    # 10 texels per metre, halved, over 2 m on a map that is filled to a quarter.
    assert single(asked, 256, 10).width == 20


def test_an_object_keeps_to_its_own_square():
    place = Place("a", "uv", 4, 8, 16)
    found = texels.covered_texels(place.on(SQUARE * 1.5, 32, 32), (32, 32)).within(place, 32)
    rows, columns = np.divmod(found.place, 32)
    assert (columns.min(), columns.max(), rows.min(), rows.max()) == (4, 19, 8, 23) and len(rows) == 256


def test_overlap_and_what_lies_outside_are_shares_of_the_area():
    assert texels.overlap(SQUARE * 0.7) == 0
    shifted = np.concatenate([SQUARE * 0.5, SQUARE * 0.5 + [0.25, 0]])
    assert texels.overlap(shifted) == pytest.approx(1 / 3, abs=0.01)
    assert texels.outside(SQUARE) == 0
    assert texels.outside(np.concatenate([SQUARE, SQUARE + 1])) == pytest.approx(0.5)
