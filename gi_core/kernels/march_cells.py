# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a march reads, in one place: each pixel's depth and slope, then the levels above the finest."""

import math

import numpy as np


def march_cells(depth, slope, pyramid):
    """Texels of all levels as planes.

    depth: (h, w) float32, device depth, NOTHING where no surface is. slope: (h, w, 2) float32, its change per pixel
    along x and y. pyramid: (k,) float32 of `depth_pyramid`.
    Returns (k, 3) float32 depth and slope, whose columns lie together.
    """
    cells = np.zeros((3, len(pyramid)), np.float32)
    cells[0] = pyramid
    cells[0, : depth.size] = depth.ravel()
    cells[1:, : depth.size] = slope.reshape(-1, 2).T
    return cells.T


def march_cells_on_gpu(gpu, depth, slope, pyramid):
    cells = gpu.empty((len(pyramid), 3), 3)
    inputs = {"march_depth": (depth, 1), "march_slope": (slope, 2), "pyramid": (pyramid, 1)}
    gpu.dispatch("march_cells", len(pyramid), inputs, {"cells": cells}, integers={"size": math.prod(depth.shape)})
    return cells
