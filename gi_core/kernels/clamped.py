# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours that are no brighter than allowed."""

import numpy as np


def clamped(radiance, most: float):
    """Colours (..., 3) darkened to where their strongest channel is no more than that; 0 leaves all as they are."""
    if not most:
        return radiance
    return radiance * np.minimum(1, most / np.maximum(radiance.max(-1, keepdims=True), np.float32(1e-20)))


def clamped_on_gpu(gpu, radiance, most: float):
    if not most:
        return gpu.array(radiance, 3)
    held = gpu.empty(radiance.shape, 3)
    gpu.dispatch("clamped", held.items, {"radiance": (radiance, 3)}, {"held": held}, floats={"most": most})
    return held
