# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A hierarchy of boxes around triangles, in which a graphics card finds what a ray meets.

Built from the top, all boxes of a level at once: each is cut along the axis on which its triangles are spread most,
where of sixteen places the surface area heuristic finds the cheapest (Wald 2007, "On fast Construction of SAH-based
Bounding Volume Hierarchies").
"""

from dataclasses import dataclass

import numpy as np

from .kernels.veil import Veil

# Triangles in a leaf, at the most.
LEAF = 4

_BINS = 16

# From this level on boxes are halved, so that the depth is bounded whatever the triangles are.
_HALVED = 32

# Levels at the most: those, and as many as halve the most triangles that there may be.
DEPTH = _HALVED + 24


@dataclass(frozen=True)
class Bvh:
    """Boxes and triangles.

    low, high: (k, 4) float32 corners of boxes. Inner ones have in low[:, 3] the first of two boxes that follow each
        other, and 0 in high[:, 3]; leaves have the first of their triangles and how many they are. The first is around
        all.
    a, b, c: (t, 3) float32 corners of triangles, those of a leaf one after the other.
    triangle: (t,) int32, which they were.
    veil: how solid they are; None where all are.
    """

    low: np.ndarray
    high: np.ndarray
    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    triangle: np.ndarray
    veil: Veil | None = None


def build(vertices: np.ndarray, triangles: np.ndarray) -> Bvh:
    """The hierarchy of triangles: (v, 3) float32, (t, 3) integers, at least one."""
    corners = vertices[triangles]
    # In planes: numpy's reductions over short axes are slow.
    low, high = (np.ascontiguousarray(f(corners, 1).T) for f in (np.min, np.max))
    centre = (low + high) / 2
    order = np.arange(len(triangles))
    begin, end, base = np.array([0]), np.array([len(order)]), 0
    lows, highs = [], []
    for level in range(DEPTH + 1):
        count = end - begin
        row, start = _rows(begin, count)
        node_low, node_high = _boxes(low, high, order[row], start)
        inner = np.flatnonzero(count > LEAF)
        following = base + len(count)
        first = begin.copy()
        first[inner] = following + 2 * np.arange(len(inner))
        lows.append(np.column_stack([node_low.T, first]))
        highs.append(np.column_stack([node_high.T, np.where(count > LEAF, 0, count)]))
        if not len(inner):
            break
        begin, end = begin[inner], end[inner]
        middle = begin + _cut(low, high, centre, order, begin, end - begin, level >= _HALVED)
        begin, end = (np.stack(pair, -1).ravel() for pair in ((begin, middle), (middle, end)))
        base = following
    a, b, c = (np.ascontiguousarray(corners[order, k], np.float32) for k in range(3))
    boxes = (np.concatenate(parts).astype(np.float32) for parts in (lows, highs))
    return Bvh(*boxes, a, b, c, order.astype(np.int32))


def _rows(begin: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The rows of ranges, one range after the other, and where each range starts among them."""
    start = np.cumsum(count) - count
    return np.repeat(begin - start, count) + np.arange(count.sum()), start


def _boxes(low, high, triangle, start) -> tuple[np.ndarray, np.ndarray]:
    """Corners of the boxes around ranges of triangles: (3, m) twice."""
    return (
        np.stack([np.minimum.reduceat(plane[triangle], start) for plane in low]),
        np.stack([np.maximum.reduceat(plane[triangle], start) for plane in high]),
    )


def _cut(low, high, centre, order, begin, count, halved: bool) -> np.ndarray:
    """Sorts each range of `order` so that it can be cut in two; returns how many go to the first part, (m,)."""
    row, start = _rows(begin, count)
    triangle, node = order[row], np.repeat(np.arange(len(count)), count)
    first, last = _boxes(centre, centre, triangle, start)
    extent = last - first
    axis = np.argmax(extent, 0)
    pick = axis, np.arange(len(axis))
    along = centre[axis[node], triangle] - first[pick][node]
    with np.errstate(divide="ignore"):
        scale = np.where(extent[pick] > 0, _BINS / extent[pick], 0)
    cell = np.minimum((along * scale[node]).astype(np.int64), _BINS - 1) + node * _BINS
    by_cell = np.argsort(cell, kind="stable")
    triangle, cell = triangle[by_cell], cell[by_cell]
    order[row] = triangle
    if halved:
        return count // 2

    filled = np.flatnonzero(np.diff(cell, prepend=-1))
    shape = (3, len(count), _BINS)
    lows, highs = np.full((3, len(count) * _BINS), np.inf), np.full((3, len(count) * _BINS), -np.inf)
    lows[:, cell[filled]], highs[:, cell[filled]] = _boxes(low, high, triangle, filled)
    lows, highs = lows.reshape(shape), highs.reshape(shape)
    number = np.bincount(cell, minlength=len(count) * _BINS).reshape(shape[1:])
    before = np.cumsum(number, -1)[:, :-1]
    left = np.minimum.accumulate(lows, -1)[..., :-1], np.maximum.accumulate(highs, -1)[..., :-1]
    right = (f.accumulate(a[..., ::-1], -1)[..., -2::-1] for f, a in ((np.minimum, lows), (np.maximum, highs)))
    behind = count[:, None] - before
    with np.errstate(invalid="ignore"):
        cost = _area(*left) * before + _area(*right) * behind
    cost = np.where((before > 0) & (behind > 0), cost, np.inf)
    best = np.argmin(cost, -1)
    split = np.take_along_axis(before, best[:, None], -1)[:, 0]
    # Centres that all lie in one place cannot be told apart.
    return np.where(np.isfinite(np.min(cost, -1)), split, count // 2)


def _area(low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Half the surface of boxes: (3, …) twice -> (…)."""
    x, y, z = high - low
    return x * y + y * z + z * x
