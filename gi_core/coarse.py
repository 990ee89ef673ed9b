# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmaps whose reflected light is found at coarse texels and mixed between them where the surface is the same.

Screen-space interpolation (Dachsbacher & Stamminger 2005, §3.3) on the surface instead of the screen, with the weights
of `kernels.bilateral_upsample`. What no coarse texel around it shows gathers for itself, as in the paper.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from . import borders
from .device import Device
from .filter import pixel_footprint
from .kernels.bilateral_upsample import bilateral_upsample
from .receivers import Receiver
from .surfels import TILE, Surfels
from .trace import Tracer

# How surely a coarse texel must show a place, see `bilateral_upsample`: within 15 degrees of one of their planes.
_SURE = 0.25


@dataclass(frozen=True)
class Coarse:
    """Light at coarse texels.

    step: texels along the side of a coarse one. layers: by receiver, images of coarse texels (h, w, c) float32:
        "Indirect" [W/m²], "Position", "Normal", and "Coverage", 0 where there is no surface.
    """

    step: int
    layers: dict[str, dict[str, np.ndarray]]

    @staticmethod
    def of(
        tracer: Tracer, step: int, receivers: Sequence[Receiver], layers: dict[str, dict[str, np.ndarray]]
    ) -> "Coarse":
        """Of what coarse receivers collected, with "Centred" too. Coarse texels whose darkness says nothing of the
        surface around them, see `borders.unlit`, show nothing."""
        kept = {}
        for receiver in receivers:
            found = layers[receiver.name]
            valid = found["Coverage"][..., 0] > 0
            unlit = borders.unlit(tracer, receiver, found["Indirect"], valid, found["Centred"][..., 0])
            kept[receiver.name] = {**found, "Coverage": (valid & ~unlit)[..., None]}
        return Coarse(step, kept)

    def at(self, device: Device, receiver: Receiver, points: Surfels) -> Iterator[float]:
        """Light at points of a receiver: (n, 3) float32 [W/m²], and whether a coarse texel shows the place, (n,) bool:
        a generator of progress that returns both."""
        layers = self.layers[receiver.name]
        position, normal = layers["Position"], layers["Normal"]
        there = layers["Coverage"][..., 0] > 0
        span = pixel_footprint(position, normal)[there]
        row, column = np.divmod(points.place, receiver.width)
        at = (np.stack([column, row], -1) + 0.5) / self.step - 0.5
        # All are equally deep: the weights go by normals and planes alone.
        depth, coarse_depth = np.ones(len(points), np.float32), np.where(there, np.float32(1), np.float32(np.inf))
        coarse = layers["Indirect"], coarse_depth, position, normal, 1.0, np.float32(span.mean() if len(span) else 1)
        here = at.astype(np.float32), depth, points.position, points.normal

        def work(part: slice):
            return device.run(bilateral_upsample, *(a[part] for a in here), *coarse)

        light, shown = yield from device.each(work, len(points), TILE)
        return device.numpy(light), device.numpy(shown) > _SURE
