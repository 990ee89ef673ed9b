# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Seams: where a smooth surface is cut apart on the UV map, the light on the two sides is made to agree.

Along each seam pairs of points are taken, one on either side, and texels are changed as little as it takes for the two
bilinear look-ups of each pair to give the same: least squares, min |A x|² + Σ λᵢ (x − x₀)ᵢ² with a row of A for each
pair, solved by conjugate gradients (as in Iwanicki, "Lighting technology of The Last of Us", SIGGRAPH 2013).
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from .atlas import Page, Place
from .geometry import Geometry
from .scene import Mesh
from .tiles import parts

# How much a texel's own value counts beside a pair's agreement: little, but enough that texels which pairs leave free
# stay where they were; and more where light was found at its middle. The others lie beyond the seam, hold the light of
# its near side, and are there to be set so that look-ups agree.
_OWN, _KNOWN = 0.001, 0.01

# Pairs of points for each texel of a seam's length.
_DENSITY = 2.0

# Cosine between normals up to which the surface counts as smooth: 8 degrees. Light has an edge where the surface has.
_SMOOTH = 0.99

# Share of its light that a texel keeps at least: where pairs pull it below nothing it would be black on a lit face.
_KEPT = 1 / 8

# Steps of conjugate gradients, how far the sides may disagree where they end, see `disagreement`, and how often they
# are taken up again after light that fell below what is kept was brought back.
_STEPS, _ENOUGH, _ROUNDS = 200, 5e-3, 3


@dataclass(frozen=True)
class Seams:
    """Pairs of points that are one place on the surface: first, second (n, 2) float32 [texels of the image]."""

    first: np.ndarray
    second: np.ndarray

    def __len__(self) -> int:
        return len(self.first)

    @staticmethod
    def concatenate(parts: "Sequence[Seams]") -> "Seams":
        none = np.zeros((0, 2), np.float32)
        return Seams(*(np.concatenate([none, *(getattr(p, k) for p in parts)]) for k in ("first", "second")))


def seams(mesh: Mesh, uvs: np.ndarray, place: Place) -> Seams:
    """The seams of a mesh at a place of an image. uvs: (t, 3, 2).

    Vertices at one place count as one, so that meshes that are split along their seams are found too.
    """
    none = np.zeros((0, 2), np.float32)
    if not len(mesh.triangles):
        return Seams(none, none)
    corner = _merged(mesh.vertices)[mesh.triangles]
    a, b = _edges_of_two(corner)
    cuts = [_cut(mesh, uvs, place, corner, a[part], b[part]) for part in parts(len(a))]
    a, b = (np.concatenate(sides) for sides in zip((np.zeros((0, 2, 2)),) * 2, *cuts))
    length = np.maximum(*(np.linalg.norm(e[:, 1] - e[:, 0], axis=1) for e in (a, b)))
    pairs = np.maximum(1, np.ceil(length * _DENSITY)).astype(np.int64)
    edge = np.repeat(np.arange(len(a)), pairs)
    step = np.arange(len(edge)) - np.repeat(np.cumsum(pairs) - pairs, pairs)
    t = ((step + 0.5) / pairs[edge])[:, None]
    first, second = ((1 - t) * e[edge, 0] + t * e[edge, 1] for e in (a, b))
    return Seams(first.astype(np.float32), second.astype(np.float32))


