# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The diffuse filter (HDRP, DiffuseDenoiser.compute): points of a disk in each pixel's tangent plane, projected to the
screen, averaged where what is seen there is the same surface.

A tap at r from the centre counts by exp(−(r / 0.9 R)²) and by `surface_weight`; the centre counts 1. Taps off screen,
on background, or whose depth is not that of the disk's point are dropped; the source's limit for the latter is 0.1 m at
its radius of 0.6 m, here it is R/6.
"""

import numpy as np

from ..sampling import frame
from .surface_weight import surface_weight

_SIGMA, _DEPTH = np.float32(0.9), np.float32(1 / 6)


def diffuse_filter(
    pixels, value, depth, position, normal, radius, taps, matrix, far: float, scale, literal: bool = False
):
    """Values averaged along the surface.

    pixels: (n,) int, which pixels. value: (h, w, c) float32. depth: (h, w) float32 along the view axis, inf where no
        surface is. position, normal: (h, w, 3) float32. radius: (n,) float32, R [m]. taps: (n, k, 2) float32 points in
        the unit disk. matrix: (4, 4), world to x · w, y · w, depth and w, x and y in pixels whose centres are whole
        numbers. far: depth that counts as 1. scale, literal: of `surface_weight`.
    Returns (n, c) float32, zero on background.
    """
    h, w, c = value.shape
    value, depth = value.reshape(-1, c), depth.ravel()
    position, normal = position.reshape(-1, 3), normal.reshape(-1, 3)
    here, up, z = position[pixels], normal[pixels], depth[pixels]
    surface = np.isfinite(z)
    z = np.where(surface, z, 0)
    tangent, bitangent = frame(up)
    total, weights = value[pixels].astype(np.float32), np.ones(len(pixels), np.float32)
    for k in range(taps.shape[1]):
        x, y = taps[:, k, 0], taps[:, k, 1]
        point = here + (radius * x)[:, None] * tangent + (radius * y)[:, None] * bitangent
        at = projected(point, matrix)
        inside = (at[:, 2] > 0) & (at[:, 0] > -0.5) & (at[:, 0] < w - 0.5) & (at[:, 1] > -0.5) & (at[:, 1] < h - 0.5)
        column, row = (np.where(inside, np.round(at[:, i]), 0).astype(np.int32) for i in (0, 1))
        tap = np.clip(row, 0, h - 1) * w + np.clip(column, 0, w - 1)
        there = depth[tap]
        kept = inside & surface & np.isfinite(there) & (np.abs(there - at[:, 2]) <= radius * _DEPTH)
        there = np.where(kept, there, 0)
        weight = np.exp(-(x * x + y * y) / _SIGMA**2) * kept
        weight = weight * surface_weight(z / far, here, up, there / far, position[tap], normal[tap], scale, literal)
        total += weight[:, None] * value[tap]
        weights += weight
    return (total / weights[:, None] * surface[:, None]).astype(np.float32)


def projected(points, matrix):
    """World points on the screen: (n, 3), matrix as above -> (n, 3) float32: x, y, depth."""
    x, y, z, w = (points @ matrix[:, :3].T.astype(np.float32) + matrix[:, 3].astype(np.float32)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([x / w, y / w, z], -1)
