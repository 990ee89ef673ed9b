# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which texels of a lightmap belong to which triangle: conservative rasterising in UV space."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .atlas import Place
from .tiles import slices

# Candidate (triangle, texel) pairs looked at in one go; bounds the memory of a large map to some 200 MB.
_BATCH = 1 << 20

# Of barycentric weights: of double numbers, and of UVs in single ones on an edge that triangles share.
_ROUNDING, _SHARED = 1e-9, 1e-3

# How far points leave the edge that they were clamped to [texels].
_DRAWN_IN = 0.25


@dataclass(frozen=True)
class Texels:
    """Texels that triangles touch, at most one entry per texel, ascending.

    place: (n,) int64, row · width + column.
    triangle: (n,) int64, the triangle that holds the texel's centre, or else comes closest to it.
    weights: (n, 3) float32, barycentric weights of the centre, or of a point near it a little inside of the triangle.
    centred: (n,) bool, the centre lies in the triangle.
    """

    place: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    centred: np.ndarray

    def within(self, place: Place, width: int) -> "Texels":
        """Those on an object's own square of an image that is so wide."""
        column, row = self.place % width, self.place // width
        low, high = np.floor((place.x, place.y)), np.ceil((place.x + place.side, place.y + place.side))
        own = (column >= low[0]) & (column < high[0]) & (row >= low[1]) & (row < high[1])
        return Texels(self.place[own], self.triangle[own], self.weights[own], self.centred[own])


def covered_texels(uvs: np.ndarray, resolution: tuple[int, int], rows: slice | None = None) -> Texels:
    """Every texel that a triangle touches: (t, 3, 2) UV coordinates, (width, height) -> Texels.

    rows: those to look at, None for all.

    What lies outside [0, 1]² is left out. Where several triangles touch a texel, the one nearest its centre has it, the
    first of them where they are equally near.
    """
    w, h = resolution
    top, bottom = (h, 0) if rows is None else (rows.stop, rows.start)
    distance = np.full(w * (top - bottom), np.inf)
    triangle = np.full(len(distance), -1, np.int64)
    weights = np.zeros((len(distance), 3), np.float32)
    for part in slices(len(uvs), _BATCH):
        pixels, finite = _pixels(uvs[part], resolution)
        for t, texel in _candidates(pixels, finite, resolution, bottom, top):
            place = (texel[:, 1] - bottom) * w + texel[:, 0]
            # Triangles come in their order: those of a batch are next to each other.
            edges = _Edges.of(pixels[t[0] : t[-1] + 1])
            bary, inside, touching = edges.met(t - t[0], texel + 0.5)
            # Where indices repeat the last assignment counts: backwards, so that the first triangle has the texel.
            rest, inside = np.flatnonzero(touching & ~inside), np.flatnonzero(inside)[::-1]
            inside = inside[distance[place[inside]] > 0]
            at = place[inside]
            distance[at], triangle[at], weights[at] = 0, part.start + t[inside], bary[inside]

            rest = rest[distance[place[rest]] > 0]
            bary, d2 = _closest_weights(pixels[t[rest]], texel[rest] + 0.5)
            closest = np.argsort(d2, kind="stable")[::-1]
            closest = closest[d2[closest] < distance[place[rest[closest]]]]
            at = place[rest[closest]]
            distance[at], triangle[at], weights[at] = d2[closest], part.start + t[rest[closest]], bary[closest]

    found = np.flatnonzero(triangle >= 0)
    triangle, weights, centred = triangle[found], weights[found], distance[found] == 0
    clamped, _ = _pixels(uvs[triangle[~centred]], resolution)
    weights[~centred] = _drawn_in(clamped, weights[~centred])
    return Texels(found + w * bottom, triangle, weights, centred)


