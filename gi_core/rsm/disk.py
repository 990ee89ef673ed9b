# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The paper's sampling pattern: a disk around the point's own place in the map (Dachsbacher & Stamminger 2005, §3.2).

A sample (s + r ξ₁ sin 2πξ₂, t + r ξ₁ cos 2πξ₂) has density 1/(2π r² ξ₁), so its weight is ξ₁. The weight ξ₁²
is kept for comparison; it is biased. The estimate n_disk · Σ w E / Σ w, with n_disk the disk's area in texels,
counts texels off the map as dark.
"""

from dataclasses import dataclass

import numpy as np

from ..sampling import Samples, r2_sequence, rotated, signed
from ..surfels import Surfels
from .maps import Map
from .views import View, project

# Outside of every map, whatever the disk.
_NOWHERE = -1e9


@dataclass(frozen=True)
class Disk:
    """Texels of one map around a point's projection.

    radius: of the disk, as a share of the map's side. literal: weights ξ₁².
    """

    view: View
    rows: np.ndarray
    points: np.ndarray
    radius: float
    literal: bool
    seed: int
    sources = ("vpl_disk_samples", "vpl_disk")

    @staticmethod
    def of(source: Map, radius: float, samples: Samples, literal: bool, seed: int) -> "Disk":
        rows = np.full(source.view.resolution**2, -1, np.int64)
        rows[source.surfels.place] = np.arange(len(source.surfels))
        return Disk(source.view, rows, r2_sequence(samples.count, samples.first), radius, literal, seed)

    @property
    def lights(self) -> int:
        return len(self.points)

    @property
    def texels(self) -> float:
        """The disk's area in texels."""
        return np.pi * (self.radius * self.view.resolution) ** 2

    def __call__(self, here: Surfels):
        side = self.view.resolution
        xi = rotated(self.points, here.place, self.seed)
        r, phi = self.radius * xi[..., 0], 2 * np.pi * xi[..., 1]
        st = project(self.view, here.position)[:, None] + np.stack([r * np.sin(phi), r * np.cos(phi)], -1)
        with np.errstate(invalid="ignore"):
            inside = np.all((st >= 0) & (st < 1), -1)
            texel = np.minimum(np.where(inside[..., None], st * side, 0).astype(np.int64), side - 1)
        index = np.where(inside, self.rows[texel[..., 1] * side + texel[..., 0]], -1)
        weight = xi[..., 0] ** 2 if self.literal else xi[..., 0]
        return index, self.texels * weight / np.maximum(weight.sum(-1, keepdims=True), 1e-20)

    def on_gpu(self, gpu, here: Surfels, place):
        # Projected in double precision, which tells texels apart from far away too.
        # Behind the view it is not a number, which shaders need not know.
        projection = gpu.array(np.nan_to_num(project(self.view, here.position), nan=_NOWHERE), 2)
        samples = {"projection": (projection, 2), "place": (place, 2), "sample_point": (self.points, 2)}
        integers = {"pattern_seed": signed(self.seed), "literal": int(self.literal)}
        scale = gpu.empty((len(here),), 1)
        gpu.dispatch(
            "vpl_disk_scale", len(here), samples, {"scale": scale}, {**integers, "taken": self.lights},
            {"texels_in_disk": self.texels}, with_sources=("hash01", "place", "vpl_disk_samples"), steps=self.lights,
        )  # fmt: skip
        inputs = {**samples, "scale": (scale, 1), "light_of_texel": (self.rows, 1)}
        return inputs, {**integers, "side": self.view.resolution}, {"radius": self.radius}

    def order(self, here: Surfels, neighbours: int):
        return None
