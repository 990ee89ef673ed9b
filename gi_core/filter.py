# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Noise smoothed along surfaces, and subpixels resolved to pixels."""

from collections.abc import Iterator

import numpy as np

from .device import NUMPY, Device
from .kernels.bilateral import bilateral
from .trace import Tracer
from .vectors import length

# A tile's pixels, at least: with fewer, numpy's own time counts.
_PIXELS = 1 << 15

# All pixels that have a next one, and these: along rows, and along columns.
_NEIGHBOURS = (
    ((slice(None), slice(0, -1)), (slice(None), slice(1, None))),
    ((slice(0, -1), slice(None)), (slice(1, None), slice(None))),
)


def reach(passes: int) -> int:
    """How far a value depends on others through so many passes [pixels]; their footprints look one further."""
    return 2 * ((1 << passes) - 1) + 1


def smooth(value, position, normal, passes: int, walls=None, device: Device = NUMPY) -> Iterator[float]:
    """The joint bilateral filter over an image of surface points, reaching 4, 12, 28 … pixels from the centre with 1,
    2, 3 … passes.

    value: (h, w, c), position, normal: (h, w, 3) float32; a normal of zero marks pixels without a surface. walls: what
        `walls_between` found, None where all that is filtered together is in sight of each other.
    A generator of progress; returns (h, w, c) float32.
    """
    h, w, _ = value.shape
    seen = [(position, 3), (normal, 3), (pixel_footprint(position, normal), 1)]
    position, normal, footprint = (device.array(*one) for one in seen)
    walls = walls if walls is None else device.array(walls, 2)
    for k in range(passes):
        step = 1 << k

        def tile(rows: slice, value=value, step=step):
            return device.run(bilateral, value, position, normal, footprint, step, walls, rows)

        value = yield from device.each(tile, h, max(4 * step, _PIXELS // w))
    return device.numpy(value)


def walls_between(tracer: Tracer, position: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """How many walls stand between a pixel and the beginning of its row, and of its column: (h, w, 2) float32.

    A texel of a floor may lie a hand's breadth from one in the next room. Whether something stands between two
    neighbours is asked by a ray from one to the other, half a pixel above the surface. An island's border is a wall
    too: what lies behind the gap may be anywhere, in the same plane as well.
    """
    footprint = pixel_footprint(position, normal)
    lifted = (position + 0.5 * footprint[..., None] * normal).astype(np.float32)
    counts = np.zeros((*footprint.shape, 2), np.float32)
    for k, (before, after) in enumerate(_NEIGHBOURS):
        here, there = footprint[before] > 0, footprint[after] > 0
        pair = here & there
        blocked = (here != there).astype(np.float32)
        blocked[pair] = ~tracer.connected(lifted[before][pair], lifted[after][pair])
        counts[(*after, k)] = np.cumsum(blocked, 1 - k)
    return counts


def pixel_footprint(position: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Distance on the surface between a pixel and the nearer of its neighbours: (h, w, 3) twice -> (h, w) float32 [m].

    Zero where there is no surface.
    """
    valid = np.any(normal != 0, -1)
    nearest = np.full(valid.shape, np.inf, np.float32)
    for before, after in _NEIGHBOURS:
        d = np.where(valid[before] & valid[after], length(position[after] - position[before]), np.float32(np.inf))
        nearest[before] = np.minimum(nearest[before], d)
        nearest[after] = np.minimum(nearest[after], d)
    lonely = ~np.isfinite(nearest)
    # A pixel without neighbours on a surface keeps to itself whatever its size.
    return np.where(valid, np.where(lonely, 1.0, np.maximum(nearest, 1e-12)), 0).astype(np.float32)
