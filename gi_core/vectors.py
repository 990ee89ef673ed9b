# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic on arrays of vectors. Through einsum: numpy's own reductions over an axis of three are several times
slower."""

import numpy as np


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(..., 3), (..., 3) -> (...)."""
    return np.einsum("...c,...c->...", a, b)


def length(v: np.ndarray) -> np.ndarray:
    """(..., 3) -> (...)."""
    return np.sqrt(dot(v, v))


def normalize(v: np.ndarray) -> np.ndarray:
    """Vectors at unit length, zero where they have none: (..., 3) -> (..., 3)."""
    norm = length(v)[..., None]
    return np.divide(v, norm, out=np.zeros_like(v), where=norm > 0)


def lit(color: np.ndarray) -> np.ndarray:
    """Where a colour is not black: (..., 3) -> (...) bool."""
    return (color[..., 0] > 0) | (color[..., 1] > 0) | (color[..., 2] > 0)
