# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against a scene's triangles, through Intel Embree (embreex).

A call works on the thread it is made from and lets go of the interpreter while Embree runs, so callers that cut
their work into tiles (`tiles.run`) use every core.
"""

from dataclasses import dataclass

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene

from .environment import parted
from .geometry import Geometry
from .vectors import length

FAR = np.float32(1e30)


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


class Tracer:
    """Closest hits and occlusion.

    geometry: what rays meet. sky, suns: what those see that meet nothing, see `environment.parted`.
    """

    def __init__(self, geometry: Geometry):
        self.geometry = geometry
        self.sky, self.suns = parted(geometry.scene.environment)
        self._scene = EmbreeScene(robust=True)
        self._empty = not len(geometry.triangles)
        if not self._empty:
            TriangleMesh(self._scene, geometry.vertices, geometry.triangles)
            # The first ray builds the acceleration structure; not to be left to several threads at once.
            self._scene.run(np.zeros((1, 3), np.float32), np.ones((1, 3), np.float32), query="OCCLUDED")

    def closest(self, origins: np.ndarray, directions: np.ndarray, far: float = FAR) -> Hits:
        """The nearest hit of each ray, no further than far [m]: (n, 3), (n, 3) unit directions -> Hits."""
        n = len(origins)
        if self._empty or not n:
            return Hits(np.full(n, -1, np.int32), np.zeros((n, 3), np.float32), np.full(n, FAR))
        r = self._scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32),
            dists=np.full(n, far, np.float32), query="INTERSECT", output=True,
        )  # fmt: skip
        return Hits(r["primID"], np.stack([1 - r["u"] - r["v"], r["u"], r["v"]], -1), r["tfar"])

    def occluded(self, origins: np.ndarray, directions: np.ndarray, far: np.ndarray) -> np.ndarray:
        """Whether anything lies between the origin and the far distance: (n, 3), (n, 3), (n,) -> (n,) bool."""
        if self._empty or not len(origins):
            return np.zeros(len(origins), bool)
        blocked = self._scene.run(
            np.ascontiguousarray(origins, np.float32), np.ascontiguousarray(directions, np.float32),
            dists=np.ascontiguousarray(far, np.float32), query="OCCLUDED",
        )  # fmt: skip
        return blocked >= 0

    def connected(self, origins: np.ndarray, targets: np.ndarray) -> np.ndarray:
        """Whether two points see each other: (n, 3), (n, 3) -> (n,) bool. Both must already be offset off their
        surfaces."""
        d = targets - origins
        distance = length(d)
        # A hair short of the target: rounding must not let the far end's own surface block it.
        return ~self.occluded(origins, d / np.maximum(distance, 1e-20)[:, None], distance * np.float32(1 - 1e-4))


def offset(points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Ray origins off their surface, by a few units in the last place: (n, 3), (n, 3) float32 -> (n, 3) float32.

    Wächter & Binder, "A Fast and Robust Method for Avoiding Self-Intersection", Ray Tracing Gems 2019, ch. 6. The
    normals are geometric ones, on the side to which rays leave.
    """
    ulps = (normals * np.float32(256)).astype(np.int32)
    points = np.ascontiguousarray(points, np.float32)
    moved = (points.view(np.int32) + np.where(points < 0, -ulps, ulps)).view(np.float32)
    # Near the origin units in the last place vanish, and a fixed step takes over.
    return np.where(np.abs(points) < 1 / 32, points + normals * np.float32(1 / 65536), moved)
