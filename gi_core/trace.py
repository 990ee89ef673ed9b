# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against a scene's triangles, through Intel Embree (embreex), or on a graphics card.

A call works on the thread it is made from and lets go of the interpreter while Embree runs, so callers that cut
their work into tiles (`tiles.run`) use every core. A card takes all rays, on the main thread, which tiles ask;
what both find is the same.
"""

import threading
from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from .device import NUMPY, Device
from .emitters import emitters
from .environment import parted
from .geometry import Geometry
from .gpu_raster import Raster, raster_of
from .gpu_rays import GpuRays, gpu_rays
from .kernels.rays import near_of, past
from .raster import Grid
from .sampling import hash01
from .tiles import slices
from .vectors import length, pick

FAR = np.float32(1e30)

# A ray is at an edge where the opposite corner has less weight.
_EDGE = np.float32(1e-5)

# Hits worked out at once.
_PART = 1 << 13

# From a ray's direction to one beside it: some tens of what rounding does, askew to what surfaces are built along.
_BESIDE = np.float32([2.3e-6, -1.1e-6, 1.7e-6])

# Surfaces with an alpha that a ray goes through at the most, should it ever meet the same one again and again.
_LAYERS = 256


@dataclass(frozen=True)
class Hits:
    """Where rays met the scene.

    triangle: (n,) int32 into the geometry's triangles, −1 for a miss.
    weights: (n, 3) float32 barycentric weights of the triangle's corners.
    distance: (n,) float32 along the ray [m].
    """

    triangle: np.ndarray
    weights: np.ndarray
    distance: np.ndarray

    def __getitem__(self, which) -> "Hits":
        """Those of the rays that a slice, mask or index array picks."""
        return Hits(*(pick(a, which) for a in (self.triangle, self.weights, self.distance)))


class _Triangles:
    """Some of a geometry's triangles in an Embree scene; index: which, None for all."""

    def __init__(self, geometry: Geometry, index: np.ndarray | None):
        triangles = geometry.triangles if index is None else geometry.triangles[index]
        self._index = index
        self._scene = EmbreeScene(robust=True)
        self.empty = not len(triangles)
        if not self.empty:
            TriangleMesh(self._scene, geometry.vertices, triangles)
            # The first ray builds the acceleration structure; not to be left to several threads at once.
            self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), query="OCCLUDED")

    def closest(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> Hits:
        n = len(origins)
        if self.empty or not n:
            return Hits(np.full(n, -1, np.int32), np.zeros((n, 3), np.float32), np.asarray(far, np.float32))
        # Embree writes into the distances that it is given.
        r = self._scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32),
            dists=np.array(far, np.float32), query="INTERSECT", output=True,
        )  # fmt: skip
        triangle = r["primID"]
        if self._index is not None:
            triangle = np.where(triangle >= 0, self._index[triangle], -1).astype(np.int32)
        return Hits(triangle, np.stack([1 - r["u"] - r["v"], r["u"], r["v"]], -1), r["tfar"])

    def occluded(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> np.ndarray:
        if self.empty or not len(origins):
            return np.zeros(len(origins), bool)
        blocked = self._scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32),
            dists=np.ascontiguousarray(far, np.float32), query="OCCLUDED",
        )  # fmt: skip
        return blocked >= 0


