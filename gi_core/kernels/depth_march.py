# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays marched through the depth of an image (HDRP, RayMarching.hlsl): up a closest-depth pyramid where nothing is
near, down where something may be.

Screen space is x, y in pixels, edges at whole numbers, and a device depth that is linear along rays there (−1/z in
perspective, z in parallel projection; near is small). What a pixel shows fills the space from its depth back to `back`
times that. A ray hits where it enters that space, from in front or from the side; where it comes out of a surface's
back it ends without a hit; deeper than that it goes on behind.

Three things differ from the source. A pixel's surface is its tangent plane, not a step at its centre's depth: steps
catch rays that leave a slanted surface at a low angle. Rays towards the eye climb the pyramid too, which is safe since
they only move away from what a texel holds. A ray that comes out of a surface's back never counts as a hit.
"""

import numpy as np

# How far into the next cell a position on an edge is moved [pixels].
_EPSILON = np.float32(2**-12)
_HALF = np.float32(0.5)
_NO_END = np.float32(1e30)

# What has ended is thrown out once it is this much: throwing out costs as much as some steps.
_IDLE = 0.2


def depth_march(origin, direction, cells, table, near: float, back: float, steps: int, sure: bool = False):
    """Where rays meet what an image shows.

    origin: (n, 3) float32 in screen space, at the centres of pixels. direction: (n, 3) float32, of any length.
    cells: of `march_cells`, table: of `depth_pyramid`. near: the device depth of the near plane. sure: rays end,
        without a hit, where they go behind something.
    Returns (n,) int32: the pixel hit (row · w + column), −1 for none; and (n,) bool: some of the way lay
    behind what the image shows, so something else may have been met there.
    """
    n, (_, w, h) = len(origin), table[0]
    hit, hidden = np.full(n, -1, np.int32), np.zeros(n, bool)
    depth, slope_x, slope_y = np.ascontiguousarray(cells.T)
    offset, width, top = table[:, 0].copy(), table[:, 1].copy(), np.int32(len(table) - 1)
    back = np.float32(back)

    # Directions that are exactly along an axis would make 0 · ∞; a hair off it they do not.
    direction = np.where(np.abs(direction) < 1e-20, np.float32(1e-20), direction)
    ox, oy, oz = np.ascontiguousarray(origin.T)
    dx, dy, dz = np.ascontiguousarray(direction.T)
    with np.errstate(over="ignore"):
        rx, ry, rz = 1 / dx, 1 / dy, 1 / dz
        # Out of the pixel that it starts in.
        t = np.minimum(np.abs(_HALF * rx), np.abs(_HALF * ry))
        end = np.minimum(
            (np.where(rx > 0, np.float32(w) - _HALF, _HALF) - ox) * rx,
            (np.where(ry > 0, np.float32(h) - _HALF, _HALF) - oy) * ry,
        )
        # Away from the eye the depth ends at nothing, towards it at the near plane. In perspective nothing is at 0.
        end = np.minimum(end, np.where(rz > 0, np.where(oz < 0, -oz * rz, _NO_END), (np.float32(near) - oz) * rz))
    state = [np.arange(n), ox, oy, oz, dx, dy, dz, rx, ry, t, end, np.zeros(n, np.int32), np.zeros(n, bool)]
    live = t <= end

    for _ in range(steps):
        count = np.count_nonzero(live)
        if not count:
            break
        if count < (1 - _IDLE) * len(live):
            rows = np.flatnonzero(live)
            state, live = [a.take(rows) for a in state], np.ones(count, bool)
        ray, ox, oy, oz, dx, dy, dz, rx, ry, t, end, mip, below = state
        # What has ended stays where it began.
        np.copyto(t, np.float32(0), where=~live)
        x, y, z = ox + t * dx, oy + t * dy, oz + t * dz
        column = (x + np.copysign(_EPSILON, rx)).astype(np.int32) >> mip
        row = (y + np.copysign(_EPSILON, ry)).astype(np.int32) >> mip
        cell = (offset.take(mip) + row * width.take(mip) + column).astype(np.intp)
        with np.errstate(over="ignore", invalid="ignore"):
            wall = np.minimum(
                (((column + (rx > 0)) << mip).astype(np.float32) - ox) * rx,
                (((row + (ry > 0)) << mip).astype(np.float32) - oy) * ry,
            )
        # At the finest level the pixel's plane, above it the nearest that the texel holds.
        tilt_x, tilt_y = slope_x.take(cell), slope_y.take(cell)
        ground = tilt_x * (x - column.astype(np.float32) - _HALF) + tilt_y * (y - row.astype(np.float32) - _HALF)
        ground += depth.take(cell)
        gap, closing = z - ground, dz - tilt_x * dx - tilt_y * dy
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            crossing = t - gap / closing
        under, fine = gap > 0, (mip == 0) & live
        crosses = (crossing >= t) & (crossing <= wall)
        enters = crosses & ~under & (closing > 0)
        inside = under & (z <= ground * back)
        buried = fine & under
        if sure:
            hits, ends = fine & enters, fine & (enters | under)
        else:
            hits, ends = fine & (enters | (inside & ~below)), fine & (enters | inside | (under & crosses))
        for found, values, where in ((hit, cell, hits), (hidden, under, buried)):
            rows = np.flatnonzero(where)
            found[ray[rows]] = values[rows]

        down = enters | under
        np.copyto(t, crossing, where=enters & ~fine)
        np.copyto(t, wall, where=fine | ~down)
        state[11] = np.clip(mip + np.where(down, np.int32(-1), np.int32(1)), 0, top)
        state[12] = buried
        live &= ~ends & (t <= end)
    return hit, hidden


def depth_march_on_gpu(gpu, origin, direction, cells, table, near: float, back: float, steps: int, sure: bool = False):
    n, (_, w, h) = len(origin), table[0]
    hit, hidden = gpu.empty((n,), 1, np.int32), gpu.empty((n,), 1, bool)
    gpu.dispatch(
        "depth_march", n, {"origin": (origin, 3), "direction": (direction, 3), "cells": (cells, 3)},
        {"hit": hit, "hidden": hidden},
        integers={"width": w, "height": h, "steps": steps, "top": len(table) - 1, "sure": sure},
        floats={"near_": near, "back": back}, with_sources=("march",), steps=steps,
    )  # fmt: skip
    return hit, hidden