def _drawn_in(corners: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Points on triangles' edges, a little towards their middles: at the edge itself a floor lies in the wall that
    stands on it, and sees nothing. (n, 3, 2) [texels], (n, 3) -> (n, 3) float32."""
    way = np.einsum("nk,nkc->nc", weights - 1 / 3, corners)
    length = np.maximum(np.linalg.norm(way, axis=-1, keepdims=True), 1e-12)
    share = np.minimum(_DRAWN_IN / length, 0.5).astype(np.float32)
    return (1 - share) * weights + share / 3


def overlap(uvs: np.ndarray, side: int = 512) -> float:
    """Share of what triangles cover that more than one of them covers, 0…1, by side² samples: (t, 3, 2) UVs."""
    count = np.zeros(side * (side + 1), np.int64)
    for part in slices(len(uvs), _BATCH):
        pixels, finite = _pixels(uvs[part], (side, side))
        # What two triangles share is an edge, and no overlap.
        middle = pixels.mean(1, keepdims=True)
        corners = middle + (1 - 3 * _SHARED) * (pixels[finite] - middle[finite])
        for row, begin, end in _spans(corners, side):
            # Each sample of a row counts what begins before it and has not ended.
            count += np.bincount(row * (side + 1) + begin, minlength=len(count))
            count -= np.bincount(row * (side + 1) + end, minlength=len(count))
    count = np.cumsum(count.reshape(side, side + 1), 1)
    covered = np.count_nonzero(count)
    return float(np.count_nonzero(count > 1) / covered) if covered else 0.0


def _spans(corners: np.ndarray, side: int) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Texels' middles that triangles (t, 3, 2) [texels] cover, in batches: (n,) rows, first columns, and the columns
    after the last."""
    low, high = (np.ceil(np.clip(f(corners[..., 1], 1), 0, side) - 0.5).astype(np.int64) for f in (np.min, np.max))
    ends = np.cumsum(high - low)
    for start in range(0, int(ends[-1]) if len(ends) else 0, _BATCH):
        line = np.arange(start, min(start + _BATCH, int(ends[-1])))
        t = np.searchsorted(ends, line, "right")
        row = high[t] - (ends[t] - line)
        left, right = np.full(len(t), np.inf), np.full(len(t), -np.inf)
        for i, j in ((0, 1), (1, 2), (2, 0)):
            (x, y), (to_x, to_y) = corners[t, i].T, corners[t, j].T
            with np.errstate(divide="ignore", invalid="ignore"):
                share = (row + 0.5 - y) / (to_y - y)
            cut = (share >= 0) & (share <= 1)
            at = x + np.where(cut, share, 0) * (to_x - x)
            left = np.where(cut, np.minimum(left, at), left)
            right = np.where(cut, np.maximum(right, at), right)
        begin, end = (np.ceil(np.clip(at, 0, side) - 0.5).astype(np.int64) for at in (left, right))
        yield row, begin, np.maximum(end, begin)


def outside(uvs: np.ndarray, tolerance: float = 1e-4) -> float:
    """Share of the area of triangles that leave the unit square by more than a tolerance, 0…1: (t, 3, 2) UVs."""
    a, b = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    with np.errstate(invalid="ignore", over="ignore"):
        area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).astype(np.float64)
    # Written so that what is not a number is out too.
    out = ~((uvs >= -tolerance) & (uvs <= 1 + tolerance)).all((1, 2))
    whole = area.sum()
    return float(area[out].sum() / whole) if whole > 0 else float(out.any())


def _pixels(uvs: np.ndarray, resolution: tuple[int, int]) -> tuple[np.ndarray, np.ndarray]:
    """UVs in texels, (t, 3, 2) float64, and which triangles are at finite places, (t,) bool."""
    finite = np.isfinite(uvs).all((1, 2))
    return np.where(finite[:, None, None], uvs, 0).astype(np.float64) * resolution, finite