class Tracer:
    """Closest hits and occlusion.

    Surfaces with an alpha are kept apart, so that a scene without any pays nothing for them. A ray goes through them
    until what is left of it falls to a number that is drawn once for each ray, out of its own bits: it ends at each of
    them as often as that one takes its light, the same ray always at the same, and no sample has to be split.

    geometry: what rays meet. device: what kernels run on beside them. sky, suns: what those see that meet nothing, see
        `environment.parted`. glow: points that stand for the emitting surfaces, see `emitters`. on_card: the triangles
        on the device, None where rays are Embree's. To be made on the main thread.
    """

    def __init__(self, geometry: Geometry, device: Device = NUMPY):
        self.geometry, self.device = geometry, device
        self.sky, self.suns = parted(geometry.scene.environment)
        self.glow = emitters(geometry)
        self.on_card: GpuRays | None = gpu_rays(geometry, device)
        clear, casts = geometry.clear, geometry.casts
        solid = casts & ~clear
        self._solid_index, self._veiled = np.flatnonzero(solid), (clear & casts).any()
        if self.on_card is None:
            self._solid = _Triangles(geometry, None if solid.all() else self._solid_index)
            self._clear = _Triangles(geometry, np.flatnonzero(clear & casts))

    @cached_property
    def raster(self) -> Raster | None:
        """Draws pictures on the device, None where rays find what they show. To be asked for on the main thread."""
        # Rays on a card go through surfaces with an alpha themselves.
        return None if self.on_card and self._veiled else raster_of(self.geometry, self._solid_index, self.device)

    def drawn(self, grid: Grid, origins: np.ndarray, directions: np.ndarray) -> Iterator[float]:
        """What the rays of a picture's pixels, (w · h, 3) each, row by row, meet first of the surfaces without an
        alpha. A generator of progress; returns Hits, for `closest`, or None where that is to find them itself."""
        hits = None
        if _is_main() and self.raster is not None:
            hits = yield from self.raster.drawn(grid, origins, directions)
        return hits and Hits(*hits)

    def closest(
        self, origins: np.ndarray, directions: np.ndarray, far: float = FAR, solid: Hits | None = None
    ) -> Hits:
        """The nearest hit of each ray, no further than far [m]: (n, 3), (n, 3) unit directions -> Hits.

        What was found is said in one arithmetic, since Embree and cards round in their own ways: lights of the next
        bounce, or whether an alpha ends a ray, are drawn from where rays end, and would be other draws.

        solid: those of the surfaces without an alpha, up to far, where they are known.
        """
        far, until = np.full(len(origins), far, np.float32), self._until(origins, directions)
        hits, _ = self._placed(origins, directions, self._found(origins, directions, far, until, solid))
        # Of the triangles at an edge it is the one that a ray beside meets.
        low = np.minimum(np.minimum(hits.weights[:, 0], hits.weights[:, 1]), hits.weights[:, 2])
        edge = np.flatnonzero((low < _EDGE) & (hits.triangle >= 0))
        if len(edge):
            at, along = pick(origins, edge), pick(directions, edge)
            beside = self._found(at, along + _BESIDE, far[edge], until[edge])
            beside, meets = self._placed(at, along, beside)
            row = edge[meets]
            hits.triangle[row], hits.weights[row] = beside.triangle[meets], beside.weights[meets]
            hits.distance[row] = beside.distance[meets]
        return hits

    def _found(self, origins, directions, far, until, solid: Hits | None = None) -> Hits:
        """The nearest hits, as who finds them has them. until: what may be left of rays where they end, (n,)."""
        if solid is None and self.on_card:
            return Hits(*self.on_card.closest(origins, directions, far, until))
        hits = self._solid.closest(origins, directions, far) if solid is None else solid
        if not self._veiled:
            return hits
        _, nearer = self._through(origins, directions, hits.distance, until)
        first = nearer.triangle >= 0
        return Hits(*(np.where(first if a.ndim == 1 else first[:, None], a, b)
                      for a, b in ((nearer.triangle, hits.triangle), (nearer.weights, hits.weights),
                                   (nearer.distance, hits.distance))))  # fmt: skip

    def _placed(self, origins: np.ndarray, directions: np.ndarray, hits: Hits) -> tuple[Hits, np.ndarray]:
        """Hits with where rays meet their triangles worked out anew, and which rays do meet them, but for rounding."""
        row = np.flatnonzero(hits.triangle >= 0)
        distance, u, v = _met(self.geometry, *(pick(a, row) for a in (hits.triangle, origins, directions)))
        sure = np.isfinite(distance) & np.isfinite(u) & np.isfinite(v)
        row, u, v = row[sure], u[sure], v[sure]
        meets = np.zeros(len(origins), bool)
        meets[row] = np.minimum(np.minimum(u, v), 1 - u - v) > -_EDGE
        u = np.clip(u, 0, 1)
        v = np.clip(v, 0, 1 - u)
        triangle, weights, far = np.array(hits.triangle), np.array(hits.weights), np.array(hits.distance)
        weights[row], far[row] = np.stack([1 - u - v, u, v], -1), distance[sure]
        return Hits(triangle, weights, far), meets

    def occluded(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> np.ndarray:
        """Whether anything stops the ray between the origin and the far distance: (n, 3), (n, 3), (n,) -> (n,) bool."""
        if self.on_card:
            return self.on_card.transmittance(origins, directions, far) <= self._until(origins, directions)
        blocked = self._solid.occluded(origins, directions, far)
        if not self._clear.empty:
            free = np.flatnonzero(~blocked)
            origins, directions = origins[free], directions[free]
            _, hits = self._through(origins, directions, far[free], _ended(origins, directions))
            blocked[free] = hits.triangle >= 0
        return blocked

    def transmittance(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> np.ndarray:
        """The share of light that comes through between the origin and the far distance: the mean of `occluded`
        without its noise. (n, 3), (n, 3), (n,) -> (n,) float32."""
        if self.on_card:
            return self.on_card.transmittance(origins, directions, far)
        share = (~self._solid.occluded(origins, directions, far)).astype(np.float32)
        if not self._clear.empty:
            free = np.flatnonzero(share)
            share[free], _ = self._through(origins[free], directions[free], far[free], np.zeros(len(free), np.float32))
        return share

    def _until(self, origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """What may be left of rays where they end: (n,) float32."""
        return _ended(origins, directions) if self._veiled else np.zeros(len(origins), np.float32)

    def _through(self, origins, directions, far, until) -> tuple[np.ndarray, Hits]:
        """Follows rays through surfaces with an alpha until no more than `until` (n,) of them is left.

        Returns what is left at the end (n,) and the Hits where that was reached.
        """
        n, geometry = len(origins), self.geometry
        left, beyond = np.ones(n, np.float32), np.full(n, -1, np.float32)
        triangle, weights, distance = np.full(n, -1, np.int32), np.zeros((n, 3), np.float32), np.array(far, np.float32)
        nearby = near_of(origins)
        gone, alive = np.zeros(n, np.float32), np.arange(n)
        for _ in range(_LAYERS):
            start = origins[alive] + gone[alive, None] * directions[alive]
            hits = self._clear.closest(start, directions[alive], far[alive] - gone[alive])
            met = hits.triangle >= 0
            row, hits = alive[met], hits[met]
            hits, _ = self._placed(origins[row], directions[row], replace(hits, distance=gone[row] + hits.distance))
            # What is as far is the same surface: an edge belongs to two triangles.
            new = hits.distance > beyond[row]
            old, row, hits = row[~new], row[new], hits[new]
            left[row] *= 1 - geometry.alpha(hits.triangle, hits.weights)
            ends = left[row] <= until[row]
            triangle[row[ends]], weights[row[ends]], distance[row[ends]] = (
                hits.triangle[ends], hits.weights[ends], hits.distance[ends]
            )  # fmt: skip
            beyond[row] = gone[row] = past(hits.distance, nearby[row])
            gone[old] = np.maximum(gone[old], beyond[old]) + nearby[old]
            alive = np.concatenate([row[~ends], old])
            if not len(alive):
                break
        return left, Hits(triangle, weights, distance)

    def connected(self, origins: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Whether two points see each other: (n, 3), (n, 3) -> (n,) bool. Both must already be offset off their
        surfaces."""
        return ~self.occluded(origins, *_towards(origins, targets))

    def between(self, origins: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """The share of light that comes from one point to another: the mean of `connected` without its noise. (n,)
        float32."""
        return self.transmittance(origins, *_towards(origins, targets))


def _met(geometry: Geometry, triangle, origins, directions) -> np.ndarray:
    """Where rays meet the planes of triangles: distance and weights of the second and third corner, (3, n) float32; not
    finite where a plane is seen edge-on (Möller & Trumbore 1997)."""
    found = np.empty((3, len(triangle)), np.float32)
    # In planes and in parts that stay within a core's cache: a third of the time.
    for part in slices(len(triangle), _PART):
        at, d = np.ascontiguousarray(origins[part].T), np.ascontiguousarray(directions[part].T)
        a, b, c = (pick(geometry.vertices, corner).T - at for corner in pick(geometry.triangles, triangle[part]).T)
        b, c = b - a, c - a
        p, q = _cross(d, c), _cross(b, a)
        with np.errstate(divide="ignore", invalid="ignore"):
            scale = 1 / _dot(b, p)
            found[:, part] = _dot(c, q) * scale, -_dot(a, p) * scale, _dot(d, q) * scale
    return found


def _cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def _towards(origins: np.ndarray, targets: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions (n, 3) and how far rays go (n,)."""
    d = targets - origins
    distance = length(d)
    # A hair short of the target: rounding must not let the far end's own surface block it.
    return d / np.maximum(distance, 1e-20)[:, None], distance * np.float32(1 - 1e-4)


def _is_main() -> bool:
    return threading.current_thread() is threading.main_thread()


def _ended(origins: np.ndarray, directions: np.ndarray) -> np.ndarray:
    """A number in [0, 1) for each ray, of its own bits: the same whatever else is traced with it. (n,) float32."""
    bits = np.concatenate([origins, directions], -1).astype(np.float32).view(np.uint32)
    factors = np.array([0x9E3779B1, 0x85EBCA77, 0xC2B2AE3D, 0x27D4EB2F, 0x165667B1, 0xD3A2646D], np.uint32)
    return hash01((bits * factors).sum(-1, dtype=np.uint32))
