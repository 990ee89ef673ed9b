# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Silhouettes, where a pixel is a mixture that two renderers mix differently."""

import numpy as np

# How far a neighbour may lie off a pixel's plane, as a share of its distance from the camera: one that faces elsewhere,
# as beyond a corner, and one that faces alike, as a picture's frame before the wall that it hangs on.
TOLERANCE, LEDGE = 0.05, 0.005
_ALIKE = 0.99


def smooth(position: np.ndarray, normal: np.ndarray, distance: np.ndarray) -> np.ndarray:
    """Pixels whose four neighbours lie on their surface or near it: (h, w) bool.

    position, normal: (h, w, 3) in the world. distance: (h, w) from the camera [m], what is beyond 1e9 being no
    surface. Planes of both count, so a floor seen at a grazing angle is no edge, and a corner of two walls is none.
    """
    edge = np.zeros(distance.shape, bool)
    surface = distance < 1e9
    for axis in (0, 1):
        n = distance.shape[axis]
        one, other = (lambda a, r=r, axis=axis: np.take(a, r, axis) for r in (range(n - 1), range(1, n)))
        step = other(position) - one(position)
        off = np.maximum(*(np.abs((side(normal) * step).sum(-1)) for side in (one, other)))
        allowed = np.where((one(normal) * other(normal)).sum(-1) > _ALIKE, LEDGE, TOLERANCE)
        apart = (off > allowed * np.minimum(one(distance), other(distance))) | (one(surface) != other(surface))
        before, after = [(0, 0), (0, 0)], [(0, 0), (0, 0)]
        before[axis], after[axis] = (0, 1), (1, 0)
        edge |= np.pad(apart, before) | np.pad(apart, after)
    return ~edge
