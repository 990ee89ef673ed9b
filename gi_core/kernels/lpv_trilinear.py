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


def trilinear(values, local, shape, share, before=None):
    """A grid's values at points, where they count, on top of what other grids have there.

    values: (size, k, 3) float32, cells in C order. local: (n, 3) in cells from the lowest corner. shape: of the grid.
    share: (n,) float32, how much the grid counts. before: (n, k, 3) float32, None for nothing. Returns the same.
    """
    out = np.zeros((len(local), *values.shape[1:]), np.float32) if before is None else before.copy()
    row = np.flatnonzero(share)
    index, weight = corners(local[row], shape)
    place = (index[..., 0] * shape[1] + index[..., 1]) * shape[2] + index[..., 2]
    out[row] += mixed(values, place, weight * share[row, None])
    return out


def trilinear_on_gpu(gpu, values, local, shape, share, before=None):
    n, bands = len(local), values.shape[1]
    found = gpu.empty((n, bands, 3), 3)
    inputs = {"values": (values, 3), "local": (local, 3), "share": (share, 1)}
    gpu.dispatch(
        "lpv_trilinear", n, inputs if before is None else {**inputs, "before": (before, 3)}, {"found": found},
        integers=dict(zip(("size_x", "size_y", "size_z"), shape)),
        defines={"BANDS": bands, "BEFORE": int(before is not None)}, steps=8,
    )  # fmt: skip
    return found
