# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From what rays met to the light that they bring."""

import numpy as np

from .screen_trace import MISSED


def hit_light(hit, picture, rest, level: int, rays: int):
    """Mean radiance over each pixel's rays.

    hit: (n · rays,) int32 pixels, negative for none, see `screen_trace`. picture: (h, w, c) float32. rest: (n, levels,
    c) float32, what the rays that met none add to the mean, of which `level` counts; None for nothing.
    Returns (n, c) float32, and (n,) float32, the share of rays that missed.
    """
    hit, picture = hit.reshape(-1, rays), picture.reshape(-1, picture.shape[-1])
    light = np.zeros((len(hit), picture.shape[1]), np.float32) if rest is None else rest[:, level].copy()
    for one in hit.T:
        light += np.where(one[:, None] >= 0, picture[one], 0) / np.float32(rays)
    return light, (hit == MISSED).mean(-1, dtype=np.float32) if len(hit) else np.zeros(0, np.float32)


def hit_light_on_gpu(gpu, hit, picture, rest, level: int, rays: int):
    n, c = len(hit) // rays, picture.shape[-1]
    light, missed = gpu.empty((n, c), c), gpu.empty((n,), 1)
    inputs = {"hit": (hit, 1), "picture": (picture, c)}
    gpu.dispatch(
        "hit_light", n, inputs if rest is None else {**inputs, "rest": (rest, c)},
        {"light": light, "missed": missed},
        integers={} if rest is None else {"level": level, "levels": rest.shape[1]},
        defines={"RAYS": rays, "REST": int(rest is not None)}, steps=rays,
    )  # fmt: skip
    return light, missed
