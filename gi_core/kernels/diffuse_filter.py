# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The diffuse filter (HDRP, DiffuseDenoiser.compute): points of a disk in each pixel's tangent plane, projected to the
screen, averaged where what is seen there is the same surface.

A tap at r from the centre counts by exp(−(r / 0.9 R)²) and by `surface_weight`; the centre counts 1. Taps off screen,
on background, or whose depth is not that of the disk's point are dropped; the source's limit for the latter is 0.1 m at
its radius of 0.6 m, here it is R/6.
"""

import numpy as np

from ..sampling import frame, hash01, signed
from .surface_weight import surface_weight

_SIGMA, _DEPTH = np.float32(0.9), np.float32(1 / 6)


def diffuse_filter(
    pixels, value, depth, position, normal, radius, taps, matrix, far: float, scale, literal: bool = False,
    seed: int | None = None,
):  # fmt: skip
    """Values averaged along the surface.

    pixels: (n,) int, which pixels. value: (h, w, c) float32. depth: (h, w) float32 along the view axis, inf where no
        surface is. position, normal: (h, w, 3) float32. radius: (n,) float32, R [m]. taps: (n, k, 2) float32 points in
        the unit disk, or (k, 2) for all. matrix: (4, 4), world to x · w, y · w, depth and w, x and y in pixels whose
        centres are whole numbers. far: depth that counts as 1. scale, literal: of `surface_weight`. seed: of an angle
        that each pixel turns its taps by; None for none.
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
    turn = 0 if seed is None else np.float32(2 * np.pi) * hash01(pixels, seed)
    cosine, sine = np.cos(turn), np.sin(turn)
    for k in range(taps.shape[-2]):
        x, y = taps[..., k, 0], taps[..., k, 1]
        count = np.exp(-(x * x + y * y) / _SIGMA**2)
        x, y = cosine * x - sine * y, sine * x + cosine * y
        point = here + (radius * x)[:, None] * tangent + (radius * y)[:, None] * bitangent
        at = projected(point, matrix)
        inside = (at[:, 2] > 0) & (at[:, 0] > -0.5) & (at[:, 0] < w - 0.5) & (at[:, 1] > -0.5) & (at[:, 1] < h - 0.5)
        column, row = (np.where(inside, np.round(at[:, i]), 0).astype(np.int32) for i in (0, 1))
        tap = np.clip(row, 0, h - 1) * w + np.clip(column, 0, w - 1)
        there = depth[tap]
        kept = inside & surface & np.isfinite(there) & (np.abs(there - at[:, 2]) <= radius * _DEPTH)
        there = np.where(kept, there, 0)
        weight = surface_weight(z / far, here, up, there / far, position[tap], normal[tap], scale, literal)
        weight = weight * count * kept
        total += weight[:, None] * value[tap]
        weights += weight
    return (total / weights[:, None] * surface[:, None]).astype(np.float32)


def diffuse_filter_on_gpu(
    gpu, pixels, value, depth, position, normal, radius, taps, matrix, far: float, scale, literal: bool = False,
    seed: int | None = None,
):  # fmt: skip
    (h, w, c), n = value.shape, len(pixels)
    result = gpu.empty((n, c), c)
    # With what each counts by where it is.
    taps = np.concatenate([taps, np.exp(-(taps * taps).sum(-1, keepdims=True) / _SIGMA**2)], -1)
    inputs = {"pixels": (pixels, 1), "value": (value, c), "depth": (depth, 1), "position": (position, 3),
              "normal": (normal, 3), "radius": (radius, 1), "taps": (taps, 3), "matrix": (matrix, 4),
              "scale": (np.full(n, scale) if np.isscalar(scale) else scale, 1)}  # fmt: skip
    gpu.dispatch(
        "diffuse_filter", n, inputs, {"result": result},
        integers={"width": w, "height": h, "count": taps.shape[-2], "literal": literal, "turned": seed is not None,
                  "seed": signed(seed or 0)},
        floats={"far_": far}, defines={"SHARED": int(len(taps.shape) == 2)},
        with_sources=("angles", "hash01", "sampling", "surface_weight"), steps=taps.shape[-2],
    )  # fmt: skip
    return result


def projected(points, matrix):
    """World points on the screen: (n, 3), matrix as above -> (n, 3) float32: x, y, depth."""
    x, y, z, w = (points @ matrix[:, :3].T.astype(np.float32) + matrix[:, 3].astype(np.float32)).T
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.stack([x / w, y / w, z], -1)
