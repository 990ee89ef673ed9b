# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A list of values as an image."""

import numpy as np


def spread(values, row):
    """values: (n, c) float32. row: (h, w) int, which of them a pixel has, −1 for zero. Returns (h, w, c) float32."""
    if not len(values):
        return np.zeros((*row.shape, values.shape[1]), np.float32)
    return np.where(row[..., None] >= 0, values[row], np.float32(0))


def spread_on_gpu(gpu, values, row):
    c = values.shape[1]
    image = gpu.empty((*row.shape, c), c)
    gpu.dispatch(
        "spread", row.shape[0] * row.shape[1], {"values": (values, c), "row": (row, 1)}, {"image_": image}
    )  # fmt: skip
    return image
