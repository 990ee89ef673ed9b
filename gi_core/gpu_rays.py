# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays on the graphics card, where the processor would be the slower."""

import logging
from dataclasses import fields

import numpy as np

from .bvh import Bvh, build
from .device import GpuDevice
from .geometry import Geometry
from .kernels.rays import closest, occluded

_LOG = logging.getLogger(__name__)

# Triangles at the most: some 80 bytes each, in memory that is needed for more than them.
_MOST = 1 << 22


class GpuRays:
    """A geometry's triangles on the card. To be used on the main thread.

    bvh: their hierarchy, as arrays on the card.
    """

    def __init__(self, geometry: Geometry, device: GpuDevice):
        self._device = device
        bvh = build(geometry.vertices, geometry.triangles)
        channels = {"low": 4, "high": 4, "triangle": 1}
        self.bvh = Bvh(*(device.array(getattr(bvh, f.name), channels.get(f.name, 3)) for f in fields(Bvh)))

    def closest(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray):
        """Triangle (n,) int32, −1 for a miss, weights (n, 3) of its corners and distance (n,) of the nearest hits."""
        hits = self._device.numpy(self._device.run(closest, origins, directions, far, self.bvh))
        u, v = hits[:, 1], hits[:, 2]
        return hits[:, 0].astype(np.int32), np.stack([1 - u - v, u, v], -1), hits[:, 3]

    def occluded(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> np.ndarray:
        """(n,) bool."""
        return self._device.numpy(self._device.run(occluded, origins, directions, far, self.bvh))


def gpu_rays(geometry: Geometry, device) -> GpuRays | None:
    """Rays on the card; None where Embree is to be asked: without a card, or where it cannot do what is needed."""
    if device.software or not len(geometry.triangles):
        return None
    if geometry.clear.any():
        _LOG.info("rays stay on the processor: the scene has surfaces with an alpha")
        return None
    if len(geometry.triangles) > _MOST:
        _LOG.info("rays stay on the processor: the scene has more than %d triangles", _MOST)
        return None
    return GpuRays(geometry, device)
