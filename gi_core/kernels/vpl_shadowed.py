# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights that points do not see count nothing."""

import numpy as np

from ..vectors import dot, length
from .rays import through, trace

# A ray's end over the distance of the light: a hair short, or rounding lets the light's own surface block it.
_SHORT = np.float32(1 - 1e-4)


def shadowed(picked: np.ndarray, origin: np.ndarray, face: np.ndarray, light_origin: np.ndarray, bvh) -> np.ndarray:
    """Lights with their weights times the share that comes through what is between, zero for those behind a point's
    surface.

    picked: (s, n, 2), see `vpl_gather.chosen`. origin, face: (n, 3) where rays start and the face's normal there.
    light_origin: (m, 3). bvh: what they may meet. Returns (s, n, 2) float32.
    """
    d = light_origin[picked[..., 0].astype(np.int64)] - origin
    distance = length(d)
    seen = (picked[..., 1] > 0) & (dot(d, face) > 0)
    start, far = np.broadcast_to(origin, d.shape)[seen], distance[seen]
    share = np.zeros(seen.shape, np.float32)
    share[seen] = through(start, d[seen] / np.maximum(far, 1e-20)[:, None], far * _SHORT, bvh)
    return np.stack([picked[..., 0], picked[..., 1] * share], -1)


def shadowed_on_gpu(gpu, picked, origin, face, light_origin, bvh):
    s, n, _ = picked.shape
    found = gpu.empty((s, n, 2), 2)
    inputs = {"picked": (picked, 2), "origin": (origin, 3), "face": (face, 3), "light_origin": (light_origin, 3)}
    trace(gpu, "vpl_shadowed", s * n, inputs, {"found": found}, {"points": n}, bvh=bvh, is_any=True)
    return found
