# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights count less that a point's normal map turns to beyond what the mesh sees, see `bump`."""

import numpy as np

from ..bump import shadowing
from ..vectors import length


def bumped(picked, position, normal, mesh_normal, light_at) -> np.ndarray:
    """Lights by weights that are lowered: (s, n, 2), see `vpl_gather.chosen`, to the same, float32 or float64.

    position, normal, mesh_normal: (n, 3) of the points. light_at: (m, 4), see `vpls.Packed`.
    """
    sample, row = np.nonzero(picked[..., 1] > 0)
    d = light_at[picked[sample, row, 0].astype(np.int64), :3] - position[row]
    d /= np.maximum(length(d), np.float32(1e-20))[:, None]
    found = picked.copy()
    found[sample, row, 1] *= shadowing(mesh_normal[row], normal[row], d)
    return found


def bumped_on_gpu(gpu, picked, position, normal, mesh_normal, light_at):
    s, n, _ = picked.shape
    found = gpu.empty((s, n, 2), 2)
    inputs = {"picked": (picked, 2), "position": (position, 3), "normal": (normal, 3), "mesh_normal": (mesh_normal, 3)}
    gpu.dispatch(
        "vpl_bump", s * n, {**inputs, "light_at": (light_at, 4)}, {"found": found}, integers={"points": n},
        with_sources=("bump",),
    )  # fmt: skip
    return found
