# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""An image in which each triangle of a mesh has texels of its own: what a function on the surface is sampled into.

Two triangles share a cell, whose sides are powers of two: cells of such sizes fill rows without gaps, whatever
the mesh. A triangle's corners lie on texel centres, so the image interpolates the samples along edges, and the few
texels behind the longest edge that bilinear filtering reaches are continued from those before it. Nothing is ever read
across from another triangle.

A cell of S × T texels holds triangles with legs of m = S − 3 and n = T − 3 texels: a triangle reaches texels with
(i − 1)/m + (j − 1)/n < 1, its neighbour sits in the opposite corner, and (S − 1)/m + (T − 1)/n = 2 + 2/m + 2/n keeps
them apart.
"""

from dataclasses import dataclass

import numpy as np

# Sides of a cell [texels]; thinner than one to eight they would round too much.
_SMALLEST, _LARGEST, _THINNEST = 4, 4096, 8

# What triangles to sample are larger on all sides than those to look up [texels], so that the centres of the texels
# on their edges are inside, however it is rounded.
_BORDER = 0.004

# Second differences of samples at which a look-up between them may be off by 3/255, and every how many lines of texels
# they are looked at.
_BENT, _EVERY = 8 * 3 / 255, 16


@dataclass(frozen=True)
class TriangleAtlas:
    """Where the triangles of a mesh lie in an image.

    width, height: of the image [texels].
    uvs: (t, 3, 2) float32, where to look a triangle's corners up. sampled: the same, a little larger, for a rasteriser
        that samples texel centres; both outside the image for triangles that are left out.
    """

    width: int
    height: int
    uvs: np.ndarray
    sampled: np.ndarray
    _cells: "_Cells"

    def complete(self, pixels: np.ndarray) -> None:
        """Continues (height, width, c) samples, in place, to the texels behind the longest edges; what no triangle
        reaches becomes their mean."""
        reached = np.zeros(pixels.shape[:2], bool)
        for where, m, n, flipped in self._cells.alike():
            # Views of the texels as the triangle counts them: [triangle, j, i].
            step = np.where(flipped, -1, 1)
            x, y = where[:, :1] + step[:, None] * np.arange(m + 1), where[:, 1:] + step[:, None] * np.arange(n + 1)
            reached[y[:, :1], x] = True
            for j in range(1, n + 1):
                last, before = m * (n - j) // n, m * (n - j + 1) // n
                beyond = np.arange(last + 1, min(before + 1, m) + 1)
                row, below = y[:, j, None], y[:, j - 1, None]
                slope = pixels[below, x[:, beyond]] - pixels[below, x[:, last, None]]
                pixels[row, x[:, beyond]] = pixels[row, x[:, last, None]] + slope
                reached[row, x[:, : beyond[-1] + 1]] = True
        if reached.any():
            pixels[~reached] = pixels[reached].mean(0, dtype=np.float64)

    def roughness(self, pixels: np.ndarray) -> float:
        """Share of (height, width, c) samples, 0…1, that what was sampled has finer detail than, by some of them: such
        as are on an edge, or on noise."""
        bent = count = 0
        for where, m, n, flipped in self._cells.alike():
            step = np.where(flipped, -1, 1)[:, None]
            for along, across, axis in ((m, n, 0), (n, m, 1)):
                place, line = np.arange(along + 1), np.arange(0, across + 1, _EVERY)
                at = (where[:, [axis]] + step * place)[:, None, :], (where[:, [1 - axis]] + step * line)[:, :, None]
                value = pixels[at[1 - axis], at[axis]]
                second = np.abs(value[:, :, 2:] - 2 * value[:, :, 1:-1] + value[:, :, :-2]).max(-1, initial=0)
                own = place[2:] * across <= along * (across - line[:, None])
                bent, count = bent + np.count_nonzero((second > _BENT) & own), count + len(where) * own.sum()
        return bent / count if count else 0.0


def triangle_atlas(corners: np.ndarray, kept: np.ndarray, texels: int) -> TriangleAtlas:
    """The `TriangleAtlas` of triangles (t, 3, 3) of which `kept` (t,) bool are laid out, with samples evenly dense.

    texels: how many the image should have at most; where that is not enough for the smallest cells, it has those.
    """
    legs, order = _legs(corners[kept])
    low, high = 0.0, max(float(legs.max(initial=0)), 1e-30)
    sides = _sides(legs, high)
    for _ in range(24):  # the finest density that fits, by bisection of the logarithm
        middle = np.sqrt(max(low, high * 1e-4) * high)
        tried = _sides(legs, middle)
        if tried.prod(1).sum() / 2 <= texels:
            high, sides = middle, tried
        else:
            low = middle
    cells = _packed(sides)
    size = np.array([cells.width, cells.height])
    m, n = (sides - 3).T.astype(np.float64)
    uvs, sampled = (np.full((len(corners), 3, 2), -1, np.float32) for _ in range(2))
    border = 1 / m + 1 / n
    for target, e in ((uvs, 0.0), (sampled, _BORDER)):
        local = np.full((len(sides), 3, 2), -e)
        local[:, 1, 0], local[:, 2, 1] = m + e + 2 * e * m * border - e, n + e + 2 * e * n * border - e
        placed = cells.corner[:, None] + 0.5 + np.where(cells.flipped, -1, 1)[:, None, None] * local
        ordered = np.empty_like(placed)
        np.put_along_axis(ordered, order[:, :, None], placed, 1)
        target[kept] = ordered / size
    return TriangleAtlas(cells.width, cells.height, uvs, sampled, cells)


def _legs(corners: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lengths of the two shorter edges, the longer of them first (t, 2), and the corners in the order of a cell's:
    where the two meet, the end of the longer, the end of the shorter (t, 3)."""
    with np.errstate(all="ignore"):
        edges = np.linalg.norm(np.roll(corners, -1, 1) - np.roll(corners, -2, 1), axis=2)  # opposite each corner
    edges = np.nan_to_num(edges.astype(np.float64), posinf=0.0)
    # Opposite the meeting point is the longest edge; opposite the end of one leg is the other leg.
    order = np.argsort(edges, axis=1, kind="stable")[:, [2, 0, 1]]
    return np.take_along_axis(edges, order[:, [2, 1]], 1), order


