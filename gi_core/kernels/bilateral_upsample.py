# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From a coarse image to points between its pixels: bilinear where the surface is the same (HDRP's bilateral upsample
of half-resolution passes, Kopf et al. 2007)."""

import numpy as np

from ..vectors import dot
from .surface_weight import plane_weight, surface_weight

# What a neighbour on another surface counts: where all four are, a point still gets their mix.
_LEAST = np.float32(1e-4)


def bilateral_upsample(at, depth, position, normal, value, coarse_depth, coarse_position, coarse_normal, far, scale):
    """Values at points, from the four pixels around each.

    at: (n, 2) float32, in pixels of the image, centres at whole numbers; NaN for off it. depth: (n,), position,
    normal: (n, 3) float32.
    value: (h, w, c), coarse_depth: (h, w), inf where no surface is, coarse_position, coarse_normal: (h, w, 3) float32.
    far, scale: of `surface_weight`.
    Returns (n, c) float32, and (n,) float32, how surely a neighbour shows the very place: in the neighbour's plane, on
    the same side of it, whatever the point's normal is else (that of a vertex is none of its faces'); 0…1. Both are 0
    off the image.
    """
    h, w, c = value.shape
    value, coarse_depth = value.reshape(-1, c), coarse_depth.ravel()
    coarse_position, coarse_normal = coarse_position.reshape(-1, 3), coarse_normal.reshape(-1, 3)
    on = np.isfinite(at).all(-1)
    at = np.clip(np.where(on[:, None], at, 0), 0, (w - 1, h - 1))
    low = np.minimum(np.floor(at), (max(w - 2, 0), max(h - 2, 0)))
    u, v = (at - low).T.astype(np.float32)
    total, weights, shown = np.zeros((len(at), c), np.float32), *np.zeros((2, len(at)), np.float32)
    for j, b in ((0, 1 - v), (1, v)):
        for i, a in ((0, 1 - u), (1, u)):
            row, column = np.minimum(low[:, 1] + j, h - 1), np.minimum(low[:, 0] + i, w - 1)
            tap = (row * w + column).astype(np.int32)
            there = coarse_depth[tap]
            surface = np.isfinite(there) & on
            there = np.where(surface, there, 0)
            tap_position, tap_normal = coarse_position.take(tap, 0), coarse_normal.take(tap, 0)
            like = surface_weight(depth / far, position, normal, there / far, tap_position, tap_normal, scale) * surface
            weight = a * b * np.maximum(like, _LEAST * surface)
            total += weight[:, None] * value.take(tap, 0)
            weights += weight
            dq = tap_position - position
            same = surface & (a * b > 0) & (dot(normal, tap_normal) > 0)
            shown = np.maximum(shown, same * plane_weight(dq, np.abs(dot(dq, tap_normal)), scale))
    return total / np.maximum(weights, np.float32(1e-20))[:, None], shown


def bilateral_upsample_on_gpu(
    gpu, at, depth, position, normal, value, coarse_depth, coarse_position, coarse_normal, far, scale
):
    (h, w, c), n = value.shape, len(at)
    result, shown = gpu.empty((n, c), c), gpu.empty((n,), 1)
    inputs = {"at": (gpu.array(at, 2, nowhere=-1e30), 2), "depth": (depth, 1), "position": (position, 3),
              "normal": (normal, 3), "value": (value, c), "coarse_depth": (coarse_depth, 1),
              "coarse_position": (coarse_position, 3), "coarse_normal": (coarse_normal, 3),
              "scale": (np.full(n, scale) if np.isscalar(scale) else scale, 1)}  # fmt: skip
    gpu.dispatch(
        "bilateral_upsample", n, inputs, {"result": result, "shown": shown}, integers={"width": w, "height": h},
        floats={"far_": far}, with_sources=("surface_weight",), steps=4,
    )  # fmt: skip
    return result, shown
