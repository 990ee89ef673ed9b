# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Hits of rays to the colour that the previous frame had there (HDRP, ReprojectGlobalIllumination).

The hit's motion says where its surface was. Off the previous screen, or where that shows another depth, there is no
colour. The source rejects by raw device depth (0.1), which never happens beyond 3 m; here it is by relative depth.
"""

import numpy as np


def reproject(hit, before, color, depth, tolerance: float):
    """Colours of hits in the previous frame.

    hit: (n,) int32 pixels of this frame, −1 for a miss. before: (m, 3) float32 for each pixel of this frame: x, y in
        pixels of the previous one, centres at whole numbers, and the depth expected there; NaN where it was nowhere.
    color: (h, w, c), depth: (h, w) float32, of the previous frame. tolerance: of depth, as a share of it.
    Returns (n, c) float32, zero where there is none, and (n,) bool, where there is one.
    """
    h, w, c = color.shape
    x, y, z = before[np.maximum(hit, 0)].T
    with np.errstate(invalid="ignore"):
        valid = (hit >= 0) & (x > -0.5) & (x < w - 0.5) & (y > -0.5) & (y < h - 0.5)
        column, row = (np.where(valid, np.round(a), 0).astype(np.int32) for a in (x, y))
        tap = np.clip(row, 0, h - 1) * w + np.clip(column, 0, w - 1)
        valid &= np.abs(depth.ravel()[tap] - z) <= tolerance * z
    return np.where(valid[:, None], color.reshape(-1, c)[tap], 0).astype(np.float32), valid


def reproject_on_gpu(gpu, hit, before, color, depth, tolerance: float):
    (h, w, c), n = color.shape, len(hit)
    found, valid = gpu.empty((n, c), c), gpu.empty((n,), 1, bool)
    inputs = {"hit": (hit, 1), "before": (gpu.array(before, 3, nowhere=-1e30), 3), "color": (color, c),
              "depth": (depth, 1)}  # fmt: skip
    gpu.dispatch(
        "reproject", n, inputs, {"found": found, "valid": valid}, integers={"width": w, "height": h},
        floats={"tolerance": tolerance},
    )  # fmt: skip
    return found, valid
