# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies between the passes of screen-space GI: from rays and slices to light, pixel by pixel in plain loops."""

import numpy as np
import pytest
from gi_bake.gi_core.kernels.clamped import clamped
from gi_bake.gi_core.kernels.hit_light import hit_light
from gi_bake.gi_core.kernels.scan_light import scan_light
from gi_bake.gi_core.kernels.screen_trace import MISSED, NO_RAY
from gi_bake.gi_core.kernels.slice_draws import slice_draws
from gi_bake.gi_core.kernels.spread import spread

RANDOM = np.random.default_rng(8)


@pytest.mark.parametrize("rays", [1, 3])
@pytest.mark.parametrize("with_rest", [True, False])
@pytest.mark.parametrize("n", [0, 1, 40])
def test_light_of_hits_is_the_mean_of_what_rays_met(n, rays, with_rest):
    picture = RANDOM.random((4, 5, 3), np.float32)
    hit = RANDOM.integers(NO_RAY, 20, n * rays).astype(np.int32)
    rest = RANDOM.random((n, 2, 3), np.float32) if with_rest else None
    light, missed = hit_light(hit, picture, rest, 1, rays)
    assert light.shape == (n, 3) and missed.shape == (n,)
    for i in range(n):
        of_pixel = hit[i * rays : (i + 1) * rays]
        expected = np.zeros(3) if rest is None else rest[i, 1].astype(np.float64)
        for pixel in of_pixel:
            if pixel >= 0:
                expected = expected + picture[pixel // 5, pixel % 5] / rays
        np.testing.assert_allclose(light[i], expected, rtol=1e-6)
        assert missed[i] == pytest.approx(sum(pixel == MISSED for pixel in of_pixel) / rays)


@pytest.mark.parametrize("slices", [1, 4])
@pytest.mark.parametrize("with_rest", [True, False])
@pytest.mark.parametrize("n", [0, 1, 20])
def test_light_of_slices_is_their_mean_and_what_is_open_shows_the_rest(n, slices, with_rest):
    arrived, open_share = RANDOM.random((n * slices, 3), np.float32), RANDOM.random(n * slices, np.float32)
    rest = RANDOM.random((n, 2, 3), np.float32) if with_rest else None
    light, missed = scan_light(arrived, open_share, rest, 1, slices)
    assert light.shape == (n, 3) and missed.shape == (n,)
    for i in range(n):
        expected, seen_by_none = np.zeros(3), 0.0
        for k in range(i * slices, (i + 1) * slices):
            expected = expected + arrived[k] + (0 if rest is None else open_share[k] * rest[i, 1])
            seen_by_none += open_share[k]
        np.testing.assert_allclose(light[i], expected / slices, rtol=1e-5)
        assert missed[i] == pytest.approx(seen_by_none / slices, rel=1e-5)


def test_a_clamp_darkens_and_keeps_the_colour():
    radiance = np.float32([[4, 2, 1], [0.5, 0.25, 0], [0, 0, 0], [1, 1, 2]])
    np.testing.assert_allclose(clamped(radiance, 1), [[1, 0.5, 0.25], [0.5, 0.25, 0], [0, 0, 0], [0.5, 0.5, 1]])
    assert clamped(radiance, 0) is radiance
    assert clamped(radiance[:0], 1).shape == (0, 3)


@pytest.mark.parametrize("n", [0, 1, 7])
def test_values_lie_at_their_pixels(n):
    values, row = RANDOM.random((n, 3), np.float32), RANDOM.integers(-1, n, (3, 4))
    image = spread(values, row)
    assert image.shape == (3, 4, 3)
    for y in range(3):
        for x in range(4):
            assert np.array_equal(image[y, x], values[row[y, x]] if row[y, x] >= 0 else np.zeros(3))


def test_slices_of_a_pixel_go_round_evenly_and_passes_go_on_where_the_last_ended():
    place = np.arange(50)
    whole = slice_draws(place, 0, 8, 3).reshape(50, 8, 3)
    parts = [slice_draws(place, first, 4, 3).reshape(50, 4, 3) for first in (0, 4)]
    assert np.array_equal(np.concatenate(parts, 1), whole)
    assert (whole >= 0).all() and (whole < 1).all()
    # A turn of the same sequence for all pixels, each from a start of its own: eight leave no gap of a quarter.
    turns = np.sort(whole[..., 0], 1)
    gaps = np.diff(np.concatenate([turns, turns[:, :1] + 1], 1), axis=1)
    assert gaps.max() < 0.25
    assert len(np.unique(whole[:, 0, 0])) == 50 and abs(whole[..., 1:].mean() - 0.5) < 0.05
    assert slice_draws(place[:0], 0, 4, 3).shape == (0, 3)
