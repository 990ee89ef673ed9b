# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Spherical harmonics against their definition: values, orthogonality, what the clamped cosine keeps."""

import numpy as np
from gi_bake.gi_core import sh


def sphere(n=20000):
    """Directions spread evenly: a Fibonacci lattice, (n, 3) float32."""
    k = np.arange(n) + 0.5
    z, phi = 1 - 2 * k / n, np.pi * (1 + np.sqrt(5)) * k
    ring = np.sqrt(1 - z * z)
    return np.stack([ring * np.cos(phi), ring * np.sin(phi), z], -1).astype(np.float32)


DIRECTIONS = sphere()


def test_order_and_signs():
    values = sh.basis(np.float32([[0.6, 0, 0.8], [0, 1, 0]]))
    assert np.allclose(values[0], [0.282094792, 0, 0.488602512 * 0.8, -0.488602512 * 0.6])
    assert np.allclose(values[1], [0.282094792, -0.488602512, 0, 0])
    assert np.allclose(sh.cosine_lobe(np.float32([0, 0, 1])), [0.886226925, 0, 1.02332671, 0])


def test_orthonormal():
    values = sh.basis(DIRECTIONS, 3).astype(np.float64)
    assert np.allclose(4 * np.pi * values.T @ values / len(values), np.eye(9), atol=1e-3)


def test_cosine_lobe_is_the_projection():
    axis = np.float32([0.48, -0.6, 0.64])
    cosine = np.maximum(DIRECTIONS @ axis, 0).astype(np.float64)
    projected = 4 * np.pi * sh.basis(DIRECTIONS).T.astype(np.float64) @ cosine / len(cosine)
    assert np.allclose(sh.cosine_lobe(axis), projected, atol=1e-3)


def test_a_single_beam_brings_exactly_what_it_carries():
    """With three bands, the third at 4/5 of its projection: 1 facing the beam, 1/8 across it."""
    to_light = np.float32([[0.48, -0.6, 0.64]])
    lobe = sh.cosine_lobe(to_light, 3)[..., None] * np.ones(3, np.float32)
    assert np.allclose(sh.evaluate(lobe, to_light), 1, atol=1e-5)
    across = np.float32([[0.8, 0, -0.6]])
    assert np.allclose(sh.evaluate(lobe, across), 1 / 8, atol=1e-5)


def test_integral_and_vector():
    axis = np.float32([0, 0.6, -0.8])
    lobe = np.float32(2) * sh.cosine_lobe(axis)[:, None] * np.float32([1, 0.5, 0])
    assert np.allclose(sh.integral(lobe), np.pi * np.array([2, 1, 0]), rtol=1e-5)
    assert np.allclose(sh.vector(lobe), 2 * np.pi / 3 * axis[:, None] * np.array([2, 1, 0]), rtol=1e-5)


def test_affine_is_the_same_function():
    coefficients = np.random.default_rng(3).random((5, 4, 3)).astype(np.float32)
    u, *v = sh.affine(coefficients)
    direction = DIRECTIONS[:5]
    direct = u + sum(direction[:, k, None] * v[k] for k in range(3))
    assert np.allclose(direct, sh.evaluate(coefficients, direction), atol=1e-6)
    assert np.allclose(sh.from_affine(sh.affine(coefficients)), coefficients, atol=1e-6)


def test_polynomials_are_the_basis():
    n = dict(zip("xyz", DIRECTIONS.T))
    for k, terms in enumerate(sh.POLYNOMIALS):
        value = sum(w * np.prod([n[a] for a in axes], 0) for w, axes in terms)
        assert np.allclose(sh.FACTORS[k] * value, sh.basis(DIRECTIONS, 3)[:, k], atol=1e-5)
