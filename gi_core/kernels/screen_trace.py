# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays from pixels to what the screen shows: drawn about the normal, put on the screen, marched, and judged where they
end."""

import numpy as np

from ..bump import shadowing
from ..sampling import cosine_hemisphere, hash01, rotated, signed
from ..vectors import dot, length
from .depth_march import depth_march

# What a ray found that is none, since it starts under the surface, and one that met nothing on the screen.
NO_RAY, MISSED = -2, -1

# The start bias as a share of the distance, and the slant at which it stops growing.
_BIAS, _LEAST_SLANT = np.float32(1e-3), np.float32(1e-2)

# How far off a pixel has to be, in its own size on the surface, to be one point to a ray.
_FAR_OFF = np.float32(4)


def rays_of(place, normal, face, points, seed: int, rows=None, mesh_normal=None):
    """Directions of the rays from each point, k of them, that leave the surface, and which of all they are.

    place: (n,) int, by which each point's sequence is shifted. normal, face: (n, 3) float32. points: (k, 2) float32 of
    the unit square. rows: of those that are wanted, all of which leave; None for all that do. mesh_normal: (n, 3) where
    `normal` is turned away from it: of the rays then leave as many as there is light that counts, see `bump`.
    Returns (m, 3) float32, and rows (m,) int64 of n · k.
    """
    k, every = len(points), rows is None
    rows = np.arange(len(place) * k) if every else rows
    up = normal[rows // k]
    direction = cosine_hemisphere(up, rotated(points, place, seed).reshape(-1, 2)[rows])
    if every:
        leaves = dot(direction, face[rows // k]) > 0
        if mesh_normal is not None:
            # The point itself tells the passes of a sequence apart.
            key = place.astype(np.uint32)[:, None] + (points[:, 0] * np.float32(1 << 24)).astype(np.uint32)
            leaves &= hash01(key, ~seed).reshape(-1) < shadowing(mesh_normal[rows // k], up, direction)
        rows = np.flatnonzero(leaves)
        direction = direction[rows]
    return direction, rows


def screen_trace(
    pixels, place, valid, depth, position, normal, face, march, points, screen, seed: int, back: float, steps: int,
    certain: bool, mesh_normal=None,
):  # fmt: skip
    """Which pixel each ray of each pixel meets.

    pixels: (n,) int32, of the screen. place: (n,) int, by which each one's sequence is shifted. valid: (h · w,) bool,
    pixels that may be met; None for all. depth: (h, w) [m], position, normal, face: (h, w, 3) float32. march: the
    DepthMap. points: (k, 2) float32 of the unit square. screen: the camera's. back, steps: of `depth_march`.
    certain: only hits in sight all the way, on the very surface that the pixel shows, and not so near that the pixel's
    size counts. mesh_normal: (h, w, 3), see `rays_of`.
    Returns (n · k,) int32: pixels, MISSED or NO_RAY.
    """
    k, depth = len(points), depth.ravel()
    position, normal, face = (a.reshape(-1, 3) for a in (position, normal, face))
    mesh_normal = mesh_normal if mesh_normal is None else mesh_normal.reshape(-1, 3)
    of_mesh = mesh_normal if mesh_normal is None else mesh_normal[pixels]
    direction, rows = rays_of(place, normal[pixels], face[pixels], points, seed, mesh_normal=of_mesh)
    out = np.full(len(pixels) * k, NO_RAY, np.int32)
    pixel = pixels[rows // k]
    here = position[pixel]
    row, column = np.divmod(pixel, screen.shape[1])
    slanted = normal if mesh_normal is None else mesh_normal
    z = depth[pixel] * (1 - _BIAS / np.maximum(dot(slanted[pixel], screen.towards(here)), _LEAST_SLANT))
    start = np.stack([column + np.float32(0.5), row + np.float32(0.5), screen.device(z)], -1).astype(np.float32)
    way = screen.march(here, direction).astype(np.float32)
    near = screen.device(screen.camera.clip[0])
    hit, hidden = depth_march(start, way, march.cells, march.table, near, back, steps, certain)
    out[rows] = MISSED
    kept = np.flatnonzero((hit >= 0) & ~hidden if certain else hit >= 0)
    rows, hit, here, direction = rows[kept], hit[kept], here[kept], direction[kept]
    facing = face[hit]
    # A surface turned away shows the eye another side than the one that the ray meets.
    good = dot(facing, direction) < 0
    if certain:
        d = position[hit] - here
        along = dot(d, direction)
        off = length(d - along[:, None] * direction)
        slant = np.abs(dot(facing, screen.towards(position[hit])))
        size = screen.footprint(depth[hit])
        good &= (off * slant <= size) & (along * slant >= _FAR_OFF * size)
    if valid is not None:
        good &= valid[hit]
    out[rows[good]] = hit[good]
    return out


def screen_trace_on_gpu(
    gpu, pixels, place, valid, depth, position, normal, face, march, points, screen, seed: int, back: float,
    steps: int, certain: bool, mesh_normal=None,
):  # fmt: skip
    h, w = depth.shape
    n, k = len(pixels), len(points)
    hit = gpu.empty((n * k,), 1, np.int32)
    inputs = {
        "pixels": (pixels, 1), "place": (place, 1), "depth": (depth, 1), "position": (position, 3),
        "normal": (normal, 3), "face": (face, 3), "points": (points, 2),
        "axes": (screen.frame, 3), "cells": (march.cells, 3),
    }  # fmt: skip
    inputs |= {} if valid is None else {"valid": (valid, 1)}
    inputs |= {} if mesh_normal is None else {"mesh_normal": (mesh_normal, 3)}
    unit_x, unit_y = screen.pixels_per_unit
    gpu.dispatch(
        "screen_trace", n * k, inputs, {"hit": hit},
        integers={"width": w, "height": h, "steps": steps, "top": len(march.table) - 1,
                  "parallel": screen.parallel, "seed": signed(seed), "sure": certain},
        floats={"near_": screen.device(screen.camera.clip[0]), "back": back, "unit_x": unit_x, "unit_y": unit_y,
                "footprint": screen.footprint(np.ones(1, np.float32))[0]},
        defines={"RAYS": k, "CERTAIN": int(certain), "VALID": int(valid is not None),
                 "BUMPY": int(mesh_normal is not None)},
        with_sources=("angles", "hash01", "sampling", "march", "bump"), steps=steps,
    )  # fmt: skip
    return hit