def _edges_of_two(corner: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The edges at which two triangles meet, as each of them counts its own, 3 · triangle + corner where it begins:
    corners' vertices (t, 3) -> (n,) int64 twice. Where more than two meet nothing says which of them go together."""
    following = np.roll(corner, -1, 1)
    key = np.minimum(corner, following).astype(np.int64) * (int(corner.max()) + 1) + np.maximum(corner, following)
    del following
    order = np.argsort(key.ravel(), kind="stable")
    key = key.ravel()[order]
    start = np.flatnonzero(np.concatenate([[True], key[1:] != key[:-1]]))
    start = start[np.diff(start, append=len(key)) == 2]
    return order[start], order[start + 1]


def _cut(
    mesh: Mesh, uvs: np.ndarray, place: Place, corner: np.ndarray, a: np.ndarray, b: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Of edges that pairs of triangles share, as `_edges_of_two` has them, those where a smooth surface is cut apart:
    their two ends on either side, the lower vertex first, (n, 2, 2) float64 [texels] twice."""

    def ends(values: np.ndarray, edge: np.ndarray) -> np.ndarray:
        triangle, k = np.divmod(edge, 3)
        both = np.stack([k, (k + 1) % 3], 1)
        turned = corner[triangle, both[:, 0]] > corner[triangle, both[:, 1]]
        both[turned] = both[turned, ::-1]
        return values[triangle[:, None], both]

    first, second = (place.side * ends(uvs, edge).astype(np.float64) + (place.x, place.y) for edge in (a, b))
    apart = np.abs(first - second).max((1, 2)) > 1e-3
    a, b = a[apart], b[apart]
    smooth = np.einsum("nkc,nkc->nk", ends(mesh.normals, a), ends(mesh.normals, b)).min(1, initial=1) > _SMOOTH
    return first[apart][smooth], second[apart][smooth]


def _merged(vertices: np.ndarray) -> np.ndarray:
    """A number for each vertex, the same for those at one place, within 1e-6 of the mesh: (v, 3) -> (v,) int32."""
    low, extent = vertices.min(0), np.ptp(vertices, axis=0).max() or 1.0
    grid = np.round((vertices - low) / (extent * 1e-6)).astype(np.int64)
    _, number = np.unique(grid @ (1 << np.array([0, 20, 40])), return_inverse=True)
    return number.astype(np.int32)


def atlas_seams(geometry: Geometry, page: Page) -> Seams:
    """The seams of all objects on an image."""
    meshes = [geometry.mesh_of(place.name)[0] for place in page.places]
    return Seams.concatenate([seams(mesh, mesh.uvs[place.uv], place) for mesh, place in zip(meshes, page.places)])


def disagreement(image: np.ndarray, found: Seams) -> float:
    """Mean difference between the two sides over their mean: (h, w, c) -> 0…2; 0 without seams or light."""
    if not len(found):
        return 0.0
    sides = [_sampled(image, points) for points in (found.first, found.second)]
    whole = np.abs(sides[0] + sides[1]).sum(dtype=np.float64) / 2
    return float(np.abs(sides[0] - sides[1]).sum(dtype=np.float64) / whole) if whole > 0 else 0.0


def stitched(image: np.ndarray, found: Seams, filled: np.ndarray, known: np.ndarray) -> np.ndarray:
    """An image whose sides agree along its seams: (h, w, c) float32 to the same.

    filled: (h, w) bool, the texels that hold a value; pairs that would look at others are left out. known: (h, w) bool,
    those whose value is that of their middle; the others give way first.
    """
    sides = [_bilinear(filled.shape, points) for points in (found.first, found.second)]
    index, weight = (np.concatenate(part) for part in zip(*sides))
    weight[4:] *= -1
    whole = filled.ravel()[index].all(0)
    index, weight = index[:, whole], weight[:, whole]
    lit = image.any((0, 1))
    if not index.size or not lit.any():
        return image
    place, index = np.unique(index, return_inverse=True)
    index = index.reshape(8, -1)
    flat = image.reshape(-1, image.shape[-1])
    values = flat[place][:, lit].T.astype(np.float64)
    # What has a sign may keep it, light stays light.
    least = flat[:, lit].min(0)[:, None]
    least = np.where(least < 0, least, _KEPT * values)
    own = np.where(known.ravel()[place], _KNOWN, _OWN)
    for _ in range(_ROUNDS):
        agreeing = _agreeing(values, index, weight, own)
        values = np.maximum(agreeing, least)
        if np.array_equal(values, agreeing):
            break
    out = flat.copy()
    out[np.ix_(place, lit)] = values.T
    return out.reshape(image.shape)


def _agreeing(start: np.ndarray, index: np.ndarray, weight: np.ndarray, own: np.ndarray) -> np.ndarray:
    """Texels at which the sides of all pairs agree: (c, m) float64 to the same.

    index, weight: (8, n), of each pair's texels, negative for the second side's. own: (m,), how much their own values
    count.
    """
    m = start.shape[1]

    def gap(x: np.ndarray) -> np.ndarray:
        """A x, by how much the sides of each pair differ: (c, m) -> (c, n)."""
        return np.stack([(weight * channel.take(index)).sum(0) for channel in x])

    def onto(gap: np.ndarray) -> np.ndarray:
        """Aᵀ of it: (c, n) -> (c, m)."""
        return np.stack([np.bincount(index.ravel(), (weight * channel).ravel(), m) for channel in gap])

    # Preconditioned by the diagonal, so that texels which many pairs look at and those which hardly any does go alike,
    # and by what may give way: steps end long before it would show.
    scale = 1 / own / (np.bincount(index.ravel(), (weight * weight).ravel(), m) + _OWN)
    change, apart = np.zeros_like(start), gap(start)
    enough = _ENOUGH / 2 * sum(np.abs((np.abs(weight) * channel.take(index)).sum(0)).sum() for channel in start)
    rest = -onto(apart)
    direction = scale * rest
    square = (rest * direction).sum(1)
    for _ in range(_STEPS):
        if np.abs(apart).sum() <= enough:
            break
        along_gap = gap(direction)
        product = onto(along_gap) + own * direction
        along = (direction * product).sum(1)
        step = np.divide(square, along, out=np.zeros_like(square), where=along > 0)[:, None]
        change += step * direction
        apart += step * along_gap
        rest -= step * product
        before, square = square, (rest * scale * rest).sum(1)
        share = np.divide(square, before, out=np.zeros_like(square), where=before > 0)[:, None]
        direction = scale * rest + share * direction
    return start + change


def _bilinear(shape: tuple[int, int], points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The texels that a look-up at points (n, 2) [texels] takes, (4, n) row · width + column, and their weights."""
    height, width = shape
    place = points.T.astype(np.float64) - 0.5
    low = np.floor(place).astype(np.int64)
    share = place - low
    index, weight = [], []
    for dy in (0, 1):
        for dx in (0, 1):
            column, row = np.clip(low[0] + dx, 0, width - 1), np.clip(low[1] + dy, 0, height - 1)
            index.append(row * width + column)
            weight.append((share[0] if dx else 1 - share[0]) * (share[1] if dy else 1 - share[1]))
    return np.stack(index), np.stack(weight)


def _sampled(image: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Bilinear look-ups at points (n, 2) [texels]: (h, w, c) -> (c, n)."""
    index, weight = _bilinear(image.shape[:2], points)
    return np.stack([(weight * channel.take(index)).sum(0) for channel in np.moveaxis(image, -1, 0)])
