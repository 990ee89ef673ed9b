# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A scene's triangles in the world, and what is known at a point on one of them."""

from functools import cached_property
from operator import attrgetter

import numpy as np

from .scene import BLACK, ColorSource, Mesh, Scene
from .texture import sample
from .tiles import parts
from .vectors import cross, dot, length, normalize, pick


class Geometry:
    """All instances of a scene as one list of world-space triangles.

    Only positions are copied per instance; normals, UVs and slots stay with the mesh and are fetched for the points
    asked for.

    vertices: (v, 3) float32, world space.
    triangles: (t, 3) int32 into `vertices`.
    instance: (t,) int32 into `scene.instances`.
    """

    def __init__(self, scene: Scene):
        self.scene = scene
        counts = [len(scene.meshes[i.mesh].triangles) for i in scene.instances]
        self.first = np.concatenate([[0], np.cumsum(counts)]).astype(np.int64)
        self.instance = np.repeat(np.arange(len(counts), dtype=np.int32), counts)

        vertices, triangles, base = [np.zeros((0, 3), np.float32)], [np.zeros((0, 3), np.int32)], 0
        for instance in scene.instances:
            mesh = scene.meshes[instance.mesh]
            world = mesh.vertices @ instance.matrix[:3, :3].T + instance.matrix[:3, 3]
            vertices.append(world.astype(np.float32))
            triangles.append(mesh.triangles + np.int32(base))
            base += len(mesh.vertices)
        self.vertices = np.concatenate(vertices)
        self.triangles = np.concatenate(triangles).astype(np.int32)

        mesh_counts = [len(m.triangles) for m in scene.meshes]
        self._mesh_first = np.concatenate([[0], np.cumsum(mesh_counts)]).astype(np.int64)
        self._slots = np.concatenate([np.zeros(0, np.int32)] + [m.slots for m in scene.meshes])
        self._normals = np.concatenate([np.zeros((0, 3, 3), np.float32)] + [m.normals for m in scene.meshes])
        self._mesh_index = np.array([i.mesh for i in scene.instances], np.int64)
        # Normals go by the inverse transpose; a mirrored instance keeps its normals' side.
        self._normal_matrix = np.array(
            [np.linalg.pinv(i.matrix[:3, :3]).T for i in scene.instances], np.float32
        ).reshape(-1, 3, 3)
        self._mirrored = np.array([np.linalg.det(i.matrix[:3, :3]) < 0 for i in scene.instances], bool)
        slot_counts = [len(i.materials) for i in scene.instances]
        self._slot_count = np.array(slot_counts, np.int32)
        self._slot_first = np.concatenate([[0], np.cumsum(slot_counts)]).astype(np.int64)
        self._material_table = np.array([m for i in scene.instances for m in i.materials], np.int32)

    @cached_property
    def bounds(self) -> np.ndarray:
        """Lowest and highest corner of all triangles: (2, 3) float32 [m]."""
        return np.stack([self.vertices.min(0), self.vertices.max(0)])

    @cached_property
    def areas(self) -> np.ndarray:
        """Area of each triangle: (t,) float32 [m²]."""
        out = np.empty(len(self.triangles), np.float32)
        for part in parts(len(out)):
            a, b, c = np.moveaxis(self.vertices[self.triangles[part]], 1, 0)
            out[part] = length(cross(b - a, c - a)) / 2
        return out

    @cached_property
    def area(self) -> float:
        """Area of all triangles [m²]."""
        return float(self.areas.sum(dtype=np.float64))

    def find(self, name: str) -> int:
        """An object's index in `scene.instances` by its name. Raises KeyError where there is none."""
        for k, instance in enumerate(self.scene.instances):
            if instance.name == name and not instance.is_copy:
                return k
        raise KeyError(f"object '{name}' has no geometry in this scene")

    def mesh_of(self, name: str) -> tuple[Mesh, np.ndarray]:
        """An object's mesh and the mesh's triangles in the world, (t,) int64. Raises KeyError for no such object."""
        k = self.find(name)
        return self.scene.meshes[self.scene.instances[k].mesh], np.arange(self.first[k], self.first[k + 1])

    def mesh_triangle(self, triangle: np.ndarray) -> np.ndarray:
        """World triangles to their places in all meshes' triangles, one after the other: (n,) -> (n,) int64."""
        k = self.instance[triangle]
        return triangle - self.first[k] + self._mesh_first[self._mesh_index[k]]

    def position(self, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Points from barycentric weights: (n,), (n, 3) -> (n, 3) float32 [m]."""
        a, b, c = (pick(self.vertices, corner) for corner in pick(self.triangles, triangle).T)
        return (weights[:, :1] * a + weights[:, 1:2] * b + weights[:, 2:] * c).astype(np.float32)

    def face_normal(self, triangle: np.ndarray) -> np.ndarray:
        """Unit geometric normals on the mesh's front: (n,) -> (n, 3) float32; zero for triangles without area."""
        a, b, c = (pick(self.vertices, corner) for corner in pick(self.triangles, triangle).T)
        normal = normalize(cross(b - a, c - a))
        normal[self._mirrored[self.instance[triangle]]] *= -1
        return normal

    def shading_normal(self, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """Unit interpolated corner normals: (n,), (n, 3) -> (n, 3) float32."""
        corners = pick(self._normals, self.mesh_triangle(triangle))
        return self._to_world(triangle, np.einsum("nk,nkc->nc", weights, corners))

    def mapped_normal(
        self, triangle: np.ndarray, weights: np.ndarray, smooth: np.ndarray, behind=None
    ) -> tuple[np.ndarray, np.ndarray]:
        """Unit normals that materials give, and those that light knows of under them: (n,), (n, 3) -> (n, 3) float32
        twice; the interpolated ones, `smooth` (n, 3), where they give none.

        behind: (n,) bool, where the surface is seen from its back; the normals are those on the front all the same.
        """
        sources, material = [m.normal for m in self.scene.materials], self.material(triangle)
        out = self._normals_of(sources, material, triangle, weights, smooth)
        kinds = [(False, False) if s is None else (s.raised, s.own) for s in sources]
        raised, own = np.array(kinds, bool)[material].T
        if behind is not None:
            back = np.flatnonzero(behind & raised)
            under = self._normals_of(
                [s and s.under for s in sources], material[back], triangle[back], weights[back], smooth[back]
            )
            out[back] = 2 * dot(out[back], under)[:, None] * under - out[back]
        return out, np.where(own[:, None], out, smooth)

    def _normals_of(self, sources: list[ColorSource | None], material, triangle, weights, smooth) -> np.ndarray:
        """Unit normals in the world by materials' sources of them, `smooth` where they give none: (n, 3) float32."""
        here = np.flatnonzero(np.array([s is not None for s in sources], bool)[material])
        local = self._color([s or BLACK for s in sources], material[here], triangle[here], weights[here])
        mapped = self._to_world(triangle[here], local)
        out = smooth.copy()
        out[here] = np.where(np.any(mapped != 0, -1, keepdims=True), mapped, smooth[here])
        return out

    def _to_world(self, triangle: np.ndarray, local: np.ndarray) -> np.ndarray:
        """Unit normals in the world from normals in meshes' own space: (n,), (n, 3) -> (n, 3) float32."""
        matrix = pick(self._normal_matrix, self.instance[triangle])
        return normalize(np.einsum("nij,nj->ni", matrix, local).astype(np.float32))

    def material(self, triangle: np.ndarray) -> np.ndarray:
        """Index into `scene.materials`: (n,) -> (n,) int32. A slot that the object lacks counts as its last one."""
        k = self.instance[triangle]
        slot = np.clip(self._slots[self.mesh_triangle(triangle)], 0, self._slot_count[k] - 1)
        return self._material_table[self._slot_first[k] + slot]

    @property
    def clear(self) -> np.ndarray:
        """Triangles that may let light through: (t,) bool."""
        let_through = np.array(
            [m.alpha.texture is not None or m.alpha.value[0] < 1 for m in self.scene.materials], bool
        )
        if not let_through.any():
            return np.zeros(len(self.triangles), bool)
        return let_through[self.material(np.arange(len(self.triangles)))]

    @property
    def casts(self) -> np.ndarray:
        """Triangles that block and reflect light: (t,) bool."""
        return np.array([i.casts for i in self.scene.instances], bool)[self.instance]

    @cached_property
    def has_gloss(self) -> bool:
        """Whether any surface reflects more than its albedo."""
        return any(np.any(m.gloss_albedo.value) for m in self.scene.materials)

    @cached_property
    def has_normal_maps(self) -> bool:
        """Whether any surface has other normals than its mesh."""
        return any(m.normal is not None for m in self.scene.materials)

    def alpha(self, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """How solid the surface is at points, 0…1: (n,), (n, 3) -> (n,) float32."""
        return np.clip(self.color("alpha", triangle, weights)[:, 0], 0, 1)

    def uv(self, triangle: np.ndarray, weights: np.ndarray, name: str = "") -> np.ndarray:
        """Coordinates in a UV map ("": the mesh's render UV map; zero where a mesh lacks it): (n,), (n, 3) -> (n, 2)
        float32."""
        out = np.zeros((len(triangle), 2), np.float32)
        mesh_index = self._mesh_index[self.instance[triangle]]
        local = self.mesh_triangle(triangle) - self._mesh_first[mesh_index]
        for m in np.unique(mesh_index):
            mesh = self.scene.meshes[m]
            corners = mesh.uvs.get(name or mesh.render_uv)
            if corners is not None:
                here = mesh_index == m
                out[here] = np.einsum("nk,nkc->nc", pick(weights, here), pick(corners, local[here]))
        return out

    def color(self, source: str, triangle: np.ndarray, weights: np.ndarray) -> np.ndarray:
        """A material property ("albedo", "emission", "alpha", "gloss.roughness" …) at points: (n,), (n, 3) -> (n, 3)
        float32."""
        sources = [attrgetter(source)(m) for m in self.scene.materials]
        return self._color(sources, self.material(triangle), triangle, weights)

    def _color(self, sources: list[ColorSource], material, triangle, weights) -> np.ndarray:
        out = pick(np.array([s.value for s in sources], np.float32), material)
        for m in np.unique(material):
            if sources[m].texture is not None:
                here = material == m
                out[here] *= sample(sources[m].texture, self.uv(triangle[here], weights[here], sources[m].uv))
        return out
