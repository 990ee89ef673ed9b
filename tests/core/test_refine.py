# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
from itertools import pairwise

import numpy as np
import pytest
from gi_bake.gi_core.refine import Goal, refined
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.tiles import finish

TRUTH = np.float32([[2.0, 1.0, 4.0]])


def noisy(points=4000, sigma=1.0):
    """Passes whose values are the truth and white noise of variance sigma² over the samples."""
    rng = np.random.default_rng(5)

    def one_pass(samples):
        yield 0.5
        light = TRUTH + rng.normal(0, sigma / np.sqrt(samples.count), (points, 3))
        # In two parts, of which one alone has the noise.
        return np.stack([0 * light + 0.5, light - 0.5], 1).astype(np.float32)

    return one_pass


@pytest.mark.parametrize("n", [1, 2, 3, 4, 7, 16, 64, 65, 1000])
def test_passes_are_consecutive_and_add_up(n):
    for goal in (Goal(n), Goal(n, noise=1e-9), Goal(n, seconds=1e9)):
        passes = list(goal.passes())
        assert passes[0].first == 0 and passes[-1].first + passes[-1].count == n
        assert all(a.first + a.count == b.first for a, b in pairwise(passes))
        assert all(p.count > 0 for p in passes)
    assert len(list(Goal(n).passes())) <= 4


def test_the_mean_weighs_passes_by_their_samples_and_is_shown_after_each():
    shown = []
    estimate = finish(refined(noisy(), Goal(64), lambda mean: shown.append(mean.sum(1))))
    assert estimate.samples == 64 and len(shown) == 3
    assert np.array_equal(shown[-1], estimate.values.sum(1))
    errors = [np.mean((mean - TRUTH) ** 2) for mean in shown]
    assert np.allclose(errors, [1 / 16, 1 / 32, 1 / 64], rtol=0.1)


def test_the_noise_is_the_error_that_is_left():
    estimate = finish(refined(noisy(), Goal(64)))
    error = np.mean((estimate.values.sum(1) - TRUTH) ** 2 / (TRUTH**2 + 0.01 * np.pi**2))
    assert np.isclose(estimate.noise, error, rtol=0.1)


def test_a_noise_ends_it_and_not_too_early():
    estimate = finish(refined(noisy(), Goal(65536, noise=2e-3)))
    assert estimate.noise <= 2e-3 and 64 <= estimate.samples < 512
    error = np.mean((estimate.values.sum(1) - TRUTH) ** 2 / (TRUTH**2 + 0.01 * np.pi**2))
    assert 0.5e-3 < error < 2.2e-3


def test_a_time_ends_it(monkeypatch):
    clock = iter(range(1000))
    monkeypatch.setattr("gi_bake.gi_core.refine.time.perf_counter", lambda: next(clock))
    estimate = finish(refined(noisy(points=1), Goal(65536, seconds=5)))
    assert estimate.samples == sum(p.count for p, _ in zip(Goal(65536, seconds=5).passes(), range(5)))


def test_one_pass_there_always_is_and_of_one_nothing_is_known():
    estimate = finish(refined(noisy(), Goal(1, seconds=1e-9)))
    assert estimate.samples == 1 and np.isnan(estimate.noise)


def test_progress_rises_to_one():
    shares = list(refined(noisy(), Goal(64)))
    assert shares == sorted(shares) and shares[-1] < 1


@pytest.mark.parametrize("passes", [2, 4, 8])
def test_passes_of_even_samples_interleave(passes):
    """Samples at (i + shift) / count of equal passes lie as evenly as those of one pass of all."""
    count = 4
    places = np.sort(np.concatenate([np.arange(count) / count + Samples(count, k * count).shift() / count
                                     for k in range(passes)]))  # fmt: skip
    assert np.allclose(np.diff(places), 1 / (count * passes))
