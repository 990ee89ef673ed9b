# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arithmetic on arrays of vectors, coordinate by coordinate: numpy's own reductions over an axis of three, and einsum,
are several times slower. And rows of them by numpy's `take`: its indexing is up to ten times as slow."""

import math

import numpy as np


def dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(..., c), (..., c) -> (...)."""
    return sum(a[..., k] * b[..., k] for k in range(1, a.shape[-1])) + a[..., 0] * b[..., 0]


def pick(values: np.ndarray, which) -> np.ndarray:
    """values[which], the rows that a slice, a mask (n,) bool or indices (...) pick: (m, ...) -> (..., ...)."""
    if isinstance(which, slice):
        return values[which]
    which = np.asarray(which)
    return values.take(np.flatnonzero(which) if which.dtype == bool else which, 0)


def put(into: np.ndarray, which, values: np.ndarray) -> None:
    """into[which] = values, where rows (m, ...) are numbers of as many bytes: two to three times as fast. which: a mask
    (m,) or indices (...), which values (..., ...) broadcast to as they are."""
    width = math.prod(into.shape[1:])
    row = np.dtype((np.void, width * into.itemsize))
    values = np.ascontiguousarray(values, into.dtype).reshape(*values.shape[: values.ndim - into.ndim + 1], width)
    into.reshape(len(into), width).view(row)[which, 0] = values.view(row)[..., 0]


def length(v: np.ndarray) -> np.ndarray:
    """(..., 3) -> (...)."""
    return np.sqrt(dot(v, v))


def normalize(v: np.ndarray) -> np.ndarray:
    """Vectors at unit length, zero where they have none: (..., 3) -> (..., 3)."""
    norm = length(v)[..., None]
    with np.errstate(divide="ignore", invalid="ignore"):
        return v * np.where(norm > 0, 1 / norm, norm.dtype.type(0))


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(..., 3), (..., 3) -> (..., 3)."""
    return np.stack([a[..., i] * b[..., j] - a[..., j] * b[..., i] for i, j in ((1, 2), (2, 0), (0, 1))], -1)


def lit(color: np.ndarray) -> np.ndarray:
    """Where a colour is not black: (..., 3) -> (...) bool."""
    return (color[..., 0] > 0) | (color[..., 1] > 0) | (color[..., 2] > 0)


def offset(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Ray origins off their surface, by a few units in the last place: (n, 3), (n, 3) float32 -> (n, 3) float32.

    Wächter & Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems 2019, ch. 6. The
    normals are geometric ones, on the side to which rays leave.
    """
    ulps = (normals * np.float32(256)).astype(np.int32)
    points = np.ascontiguousarray(points, np.float32)
    moved = (points.view(np.int32) + np.where(points < 0, -ulps, ulps)).view(np.float32)
    # Near the origin units in the last place vanish, and a fixed step takes over.
    return np.where(np.abs(points) < 1 / 32, points + normals * np.float32(1 / 65536), moved)
