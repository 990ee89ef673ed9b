# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core import sampling


def test_hash_is_uniform_and_independent_of_its_neighbours():
    x = sampling.hash01(np.arange(100_000), 3)
    counts, _ = np.histogram(x, 100, (0, 1))
    # χ² with 99 degrees of freedom: mean 99, deviation 14.
    assert ((counts - 1000) ** 2 / 1000).sum() < 99 + 5 * 14
    assert abs(np.corrcoef(x[:-1], x[1:])[0, 1]) < 0.02
    assert abs(np.corrcoef(x, sampling.hash01(np.arange(100_000), 4))[0, 1]) < 0.02


def test_disk_is_even_over_the_unit_disk():
    p = sampling.disk(sampling.r2_sequence(20_000))
    r2 = (p**2).sum(-1)
    assert r2.max() <= 1 + 1e-6
    assert np.allclose([r2.mean(), (r2**2).mean()], [1 / 2, 1 / 3], atol=2e-3)
    assert np.allclose(p.mean(0), 0, atol=2e-3)


@pytest.mark.parametrize("axis", [(0, 0, 1), (0, 0, -1), (0.6, -0.8, 0), (-0.36, 0.48, -0.8)])
def test_directions_follow_their_densities(axis):
    normal = np.broadcast_to(np.array(axis, np.float32), (20_000, 3))
    u = sampling.r2_sequence(20_000)
    cosine = (sampling.cosine_hemisphere(normal, u) * normal).sum(-1)
    assert np.isclose(cosine.mean(), 2 / 3, atol=1e-3) and np.isclose((cosine**2).mean(), 1 / 2, atol=1e-3)
    # Over a cone, 1 − cos is even between 0 and its rim.
    directions = sampling.cone(normal, np.full(20_000, 0.3), u)
    assert np.allclose(np.linalg.norm(directions, axis=-1), 1, atol=1e-5)
    height = 1 - (directions * normal).sum(-1)
    assert height.max() <= 0.3 + 1e-6 and np.isclose(height.mean(), 0.15, atol=1e-3)


def test_systematic_draws_in_proportion_and_never_what_weighs_nothing():
    weights = np.array([0, 1, 0, 3, 6, 0.0])
    counts = np.bincount(sampling.systematic(weights, 1000), minlength=6)
    assert np.all(np.abs(counts - 100 * weights) <= 1)
    with pytest.raises(ValueError, match="positive"):
        sampling.systematic(np.zeros(3), 5)


def test_morton_interleaves_bits():
    cells = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [2, 0, 0], [1023, 1023, 1023]])
    assert sampling.morton(cells).tolist() == [0, 1, 2, 4, 8, 2**30 - 1]
