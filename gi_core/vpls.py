# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Virtual point lights: points that send reflected or emitted light on."""

from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np

from .device import Device
from .sampling import morton, systematic
from .vectors import lit, pick


@dataclass(frozen=True)
class Vpls:
    """Lambertian point lights.

    position: (n, 3) float32, where they are [m]; origin: (n, 3) float32, the same just off the surface, where rays
        start and end.
    normal: (n, 3) float32, unit axis of the lobe: the surface's own normal, not its shading normal.
    flux: (n, 3) float32 radiant flux Φ [W].
    area: (n,) float32 of the surface that each stands for [m²].
    """

    position: np.ndarray
    origin: np.ndarray
    normal: np.ndarray
    flux: np.ndarray
    area: np.ndarray

    @cached_property
    def brightness(self) -> np.ndarray:
        """(n,) float32: mean of the flux over its channels [W]."""
        return self.flux.mean(-1)

    def __len__(self) -> int:
        return len(self.position)

    def __getitem__(self, which) -> "Vpls":
        """The lights that a slice, mask or index array picks."""
        return Vpls(*(pick(getattr(self, f.name), which) for f in fields(self)))

    @staticmethod
    def concatenate(parts: "list[Vpls]") -> "Vpls":
        empty = Vpls(*(np.zeros((0, 3), np.float32) for _ in range(4)), np.zeros(0, np.float32))
        return Vpls(*(np.concatenate([getattr(p, f.name) for p in [empty, *parts]]) for f in fields(Vpls)))


@dataclass(frozen=True)
class Packed:
    """Lights as kernels read them, in few fetches; numpy arrays or the device's.

    at: (m, 4) position and area [m²]. axis: (m, 4) normal and brightness. flux, origin: (m, 3).
    """

    at: np.ndarray
    axis: np.ndarray
    flux: np.ndarray
    origin: np.ndarray

    @staticmethod
    def of(vpls: Vpls, area: float | None = None) -> "Packed":
        """area: of all [m²], None for each light's own."""
        area = vpls.area if area is None else np.full(len(vpls), area, np.float32)
        at, axis = (np.stack([*v.T, w], -1) for v, w in ((vpls.position, area), (vpls.normal, vpls.brightness)))
        return Packed(at, axis, vpls.flux, vpls.origin)

    def on(self, device: Device, with_origins: bool) -> "Packed":
        """with_origins: whether rays are asked for there."""
        there = (device.array(a, a.shape[1]) for a in (self.at, self.axis, self.flux))
        return Packed(*there, device.array(self.origin, 3) if with_origins else self.origin)


def coherent(vpls: Vpls) -> np.ndarray:
    """The indices of the lights that shine at all, (m,), in an order in which neighbours face alike and are close.

    By the octant of the normal, then along the Z-order curve through space. Whatever draws evenly from the list is then
    stratified over the scene's surfaces.
    """
    shining = np.flatnonzero(lit(vpls.flux))
    if not len(shining):
        return shining
    position = vpls.position[shining]
    low, high = position.min(0), position.max(0)
    # Where cells and octants meet lies askew to the planes and axes that surfaces are built along, or rounding, which
    # is not the same on all devices, would put half of a wall elsewhere.
    cells = ((position - low) / np.maximum(np.max(high - low), 1e-20) * 1022 + 0.3819).astype(np.uint32)
    octant = (vpls.normal[shining] > 1e-3) @ np.array([1, 2, 4])
    return shining[np.lexsort((morton(cells), octant))]


def equalized(vpls: Vpls, weight: np.ndarray, n: int) -> Vpls:
    """n lights that stand for all, drawn in proportion to a weight (n,), evenly along the list.

    A light's flux goes up as much as it is drawn less, so that all flux is kept in expectation. With the flux itself as
    the weight all have the same brightness: taking any of them is drawing from the flux's CDF, without a search. Where
    the weight is concentrated a light is drawn more than once; each copy stands for its share of the area.
    """
    if not len(vpls):
        return vpls
    index = systematic(weight, n)
    share = (np.sum(weight, dtype=np.float64) / (n * weight[index].astype(np.float64))).astype(np.float32)
    drawn = vpls[index]
    return Vpls(drawn.position, drawn.origin, drawn.normal, drawn.flux * share[:, None], drawn.area * share)