def _candidates(
    pixels: np.ndarray, finite: np.ndarray, resolution: tuple[int, int], bottom: int, top: int
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """Triangles with the texels of their bounding boxes, in batches: (n,) triangles and (n, 2) columns and rows.

    bottom, top: rows of texels to look at.
    """
    w, h = resolution
    low = np.floor(np.clip(pixels.min(1), 0, (w, h))).astype(np.int64)
    high = np.ceil(np.clip(pixels.max(1), 0, (w, h))).astype(np.int64)
    # A triangle on a texel's border or without extent still touches one.
    high = np.minimum(np.maximum(high, low + 1), (w, h))
    low[:, 1], high[:, 1] = np.maximum(low[:, 1], bottom), np.minimum(high[:, 1], top)
    size = np.maximum(high - low, 0) * finite[:, None]
    ends = np.cumsum(size[:, 0] * size[:, 1])
    for begin in range(0, int(ends[-1]) if len(ends) else 0, _BATCH):
        pair = np.arange(begin, min(begin + _BATCH, int(ends[-1])))
        t = np.searchsorted(ends, pair, "right")
        k = pair - (ends[t] - size[t, 0] * size[t, 1])
        yield t, low[t] + np.stack([k % size[t, 0], k // size[t, 0]], -1)


@dataclass(frozen=True)
class _Edges:
    """What a triangle's barycentric weights are over the plane: w_k = x_k · x + y_k · y + one_k.

    x, y, one: three (t,) float64 each. reach: three (t,), by how much a weight changes at most from the centre of a
        unit square to its border.
    """

    x: list[np.ndarray]
    y: list[np.ndarray]
    one: list[np.ndarray]
    reach: list[np.ndarray]

    @staticmethod
    def of(corners: np.ndarray) -> "_Edges":
        """Of triangles (t, 3, 2) float64. Without an area they have no weights and may be met wherever they reach."""
        a, b, c = (corners[:, k] for k in range(3))
        area = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
        with np.errstate(divide="ignore", over="ignore"):
            inverse = np.where(area != 0, 1 / area, 0)
        x, y, one, reach = [], [], [], []
        for start, end in ((b, c), (c, a), (a, b)):
            edge = end - start
            x.append(-edge[:, 1] * inverse)
            y.append(edge[:, 0] * inverse)
            one.append(np.where(area != 0, -(x[-1] * start[:, 0] + y[-1] * start[:, 1]), -1))
            reach.append(np.where(area != 0, 0.5 * (np.abs(x[-1]) + np.abs(y[-1])), 1))
        return _Edges(x, y, one, reach)

    def met(self, t: np.ndarray, center: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """How triangles (n,) lie to unit squares within their bounding boxes, whose centres are given (n, 2).

        Returns the barycentric weights of the centres (n, 3), whether these lie inside (n,), and whether the squares
        are touched at all (n,): separating axes, of which the squares' own come with the bounding boxes.
        """
        weights = [self.x[k][t] * center[:, 0] + self.y[k][t] * center[:, 1] + self.one[k][t] for k in range(3)]
        # A centre on an edge that two triangles share must not fall between them by rounding.
        inside = np.logical_and.reduce([w >= -_ROUNDING for w in weights])
        touching = np.logical_and.reduce([w + self.reach[k][t] >= 0 for k, w in enumerate(weights)])
        return np.maximum(np.stack(weights, -1), 0), inside, touching


def _closest_weights(corners: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric weights of the points on triangles' edges that are closest to the given ones, and squared distances.

    corners: (n, 3, 2), point: (n, 2) float64 -> (n, 3), (n,).
    """
    best, distance = np.zeros((len(point), 3)), np.full(len(point), np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        edge, from_start = corners[:, j] - corners[:, i], point - corners[:, i]
        length2 = np.maximum(np.sum(edge * edge, -1), 1e-300)
        t = np.clip(np.sum(edge * from_start, -1) / length2, 0, 1)
        d2 = np.sum((from_start - t[:, None] * edge) ** 2, -1)
        closer = np.flatnonzero(d2 < distance)
        distance[closer] = d2[closer]
        best[closer] = 0
        best[closer, i], best[closer, j] = 1 - t[closer], t[closer]
    return best, distance
