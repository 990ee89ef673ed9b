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

import math

import numpy as np

# How far into the next cell a position on an edge is moved [pixels].
_EPSILON = np.float32(2**-12)


def depth_march(origin, direction, depth, slope, pyramid, table, near: float, back: float, steps: int):
    """Where rays meet what an image shows.

    origin: (n, 3) float32 in screen space, at the centres of pixels. direction: (n, 3) float32, of any length.
    depth: (h, w) float32, device depth, NOTHING where no surface is. slope: (h, w, 2) float32, its change per pixel
        along x and y. pyramid, table: of `depth_pyramid`. near: the device depth of the near plane.
    Returns (n,) int32: the pixel hit (row · w + column), −1 for none; and (n,) bool: some of the way lay
    behind what the image shows, so something else may have been met there.
    """
    n, (h, w) = len(origin), depth.shape
    hit, hidden = np.full(n, -1, np.int32), np.zeros(n, bool)
    depth, slope_x, slope_y = depth.ravel(), slope[..., 0].ravel(), slope[..., 1].ravel()
    offset, width = table[:, 0], table[:, 1]
    top = np.int32(len(table) - 1)

    # Directions that are exactly along an axis would make 0 · ∞; a hair off it they do not.
    direction = np.where(np.abs(direction) < 1e-20, np.float32(1e-20), direction)
    ox, oy, oz = np.ascontiguousarray(origin.T)
    dx, dy, dz = np.ascontiguousarray(direction.T)
    with np.errstate(over="ignore"):
        rx, ry, rz = 1 / dx, 1 / dy, 1 / dz
        # Out of the pixel that it starts in.
        t = np.minimum(np.abs(0.5 * rx), np.abs(0.5 * ry))
        end = np.minimum(
            (np.where(rx > 0, w - np.float32(0.5), np.float32(0.5)) - ox) * rx,
            (np.where(ry > 0, h - np.float32(0.5), np.float32(0.5)) - oy) * ry,
        )
        # Away from the eye the depth ends at nothing, towards it at the near plane. In perspective nothing is at 0.
        end = np.minimum(end, np.where(rz > 0, np.where(oz < 0, -oz * rz, NO_END), (np.float32(near) - oz) * rz))
    ray, mip, below = np.arange(n), np.zeros(n, np.int32), np.zeros(n, bool)
    state = [ray, ox, oy, oz, dx, dy, dz, rx, ry, t, end, mip, below]

    for _ in range(steps):
        keep = state[9] <= state[10]
        if not keep.all():
            state = [a[keep] for a in state]
        ray, ox, oy, oz, dx, dy, dz, rx, ry, t, end, mip, below = state
        if not len(ray):
            break
        px, py = _past_edge(ox + t * dx, rx), _past_edge(oy + t * dy, ry)
        column, row = px.astype(np.int32) >> mip, py.astype(np.int32) >> mip
        floor = pyramid[offset[mip] + row * width[mip] + column]
        with np.errstate(over="ignore", invalid="ignore"):
            wall = np.minimum(
                (((column + (rx > 0)) << mip) - ox) * rx,
                (((row + (ry > 0)) << mip) - oy) * ry,
            )
        fine = mip == 0
        # At the finest level the pixel's plane, above it the nearest that the texel holds.
        pixel = np.where(fine, row * np.int32(w) + column, 0)
        sx, sy = np.where(fine, slope_x[pixel], 0), np.where(fine, slope_y[pixel], 0)
        floor = np.where(fine, depth[pixel] + sx * (ox + t * dx - column - 0.5) + sy * (oy + t * dy - row - 0.5), floor)
        z = oz + t * dz
        gap, closing = z - floor, dz - sx * dx - sy * dy
        under = gap > 0
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            crossing = t - gap / closing
        crosses = (crossing >= t) & (crossing <= wall)
        enters = crosses & ~under & (closing > 0)
        inside = under & (z <= floor * np.float32(back))
        ends = fine & ((inside & below) | (under & ~inside & crosses))
        hits = fine & ~ends & (enters | inside)
        hit[ray[hits]] = pixel[hits]
        hidden[ray[fine & under]] = True

        onward = np.where(enters, crossing, np.where(fine | ~under, wall, t))
        state[9] = np.where(hits | ends, np.float32(np.inf), onward)
        state[11] = np.clip(mip + np.where(enters | under, np.int32(-1), np.int32(1)), 0, top)
        state[12] = fine & under
    return hit, hidden


def depth_march_on_gpu(gpu, origin, direction, depth, slope, pyramid, table, near: float, back: float, steps: int):
    n, (h, w) = len(origin), depth.shape
    hit, hidden = gpu.empty((n,), 1, np.int32), gpu.empty((n,), 1, bool)
    inputs = {"origin": (origin, 3), "direction": (direction, 3), **march_inputs(gpu, depth, slope, pyramid)}
    gpu.dispatch(
        "depth_march", n, inputs, {"hit": hit, "hidden": hidden},
        integers={"width": w, "height": h, "steps": steps, "top": len(table) - 1}, floats={"near_": near, "back": back},
        with_sources=("march",), steps=steps,
    )  # fmt: skip
    return hit, hidden


def march_inputs(gpu, depth, slope, pyramid) -> dict:
    """What march.glsl reads."""
    cells = gpu.empty((len(pyramid), 3), 3)
    inputs = {"march_depth": (depth, 1), "march_slope": (slope, 2), "pyramid": (pyramid, 1)}
    gpu.dispatch("march_cells", len(pyramid), inputs, {"cells": cells}, integers={"size": math.prod(depth.shape)})
    return {"cells": (cells, 3)}


NO_END = np.float32(1e30)


def _past_edge(position, reciprocal):
    """Positions (n,) on an edge between cells, moved a hair in the ray's direction, into the cell that comes."""
    sign = np.where(reciprocal > 0, np.float32(1), np.float32(-1))
    return position + sign * np.clip(sign * (np.round(position) - position) + _EPSILON, 0, _EPSILON)
