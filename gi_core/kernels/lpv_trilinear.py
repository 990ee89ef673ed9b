# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Trilinear look-up: the eight cells around a point."""

import numpy as np

_CORNERS = np.stack(np.meshgrid((0, 1), (0, 1), (0, 1), indexing="ij"), -1).reshape(8, 3)


def corners(local, shape) -> tuple[np.ndarray, np.ndarray]:
    """Cells around points and their weights: (n, 3) in cells from the lowest corner -> (n, 8, 3) int32, (n, 8) float32.

    Values are those of cells' middles; beyond the outermost middles they go on as they are.
    """
    high = np.array(shape, np.float32) - 1
    at = np.clip(local - np.float32(0.5), 0, high)
    first = np.minimum(at.astype(np.int32), np.maximum(np.array(shape, np.int32) - 2, 0))
    t = (at - first)[:, None]
    weight = np.prod(np.where(_CORNERS, t, 1 - t), -1)
    return np.minimum(first[:, None] + _CORNERS.astype(np.int32), high.astype(np.int32)), weight.astype(np.float32)


def mixed(values, index, weight) -> np.ndarray:
    """Weighted sums of cells: (size, k, 3), (n, 8) places in C order, (n, 8) -> (n, k, 3) float32."""
    out = np.zeros((len(index), *values.shape[1:]), np.float32)
    for k in range(index.shape[1]):
        out += values[index[:, k]] * weight[:, k, None, None]
    return out
