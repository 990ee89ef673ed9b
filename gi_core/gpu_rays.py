# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays on the graphics card, where the processor would be the slower."""

import logging
from dataclasses import replace

import numpy as np

from .bvh import Bvh, build
from .device import GpuDevice
from .geometry import Geometry
from .kernels.rays import closest, through
from .kernels.veil import Veil
from .tiles import on_asker, slices

_LOG = logging.getLogger(__name__)

# Bytes of a triangle and its boxes, and how many there may be: numbers of boxes have to be exact in single precision.
# They may fill half of what the card may hold, in which more is needed.
_TRIANGLE, _MOST = 80, 1 << 23

# Rays at once: of each there are about so many bytes on the card, of which they may fill a part.
_RAYS, _BYTES, _PART = 1 << 20, 64, 4


class GpuRays:
    """A geometry's triangles on the card, but for those that cast no shadow. To be used on the main thread, and on
    those that work on tiles for it.

    bvh: their hierarchy, as arrays on the card.
    """

    def __init__(self, geometry: Geometry, device: GpuDevice):
        self._device = device
        casts = np.flatnonzero(geometry.casts)
        bvh = build(geometry.vertices, geometry.triangles[casts])
        bvh = replace(bvh, triangle=casts[bvh.triangle])
        veil = Veil.of(geometry, bvh.triangle).on(device) if geometry.clear[casts].any() else None
        channels = {"low": 4, "high": 4, "a": 3, "b": 3, "c": 3, "triangle": 1}
        self.bvh = Bvh(*(device.array(getattr(bvh, name), c) for name, c in channels.items()), veil)

    def closest(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray, until: np.ndarray):
        """Triangle (n,) int32, −1 for a miss, weights (n, 3) of its corners and distance (n,) of where rays end.

        until: what may be left of them behind surfaces that let light through, (n,).
        """
        hits = self._asked(closest, (4,), origins, directions, far, until)
        u, v = hits[:, 1], hits[:, 2]
        met = hits[:, :1] >= 0
        return hits[:, 0].astype(np.int32), np.where(met, np.stack([1 - u - v, u, v], -1), 0), hits[:, 3]

    def transmittance(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> np.ndarray:
        """The share of light that comes through: (n,) float32."""
        return self._asked(through, (), origins, directions, far)

    def _asked(self, kernel, shape, origins, directions, far, *until) -> np.ndarray:
        found = np.zeros((len(origins), *shape), np.float32)

        def ask():
            for part in slices(len(origins), min(_RAYS, self._device.budget // (_PART * _BYTES))):
                rays = origins[part], directions[part], far[part], self.bvh, *(u[part] for u in until)
                found[part] = self._device.numpy(self._device.run(kernel, *rays))
            return found

        return on_asker(ask)


def gpu_rays(geometry: Geometry, device) -> GpuRays | None:
    """Rays on the card; None where Embree is to be asked: without a card, or where it cannot do what is needed."""
    if not device.traces or not geometry.casts.any():
        return None
    most = min(_MOST, device.budget // 2 // _TRIANGLE)
    if len(geometry.triangles) > most:
        _LOG.warning("rays are the processor's: of %d triangles the graphics card may hold %d (memory)",
                     len(geometry.triangles), most)  # fmt: skip
        return None
    return GpuRays(geometry, device)
