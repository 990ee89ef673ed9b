# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at the corners of a mesh's triangles, and from there at its vertices.

A vertex has no light of its own: each of its faces looks elsewhere. So light is worked out at corners, as Cycles bakes
it; a vertex has their mean, by their angles, which does not depend on how faces are cut into triangles. Corners inside
of other geometry take what is around them, as a lightmap's texels do: a crate that stands in the floor is not black at
its foot. There Cycles' bake differs: it counts them as black.
"""

from dataclasses import dataclass

import numpy as np

from .geometry import Geometry
from .vectors import dot, normalize


@dataclass(frozen=True)
class Corners:
    """The corners of an object's t triangles, place 3 · triangle + corner.

    vertex: (3 t,) int32, its vertex. point: (3 t,) int64, from 0 on: corners with the same vertex and normal are one
        point of the surface. angle: (3 t,) float32, of the triangle there [rad], 0 where it has no area. count: of
        vertices.
    """

    vertex: np.ndarray
    point: np.ndarray
    angle: np.ndarray
    count: int

    @staticmethod
    def of(geometry: Geometry, name: str) -> "Corners":
        """Raises KeyError for no such object."""
        mesh, triangle = geometry.mesh_of(name)
        position = geometry.vertices[geometry.triangles[triangle]]
        ahead, behind = (normalize(np.roll(position, -k, 1) - position) for k in (1, 2))
        angle = np.arccos(np.clip(dot(ahead, behind), -1, 1))
        angle[~np.any(geometry.face_normal(triangle) != 0, -1)] = 0
        vertex = mesh.triangles.ravel()
        # Normals to a five-hundredth, ten bits for each coordinate.
        x, y, z = (np.clip(np.round(n * 500) + 512, 0, 1023).astype(np.int64) for n in mesh.normals.reshape(-1, 3).T)
        _, point = np.unique(vertex.astype(np.int64) << 30 | x << 20 | y << 10 | z, return_inverse=True)
        return Corners(vertex, point.ravel().astype(np.int64), angle.ravel(), len(mesh.vertices))

    def at_vertices(self, values: np.ndarray, known: np.ndarray) -> np.ndarray:
        """The mean at each vertex: (3 t, c) float32, (3 t,) bool, which corners count -> (v, c) float32.

        Where none of a vertex's corners count, all do; without any it is zero.
        """
        seen = np.bincount(self.vertex, self.angle * known, self.count)
        weight = self.angle * (known | ~(seen > 0)[self.vertex])
        total = np.maximum(np.bincount(self.vertex, weight, self.count), 1e-20)
        sums = [np.bincount(self.vertex, weight * values[:, c], self.count) for c in range(values.shape[1])]
        return (np.stack(sums, -1) / total[:, None]).astype(np.float32)

    def filled(self, values: np.ndarray, known: np.ndarray) -> np.ndarray:
        """Values that are not known taken from those around them: (3 t, c) float32, (3 t,) bool -> (3 t, c) float32.

        From other corners at the same point of the surface, or else from its triangles' other points, from ring to ring
        inwards. A part of the surface without any keeps what it has.
        """
        if known.all() or not known.any():
            return values
        points = int(self.point.max()) + 1
        mean, has = _means(self.point[known], values[known], points)
        left = self.point.reshape(-1, 3)
        while True:
            left = left[~has[left].all(1)]
            border = left[has[left].any(1)]
            if not len(border):
                break
            mask = has[border]
            ring = (mean[border] * mask[..., None]).sum(1) / mask.sum(1)[:, None]
            new, found = _means(border.ravel(), np.repeat(ring, 3, 0), points)
            found &= ~has
            mean[found], has[found] = new[found], True
        take = ~known & has[self.point]
        return np.where(take[:, None], mean[self.point], values).astype(np.float32)


def _means(where: np.ndarray, values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The mean of values (n, c) at each of so many places, and which have any: (count, c), (count,) bool."""
    n = np.bincount(where, minlength=count)
    sums = np.stack([np.bincount(where, values[:, c], count) for c in range(values.shape[1])], -1)
    return sums / np.maximum(n, 1)[:, None], n > 0
