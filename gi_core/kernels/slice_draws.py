# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The random numbers of the horizon scan."""

import numpy as np

from ..sampling import hash01, r2_sequence, rotated, signed


def slice_draws(place, first: int, count: int, seed: int):
    """Turn, first step and rounding of each pixel's slices from the `first` on: (n,) int -> (n · count, 3) float32."""
    turn = rotated(r2_sequence(count, first), place, seed)[..., 0]
    more = [[hash01(place, seed * 65536 + 4 * index + k) for k in (2, 3)] for index in range(first, first + count)]
    return np.concatenate([turn[..., None], np.array(more).transpose(2, 0, 1)], -1).reshape(-1, 3)


def slice_draws_on_gpu(gpu, place, first: int, count: int, seed: int):
    u = gpu.empty((len(place) * count, 3), 3)
    gpu.dispatch(
        "slice_draws", len(place) * count, {"place": (place, 1), "points": (r2_sequence(count, first), 2)}, {"u": u},
        integers={"seed": signed(seed), "more": signed(seed * 65536 + 4 * first)}, defines={"SLICES": count},
        with_sources=("angles", "hash01", "sampling"),
    )  # fmt: skip
    return u
