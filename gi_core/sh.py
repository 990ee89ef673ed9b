# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Spherical harmonics: the one place with their order and signs.

Order (1, y, z, x), signs (+, −, +, −), as real harmonics with the Condon-Shortley phase have them; a third band
follows in the same convention (xy, yz, 3z² − 1, xz, x² − y², signs +, −, +, −, +). Coefficients are the second last
axis where there are colours behind them: (..., k, 3).
"""

import numpy as np

BANDS = {1: 1, 4: 2, 9: 3}

Y0 = np.float32(0.5 / np.sqrt(np.pi))
_Y1 = np.float32(np.sqrt(3 / (4 * np.pi)))
_Y2 = np.sqrt(15 / (4 * np.pi)) * np.array([1, -1, 1 / np.sqrt(12), -1, 0.5], np.float32)

# Each harmonic as a factor times a sum of weighted products, for who builds them of nodes or in a shader.
FACTORS = np.array([Y0, -_Y1, _Y1, -_Y1, *_Y2], np.float32)
POLYNOMIALS = (
    ((1, ""),), ((1, "y"),), ((1, "z"),), ((1, "x"),),
    ((1, "xy"),), ((1, "yz"),), ((3, "zz"), (-1, "")), ((1, "xz"),), ((1, "xx"), (-1, "yy")),
)  # fmt: skip

# What the clamped cosine keeps of each coefficient (Ramamoorthi & Hanrahan 2001): π, 2π/3, π/4 by band. The last is
# π/5 here: three bands then bring of a single beam exactly what it carries, where π/4 overshoots by a sixteenth.
COSINE = np.repeat(np.float32([np.pi, 2 * np.pi / 3, np.pi / 5]), (1, 3, 5))


def basis(direction: np.ndarray, bands: int = 2) -> np.ndarray:
    """The harmonics' values at unit directions: (..., 3) -> (..., bands²) float32."""
    x, y, z = direction[..., 0], direction[..., 1], direction[..., 2]
    out = np.empty((*direction.shape[:-1], bands**2), np.float32)
    out[..., 0] = Y0
    out[..., 1], out[..., 2], out[..., 3] = -_Y1 * y, _Y1 * z, -_Y1 * x
    if bands > 2:
        for k, value in enumerate((x * y, y * z, 3 * z * z - 1, x * z, x * x - y * y)):
            out[..., 4 + k] = np.float32(_Y2[k]) * value
    return out


def cosine_lobe(direction: np.ndarray, bands: int = 2) -> np.ndarray:
    """The clamped cosine max(0, n·ω) about unit directions n: (..., 3) -> (..., bands²) float32."""
    return basis(direction, bands) * COSINE[: bands**2]


def vector(coefficients: np.ndarray) -> np.ndarray:
    """∫ f(ω) ω dω of a function's coefficients: (..., k, 3 colours) -> (..., 3 axes, 3 colours)."""
    return np.stack([-coefficients[..., 3, :], -coefficients[..., 1, :], coefficients[..., 2, :]], -2) / (
        np.float32(np.sqrt(3 / (4 * np.pi)))
    )


def integral(coefficients: np.ndarray) -> np.ndarray:
    """∫ f(ω) dω over the sphere: (..., k, 3) -> (..., 3)."""
    return coefficients[..., 0, :] / Y0


def evaluate(coefficients: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """The function at unit directions: (..., k, 3), (..., 3) -> (..., 3)."""
    values = basis(direction, BANDS[coefficients.shape[-2]])
    return np.einsum("...k,...kc->...c", values, coefficients)


def affine(coefficients: np.ndarray) -> np.ndarray:
    """Two bands as u + v·ω: (..., 4, 3 colours) -> (4, ..., 3 colours) of u, v_x, v_y, v_z."""
    c = np.moveaxis(coefficients, -2, 0)
    return np.stack([Y0 * c[0], -_Y1 * c[3], -_Y1 * c[1], _Y1 * c[2]])


def from_affine(values: np.ndarray) -> np.ndarray:
    """The inverse of `affine`: (4, ..., 3) -> (..., 4, 3)."""
    u, x, y, z = values
    return np.stack([u / Y0, -y / _Y1, z / _Y1, -x / _Y1], -2)
