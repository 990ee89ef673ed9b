# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
from gi_bake.gi_core import directional, sh
from gi_bake.gi_core.vectors import normalize


def test_the_four_normals_are_unit_and_even():
    normal = normalize(np.random.default_rng(0).normal(size=(50, 3)).astype(np.float32))
    four = np.stack([directional.tilted(normal, k) for k in range(4)])
    assert np.allclose(np.linalg.norm(four, axis=-1), 1, atol=1e-5)
    assert np.allclose(four[0], normal, atol=1e-6)
    assert np.allclose(np.einsum("knc,nc->kn", four[1:], normal), np.sqrt(1 / 3), atol=1e-5)
    assert np.allclose(np.einsum("nc,nc->n", four[1], four[2]), 0, atol=1e-5)


def test_light_that_all_four_see_comes_back_for_any_normal():
    random = np.random.default_rng(1)
    normal = normalize(random.normal(size=(4, 5, 3)).astype(np.float32))
    # A sun near the normal and an even sky: E(n) = u + v · n, exactly, where n does not turn away from the sun.
    sun = normalize(normal + 0.2 * random.normal(size=(4, 5, 3)).astype(np.float32))
    color = np.float32([3, 2, 1])

    def light(n):
        return 0.5 + np.maximum(0, np.sum(sun * n, -1))[..., None] * color

    four = np.stack([light(directional.tilted(normal, k)) for k in range(4)])
    found = directional.coefficients(four, normal)
    assert found.shape == (4, 5, 4, 3)
    for n in (normal, sun, normalize(normal + sun)):
        assert np.allclose(sh.evaluate(found, n), light(n), atol=1e-4)
