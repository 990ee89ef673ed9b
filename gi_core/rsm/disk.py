# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sampling pattern: a disk around the point's own place in the map (Dachsbacher & Stamminger 2005, §3.2).

A sample (s + r ξ₁ sin 2πξ₂, t + r ξ₁ cos 2πξ₂) has density 1/(2π r² ξ₁), so its weight is ξ₁. The literal ξ₁² of the
brief is kept for comparison; it is biased. The estimate n_disk · Σ w E / Σ w, with n_disk the disk's area in texels,
counts texels off the map as dark.
"""

import numpy as np

from ..gathering import Pattern
from ..sampling import Samples, r2_sequence, rotated
from ..surfels import Surfels
from .maps import Map
from .views import project


def disk_pattern(source: Map, radius: float, samples: Samples, literal: bool, seed: int) -> Pattern:
    """Texels of one map around a point's projection. radius: of the disk, as a share of the map's side."""
    side = source.view.resolution
    row_of_texel = np.full(side * side, -1, np.int64)
    row_of_texel[source.surfels.place] = np.arange(len(source.surfels))
    points = r2_sequence(samples.count, samples.first)
    texels_in_disk = np.pi * (radius * side) ** 2

    def pattern(here: Surfels):
        xi = rotated(points, here.place, seed)
        r, phi = radius * xi[..., 0], 2 * np.pi * xi[..., 1]
        st = project(source.view, here.position)[:, None] + np.stack([r * np.sin(phi), r * np.cos(phi)], -1)
        with np.errstate(invalid="ignore"):
            inside = np.all((st >= 0) & (st < 1), -1)
            texel = np.where(inside[..., None], st * side, 0).astype(np.int64)
        index = np.where(inside, row_of_texel[texel[..., 1] * side + texel[..., 0]], -1)
        weight = xi[..., 0] ** 2 if literal else xi[..., 0]
        return index, texels_in_disk * weight / np.maximum(weight.sum(-1, keepdims=True), 1e-20)

    return pattern
