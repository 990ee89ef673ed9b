# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which texels of a lightmap belong to which triangle: conservative rasterising in UV space."""

from dataclasses import dataclass

import numpy as np

# Candidate (triangle, texel) pairs looked at in one go; bounds the memory of a large map to some 200 MB.
_BATCH = 1 << 20


@dataclass(frozen=True)
class Texels:
    """Texels that triangles touch, at most one entry per texel, ascending.

    place: (n,) int64, row · width + column.
    triangle: (n,) int64, the triangle that holds the texel's centre, or else comes closest to it.
    weights: (n, 3) float32, barycentric weights of the centre, clamped into the triangle.
    centred: (n,) bool, the centre lies in the triangle.
    """

    place: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    centred: np.ndarray


def _closest_weights(corners: np.ndarray, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Barycentric weights of the triangles' points closest to the given ones, and squared distances.

    corners: (n, 3, 2), point: (n, 2) float64 -> (n, 3), (n,). Triangles without area count by their edges.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    area = _cross(b - a, c - a)
    with np.errstate(divide="ignore", invalid="ignore"):
        inside = (
            np.stack([_cross(c - b, point - b), _cross(a - c, point - c), _cross(b - a, point - a)], -1) / area[:, None]
        )
    within = np.all(inside >= 0, -1) & (area != 0)

    best, distance = np.where(within[:, None], inside, 0.0), np.where(within, 0.0, np.inf)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        edge, from_start = corners[:, j] - corners[:, i], point - corners[:, i]
        length2 = np.maximum(np.sum(edge * edge, -1), 1e-300)
        t = np.clip(np.sum(edge * from_start, -1) / length2, 0, 1)
        d2 = np.sum((from_start - t[:, None] * edge) ** 2, -1)
        closer = d2 < distance
        distance[closer] = d2[closer]
        best[closer] = 0
        best[closer, i], best[closer, j] = 1 - t[closer], t[closer]
    return best, distance


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]


def _touches(corners: np.ndarray, low: np.ndarray) -> np.ndarray:
    """Whether triangles overlap the unit squares whose lower corners are given: (n, 3, 2), (n, 2) -> (n,) bool.

    Separating axes: the squares' come with the candidates (bounding boxes overlap), so only the triangles' edges are
    tried.
    """
    winding = np.sign(_cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]))
    touching = np.ones(len(corners), bool)
    for i, j in ((0, 1), (1, 2), (2, 0)):
        edge = (corners[:, j] - corners[:, i]) * winding[:, None]
        inward = np.stack([-edge[:, 1], edge[:, 0]], -1)
        # The square's corner that lies furthest inwards decides.
        furthest = low + (inward > 0)
        touching &= np.sum(inward * (furthest - corners[:, i]), -1) >= 0
    return touching


def covered_texels(uvs: np.ndarray, resolution: tuple[int, int]) -> Texels:
    """Every texel that a triangle touches: (t, 3, 2) UV coordinates, (width, height) -> Texels.

    What lies outside [0, 1]² is left out. Where several triangles touch a texel, the one nearest its centre has it.
    """
    w, h = resolution
    finite = np.isfinite(uvs).all((1, 2))
    pixels = np.where(finite[:, None, None], uvs, 0).astype(np.float64) * (w, h)
    low = np.floor(np.clip(pixels.min(1), 0, (w, h))).astype(np.int64)
    high = np.ceil(np.clip(pixels.max(1), 0, (w, h))).astype(np.int64)
    # A triangle on a texel's border or without extent still touches one.
    high = np.minimum(np.maximum(high, low + 1), (w, h))
    size = np.maximum(high - low, 0) * finite[:, None]
    count = size[:, 0] * size[:, 1]

    distance = np.full(w * h, np.inf)
    triangle = np.full(w * h, -1, np.int64)
    weights = np.zeros((w * h, 3), np.float32)
    ends = np.cumsum(count)
    for begin in range(0, int(ends[-1]) if len(ends) else 0, _BATCH):
        pair = np.arange(begin, min(begin + _BATCH, int(ends[-1])))
        t = np.searchsorted(ends, pair, "right")
        k = pair - (ends[t] - count[t])
        texel = low[t] + np.stack([k % size[t, 0], k // size[t, 0]], -1)
        touching = _touches(pixels[t], texel)
        t, texel = t[touching], texel[touching]
        bary, d2 = _closest_weights(pixels[t], texel + 0.5)
        place = texel[:, 1] * w + texel[:, 0]
        # Nearest first within a texel, so that each texel's first entry is its best; ties go to the lower triangle.
        order = np.lexsort((t, d2, place))
        first = order[np.unique(place[order], return_index=True)[1]]
        first = first[d2[first] < distance[place[first]]]
        distance[place[first]], triangle[place[first]], weights[place[first]] = d2[first], t[first], bary[first]

    place = np.flatnonzero(triangle >= 0)
    return Texels(place, triangle[place], weights[place], distance[place] == 0)
