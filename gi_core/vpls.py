# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Virtual point lights: points that send reflected or emitted light on."""

from dataclasses import dataclass, fields

import numpy as np

from .sampling import systematic


@dataclass(frozen=True)
class Vpls:
    """Lambertian point lights.

    position: (n, 3) float32, where they are [m]; origin: (n, 3) float32, the same just off the surface, where rays
        start and end.
    normal: (n, 3) float32, unit axis of the lobe.
    flux: (n, 3) float32 radiant flux Φ [W].
    area: (n,) float32 of the surface that each stands for [m²].
    """

    position: np.ndarray
    origin: np.ndarray
    normal: np.ndarray
    flux: np.ndarray
    area: np.ndarray

    def __len__(self) -> int:
        return len(self.position)

    def __getitem__(self, rows) -> "Vpls":
        """The lights that a slice, mask or index array picks."""
        return Vpls(*(getattr(self, f.name)[rows] for f in fields(self)))

    @staticmethod
    def concatenate(parts: "list[Vpls]") -> "Vpls":
        empty = Vpls(*(np.zeros((0, 3), np.float32) for _ in range(4)), np.zeros(0, np.float32))
        return Vpls(*(np.concatenate([getattr(p, f.name) for p in [empty, *parts]]) for f in fields(Vpls)))


def equalized(vpls: Vpls, n: int) -> Vpls:
    """n lights of equal brightness that stand for all: drawn in proportion to flux, evenly along the list.

    Drawing from the result is drawing from the flux's CDF, without a search for each sample. Total flux is kept exactly
    in the mean over the channels. Where flux is concentrated a light is drawn more than once; each copy stands for its
    share of the area.
    """
    if not len(vpls):
        return vpls
    weight = vpls.flux.mean(-1).astype(np.float64)
    index = systematic(weight, n)
    share = (weight.sum() / (n * weight[index])).astype(np.float32)
    drawn = vpls[index]
    return Vpls(drawn.position, drawn.origin, drawn.normal, drawn.flux * share[:, None], drawn.area * share)
