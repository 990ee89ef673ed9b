# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From slices of the horizon scan to the light that they bring."""

import numpy as np


def scan_light(arrived, open_share, rest, level: int, slices: int):
    """Mean radiance over each pixel's slices.

    arrived: (n · slices, c), open_share: (n · slices,) float32, of `horizon_scan`. rest: (n, levels, c) float32, the
    radiance of what is not on the screen, of which `level` counts; None for nothing.
    Returns (n, c) float32, and (n,) float32, the share of what is not on the screen.
    """
    n, c = len(arrived) // slices, arrived.shape[-1]
    if rest is not None:
        arrived = arrived + open_share[:, None] * np.repeat(rest[:, level], slices, 0)
    light = arrived.reshape(n, slices, c).sum(1) / np.float32(slices)
    return light, open_share.reshape(n, slices).sum(1) / np.float32(slices)


def scan_light_on_gpu(gpu, arrived, open_share, rest, level: int, slices: int):
    n, c = len(arrived) // slices, arrived.shape[-1]
    light, missed = gpu.empty((n, c), c), gpu.empty((n,), 1)
    inputs = {"arrived": (arrived, c), "open_share": (open_share, 1)}
    gpu.dispatch(
        "scan_light", n, inputs if rest is None else {**inputs, "rest": (rest, c)},
        {"light": light, "missed": missed},
        integers={} if rest is None else {"level": level, "levels": rest.shape[1]},
        defines={"SLICES": slices, "REST": int(rest is not None)}, steps=slices,
    )  # fmt: skip
    return light, missed
