# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What pictures' rays meet first, found by drawing the triangles where that is faster than to trace them."""

import logging
from collections.abc import Iterator

import numpy as np

from .device import Device
from .geometry import Geometry
from .kernels.raster import raster
from .raster import Grid, covered

_LOG = logging.getLogger(__name__)

# Bytes of a triangle, and how many there may be: their numbers have to be exact in single precision. They may fill a
# quarter of what the card may hold, beside the triangles that rays meet there.
_TRIANGLE, _MOST = 52, 1 << 24

# Pixels that are looked at for each of the picture's, at the most: rays are faster than to draw many layers.
_LAYERS = 64

# Pixels that numpy looks at in one go; for its own sake no picture is drawn.
_PIXELS = 1 << 16


class Raster:
    """Some of a geometry's triangles, where pictures are drawn. To be used on the main thread."""

    def __init__(self, geometry: Geometry, index: np.ndarray, device: Device):
        self._geometry, self._index, self._device = geometry, index, device
        corners = geometry.vertices[geometry.triangles[index]]
        self._corners = [device.array(np.ascontiguousarray(corners[:, k]), 3) for k in range(3)]

    def drawn(self, grid: Grid, origins: np.ndarray, directions: np.ndarray) -> Iterator[float]:
        """What the rays of a picture's pixels, (w · h, 3) each, row by row, meet first. A generator of progress.

        Returns triangle (n,) int32, −1 for a miss, weights (n, 3) of its corners and distance (n,); None where rays are
        the better choice.
        """
        device, n, width = self._device, len(origins), grid.size[0]
        which, rectangle = covered(grid, self._geometry.vertices, self._geometry.triangles[self._index])
        area = np.prod(rectangle[:, 1::2] - rectangle[:, ::2], 1, dtype=np.int64).sum()
        if area > _LAYERS * n or max(grid.size) > device.side:
            _LOG.info("a picture of %d x %d is traced: triangles would be drawn over %d pixels", *grid.size, area)
            return None
        far = np.max(np.abs(self._geometry.bounds - grid.origin)) * 2 + np.max(np.abs(origins - grid.origin)) * 2

        def rows(part: slice):
            first, last = part.start // width, part.stop // width
            here = np.flatnonzero((rectangle[:, 2] < last) & (rectangle[:, 3] > first))
            inside = rectangle[here] - [0, 0, first, first]
            inside[:, 2:] = np.clip(inside[:, 2:], 0, last - first)
            return device.run(raster, origins[part], directions[part], width, self._corners, which[here], inside, far)

        hits = yield from device.each(rows, n, max(1, _PIXELS // width) * width)
        triangle, u, v, distance = device.numpy(hits).T
        found = triangle >= 0
        out = np.full(n, -1, np.int32)
        out[found] = self._index[triangle[found].astype(np.int64)]
        weights = np.where(found[:, None], np.stack([1 - u - v, u, v], -1), np.float32(0))
        return out, weights, np.ascontiguousarray(distance)


def raster_of(geometry: Geometry, index: np.ndarray, device: Device) -> Raster | None:
    """Pictures drawn on a graphics card; None where Embree is to be asked, which is faster than to draw in software.

    index: (k,) the triangles.
    """
    if device.software or not len(index):
        return None
    most = min(_MOST, device.budget // 4 // _TRIANGLE)
    if len(index) > most:
        _LOG.warning("pictures are traced: of %d triangles the graphics card may hold %d (memory)", len(index), most)
        return None
    return Raster(geometry, index, device)
