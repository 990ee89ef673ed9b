# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The nearest triangle of each pixel, by looking at each triangle's pixels.

A triangle is drawn as a rectangle of pixels that is sure to cover it, and each pixel's own ray decides whether it is
met, and where, as in `rays`. So it does not matter where in its pixel a ray passes, and what comes out is what rays
find, up to the edges (Davidovič et al. 2012 so make one thing of rasterising and ray casting). A graphics card keeps
the nearest by its depth buffer. Of equally near triangles the first is kept.
"""

import numpy as np

from .rays import met

# Pixels of rectangles looked at at once.
_PAIRS = 1 << 16

# The distance of a miss [m].
MISS = np.float32(1e30)


def raster(origins: np.ndarray, directions: np.ndarray, width: int, corners, which, rectangle, reach) -> np.ndarray:
    """What the rays of a picture's pixels meet first: (n, 3), (n, 3) float32 unit directions -> (n, 4) float32.

    The rays are those of whole rows of so many pixels. corners: a, b and c of triangles, (t, 3) float32 each.
    which, rectangle: (m,) int32 triangles, and (m, 4) int32 first and last column and row of the pixels that they may
    cover, the last not included. reach: no hit is as far [m].
    Of each the triangle, −1 for a miss, the weights of its second and third corner, and the distance.
    """
    hits = np.zeros((len(origins), 4), np.float32)
    hits[:, 0], hits[:, 3] = -1, MISS
    columns = rectangle[:, 1] - rectangle[:, 0]
    count = columns * (rectangle[:, 3] - rectangle[:, 2]).astype(np.int64)
    end = np.cumsum(count)
    first = 0
    while first < len(which):
        last = max(first + 1, int(np.searchsorted(end, end[first] - count[first] + _PAIRS, "right")))
        k = np.repeat(np.arange(first, last), count[first:last])
        pixel = np.arange(len(k)) - (end - count)[k] + (end - count)[first]
        row, column = np.divmod(pixel, columns[k])
        i = (rectangle[k, 2] + row) * width + rectangle[k, 0] + column
        first, triangle = last, which[k]
        distance, u, v = met(*(corner[triangle] - origins[i] for corner in corners), directions[i])
        hit = np.flatnonzero((distance >= 0) & (distance < reach))
        hit = hit[np.lexsort((distance[hit], i[hit]))]
        hit = hit[np.flatnonzero(np.diff(i[hit], prepend=-1))]
        hit = hit[distance[hit] < hits[i[hit], 3]]
        hits[i[hit]] = np.stack([triangle[hit], u[hit], v[hit], distance[hit]], -1)
    return hits


def raster_on_gpu(gpu, origins, directions, width, corners, which, rectangle, reach):
    inputs = {"origin": (origins, 3), "direction": (directions, 3), "which": (which, 1)}
    inputs |= {f"corner_{name}": (corner, 3) for name, corner in zip("abc", corners)}
    return gpu.draw("raster", (width, len(origins) // width), rectangle, inputs, (-1, 0, 0, MISS), reach, ("triangle",))
