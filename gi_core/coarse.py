# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmaps whose reflected light is found at coarse texels and mixed between them where the surface is the same.

Screen-space interpolation (Dachsbacher & Stamminger 2005, §3.3) on the surface instead of the screen, with the weights
of `kernels.bilateral_upsample`. What no coarse texel around it shows gathers for itself, as in the paper.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from . import borders
from .device import Device
from .filter import pixel_footprint
from .kernels.bilateral_upsample import bilateral_upsample
from .receivers import Receiver
from .surfels import TILE, Surfels

# How surely a coarse texel must show a place, see `bilateral_upsample`: within 15 degrees of one of their planes.
_SURE = 0.25

# The coarse texels around a place.
_CORNERS = (0, 0), (1, 0), (0, 1), (1, 1)


@dataclass(frozen=True)
class Coarse:
    """Light at coarse texels.

    step: texels along the side of a coarse one. layers: by receiver, images of coarse texels (h, w, c) float32:
        "Indirect" [W/m²], "Position", "Normal", "Coverage", 0 where there is no surface; and bool: "Centred", "Inside",
        see `TileLight.on`.
    """

    step: int
    layers: dict[str, dict[str, np.ndarray]]

    def at(self, device: Device, receiver: Receiver, points: Surfels) -> Iterator[float]:
        """Light at points of a receiver: (n, 3) float32 [W/m²]; whether it is known, (n,) bool: a coarse texel shows
        the place, or all four around it lie inside of something, where no light is; and the latter, (n,) bool. A
        generator of progress that returns the three."""
        layers = self.layers[receiver.name]
        position, normal = layers["Position"], layers["Normal"]
        surface, centred, inside = (layers[name][..., 0] > 0 for name in ("Coverage", "Centred", "Inside"))
        # Coarse texels whose darkness says nothing of the surface around them show nothing.
        there = surface & ~borders.unlit(layers["Indirect"], surface, centred, inside)
        span = pixel_footprint(position, normal)[there]
        row, column = np.divmod(points.place, receiver.width)
        at = (np.stack([column, row], -1) + 0.5) / self.step - 0.5
        # All are equally deep: the weights go by normals and planes alone.
        depth, coarse_depth = np.ones(len(points), np.float32), np.where(there, np.float32(1), np.float32(np.inf))
        coarse = layers["Indirect"], coarse_depth, position, normal, 1.0, np.float32(span.mean() if len(span) else 1)
        here = at.astype(np.float32), depth, points.position, points.normal

        def work(part: slice):
            return device.run(bilateral_upsample, *(a[part] for a in here), *coarse)

        light, shown = yield from device.each(work, len(points), TILE // 4)
        light, sure = device.numpy(light), device.numpy(shown) > _SURE
        x, y = np.floor(at).astype(int).T
        height, width = inside.shape
        rows, columns = (np.clip([k, k + 1], 0, n - 1) for k, n in ((y, height), (x, width)))
        around = [inside.take(rows[j] * width + columns[i]) for i, j in _CORNERS]
        deep = np.logical_and.reduce(around)
        return np.where(deep[:, None], 0, light), sure | deep, deep
