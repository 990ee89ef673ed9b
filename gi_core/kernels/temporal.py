# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The temporal filter: a frame's values mixed into what earlier frames gathered at the same points (HDRP,
TemporalFilter.compute).

    factor = n/(n + 1),  result = value · (1 − factor) + history · factor,  n → n + 1

is the true mean. HDRP's own, `hdrp`, has factor = 0.93 from n = 8 on, where n stays: 27.6 samples' worth for ever, and
a jump from .875. History counts where it shows the same surface: normals' dot at least .65, and the points no further
apart than the greater of a limit and four pixels' footprint over |n·v|. HDRP takes one texel of history; here it is the
bilinear mix of those among four that count, or it drifts by half a pixel each frame.
"""

import numpy as np

from ..vectors import dot

_NORMALS, _FOOTPRINTS, _FEWEST = np.float32(0.65), np.float32(4), np.float32(1e-3)
_HDRP_FACTOR, _HDRP_COUNT = np.float32(0.93), np.float32(8)


def history_taps(before, expected, normal, footprint, slant, position, history_normal, limit: float):
    """Which pixels of the history show a point, and how much each counts.

    before: (n, 2) float32, where points were, in pixels of the history, centres at whole numbers; NaN for nowhere.
    expected: (n, 3) float32, where in the world they were. normal: (n, 3). footprint, slant: (n,) float32, size of a
        pixel facing the camera [m], and |n·v|. position, history_normal: (h, w, 3) float32, a normal of zero where the
        history shows no surface. limit: [m].
    Returns (n, 4) int32 pixels and (n, 4) float32 weights that add up to 1, or are all 0 where nothing counts.
    """
    h, w = position.shape[:2]
    position, history_normal = position.reshape(-1, 3), history_normal.reshape(-1, 3)
    reach = np.maximum(np.float32(limit), _FOOTPRINTS * footprint / np.maximum(slant, np.float32(1e-6)))
    known = np.isfinite(before).all(-1)
    before = np.where(known[:, None], before, 0)
    low = np.floor(before)
    u, v = (before - low).T
    pixels, weights = [], []
    for j, b in ((0, 1 - v), (1, v)):
        for i, a in ((0, 1 - u), (1, u)):
            column, row = low[:, 0] + i, low[:, 1] + j
            inside = known & (column >= 0) & (column < w) & (row >= 0) & (row < h)
            tap = (np.where(inside, row, 0) * w + np.where(inside, column, 0)).astype(np.int32)
            d = position[tap] - expected
            same = (dot(history_normal[tap], normal) >= _NORMALS) & (dot(d, d) <= reach * reach)
            pixels.append(tap)
            weights.append(a * b * (inside & same))
    weights = np.stack(weights, -1).astype(np.float32)
    total = weights.sum(-1, keepdims=True)
    return np.stack(pixels, -1), np.where(total > _FEWEST, weights / np.maximum(total, _FEWEST), 0)


def history_taps_on_gpu(gpu, before, expected, normal, footprint, slant, position, history_normal, limit: float):
    n, (h, w) = len(before), position.shape[:2]
    taps, weights = gpu.empty((n, 4), 4, np.int32), gpu.empty((n, 4), 4)
    limit = np.full(n, limit) if np.isscalar(limit) else limit
    inputs = {"before": (gpu.array(before, 2, nowhere=-1e30), 2), "expected": (expected, 3), "normal": (normal, 3),
              "footprint": (footprint, 1), "slant": (slant, 1), "position": (position, 3),
              "history_normal": (history_normal, 3), "limit": (limit, 1)}  # fmt: skip
    gpu.dispatch(
        "history_taps", n, inputs, {"taps": taps, "weights": weights}, integers={"width": w, "height": h}, steps=4
    )  # fmt: skip
    return taps, weights


def temporal(value, history, history_count, taps, weights, hdrp: bool = False, skipped: int = 0):
    """Values with their history.

    value: (n, c) float32, of this frame. history: (h, w, c), history_count: (h, w) float32, how many frames are in it.
    taps, weights: (n, 4) of `history_taps`. skipped: frames that are counted but not in it, for which the value stands
    too; none with `hdrp`.
    Returns (n, c) float32 and the new count (n,) float32.
    """
    n = np.maximum(np.einsum("nk,nk->n", weights, history_count.ravel()[taps]) - np.float32(skipped), 0)
    mixed = np.zeros_like(value)
    for k in range(4):
        mixed += weights[:, k, None] * history.reshape(-1, value.shape[1])[taps[:, k]]
    added = np.float32(1 + skipped)
    factor = n / (n + added)
    if hdrp:
        factor = np.where(n >= _HDRP_COUNT, _HDRP_FACTOR, factor)
        n = np.minimum(n, _HDRP_COUNT - 1)
    factor = factor[:, None].astype(np.float32)
    return value * (1 - factor) + mixed * factor, n + added


def temporal_on_gpu(gpu, value, history, history_count, taps, weights, hdrp: bool = False, skipped: int = 0):
    n, c = value.shape
    mixed, count = gpu.empty((n, c), c), gpu.empty((n,), 1)
    inputs = {"value": (value, c), "history": (history, c), "history_count": (history_count, 1), "taps": (taps, 4),
              "weights": (weights, 4)}  # fmt: skip
    gpu.dispatch("temporal", n, inputs, {"mixed": mixed, "count": count}, {"hdrp": hdrp, "skipped": skipped}, steps=4)
    return mixed, count
