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

    at: (n, 2) float32, in pixels of the image, centres at whole numbers. depth: (n,), position, normal: (n, 3) float32.
    value: (h, w, c), coarse_depth: (h, w), inf where no surface is, coarse_position, coarse_normal: (h, w, 3) float32.
    far, scale: of `surface_weight`.
    Returns (n, c) float32, and (n,) float32, how surely a neighbour shows the very place: in the neighbour's plane, on
    the same side of it, whatever the point's normal is else (that of a vertex is none of its faces'); 0…1.
    """
    h, w, c = value.shape
    value, coarse_depth = value.reshape(-1, c), coarse_depth.ravel()
    coarse_position, coarse_normal = coarse_position.reshape(-1, 3), coarse_normal.reshape(-1, 3)
    at = np.clip(at, 0, (w - 1, h - 1))
    low = np.minimum(np.floor(at), (max(w - 2, 0), max(h - 2, 0)))
    u, v = (at - low).T.astype(np.float32)
    total, weights, shown = np.zeros((len(at), c), np.float32), *np.zeros((2, len(at)), np.float32)
    for j, b in ((0, 1 - v), (1, v)):
        for i, a in ((0, 1 - u), (1, u)):
            row, column = np.minimum(low[:, 1] + j, h - 1), np.minimum(low[:, 0] + i, w - 1)
            tap = (row * w + column).astype(np.int32)
            there = coarse_depth[tap]
            surface = np.isfinite(there)
            there = np.where(surface, there, 0)
            like = surface_weight(
                depth / far, position, normal, there / far, coarse_position[tap], coarse_normal[tap], scale
            ) * surface  # fmt: skip
            weight = a * b * np.maximum(like, _LEAST * surface)
            total += weight[:, None] * value[tap]
            weights += weight
            dq = coarse_position[tap] - position
            same = surface & (a * b > 0) & (dot(normal, coarse_normal[tap]) > 0)
            shown = np.maximum(shown, same * plane_weight(dq, np.abs(dot(dq, coarse_normal[tap])), scale))
    return total / np.maximum(weights, np.float32(1e-20))[:, None], shown