def _sides(legs: np.ndarray, texel: float) -> np.ndarray:
    """Sides of triangles' cells where a texel is so long: (t, 2) int64."""
    wanted = np.clip(legs / texel + 3, _SMALLEST, _LARGEST)
    wanted[:, 1] = np.maximum(wanted[:, 1], wanted[:, 0] / _THINNEST)
    return 1 << np.ceil(np.log2(wanted) - 1e-9).astype(np.int64)


@dataclass(frozen=True)
class _Cells:
    """width, height of the image; of each triangle sides (t, 2), the texel of its first corner (t, 2), and whether it
    has the opposite corner of its cell (t,)."""

    width: int
    height: int
    sides: np.ndarray
    corner: np.ndarray
    flipped: np.ndarray

    def alike(self):
        """Triangles of the same size together: their first texels, m, n and whether they are flipped."""
        kinds, kind = np.unique(self.sides, axis=0, return_inverse=True)
        for k, (s, t) in enumerate(kinds):
            here = np.flatnonzero(kind.ravel() == k)
            size = max(1, (1 << 21) // int(s * t))  # bounds the memory
            for begin in range(0, len(here), size):
                some = here[begin : begin + size]
                yield self.corner[some], int(s) - 3, int(t) - 3, self.flipped[some]


def _packed(sides: np.ndarray) -> _Cells:
    """Cells in rows: those of one height together, the widest first, so that none straddles a row's end."""
    count = len(sides)
    order = np.lexsort((-sides[:, 0], -sides[:, 1]))
    ordered = sides[order]
    # Two of the same size to a cell.
    new = np.ones(count, bool)
    new[1:] = (ordered[1:] != ordered[:-1]).any(1)
    start = np.maximum.accumulate(np.where(new, np.arange(count), 0))
    second = (np.arange(count) - start) % 2 == 1
    cell = np.cumsum(~second) - 1
    cells = ordered[~second]
    area = int(cells.prod(1).sum())
    width = max(int(cells[:, 0].max(initial=_SMALLEST)), 1 << int(np.ceil(np.log2(max(area, 1)) / 2)))
    places, y = np.zeros((len(cells), 2), np.int64), 0
    for height in np.unique(cells[:, 1])[::-1]:
        here = cells[:, 1] == height
        begin = np.cumsum(cells[here, 0]) - cells[here, 0]
        places[here, 0], places[here, 1] = begin % width, y + begin // width * height
        y += -(-int(cells[here, 0].sum()) // width) * int(height)
    corner, flipped = np.empty((count, 2), np.int64), np.empty(count, bool)
    corner[order] = places[cell] + np.where(second[:, None], cells[cell] - 1, 0)
    flipped[order] = second
    return _Cells(width, max(y, _SMALLEST), sides, corner, flipped)
