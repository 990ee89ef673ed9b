# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes for tests, made of quads."""

import numpy as np
from gi_bake.gi_core import scene as s
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.trace import Tracer


def quad(a, b, c, d, name="quad") -> s.Mesh:
    """A square whose front is where a, b, c, d run anticlockwise; its UV map covers 0…1."""
    vertices = np.array([a, b, c, d], np.float32)
    triangles = np.array([[0, 1, 2], [0, 2, 3]], np.int32)
    normal = np.cross(vertices[1] - vertices[0], vertices[2] - vertices[0])
    normals = np.broadcast_to(normal / np.linalg.norm(normal), (2, 3, 3)).astype(np.float32)
    uv = np.array([[0, 0], [1, 0], [1, 1], [0, 1]], np.float32)[triangles]
    return s.Mesh(name, vertices, triangles, normals, np.zeros(2, np.int32), {"UVMap": uv}, "UVMap", "UVMap")


def plate(z: float, half: float, up: bool = True, name="plate", center=(0.0, 0.0)) -> s.Mesh:
    """A horizontal square of side 2 half at height z."""
    x, y = center
    corners = [(x - half, y - half, z), (x + half, y - half, z), (x + half, y + half, z), (x - half, y + half, z)]
    return quad(*(corners if up else corners[::-1]), name=name)


def box(half: float, name="box") -> s.Mesh:
    """A cube around the origin whose front is its inside."""
    faces = []
    for axis in range(3):
        for sign in (-1, 1):
            corner = np.zeros((4, 3))
            corner[:, axis] = sign * half
            u, v = (axis + 1) % 3, (axis + 2) % 3
            corner[:, u] = np.array([-1, 1, 1, -1]) * half
            corner[:, v] = np.array([-1, -1, 1, 1]) * half
            faces.append(quad(*(corner if sign < 0 else corner[::-1])))
    return s.Mesh(
        name,
        np.concatenate([f.vertices for f in faces]),
        np.concatenate([f.triangles + 4 * i for i, f in enumerate(faces)]),
        np.concatenate([f.normals for f in faces]),
        np.zeros(12, np.int32),
    )


def matte(albedo=0.5, emission=0.0) -> s.Material:
    def source(value):
        return s.ColorSource(np.broadcast_to(np.asarray(value, np.float32), 3))

    return s.Material("matte", source(albedo), source(emission))


def lamp(kind: str, power=1.0, at=(0.0, 0.0, 0.0), **more) -> s.Light:
    """A lamp that shines down."""
    matrix = np.eye(4)
    matrix[:3, 3] = at
    return s.Light(kind.lower(), kind, matrix, np.full(3, power, np.float32), **more)


def scene(meshes, lights=(), material=None, **more) -> s.Scene:
    """Each mesh once, where it is, of one material."""
    instances = tuple(s.Instance(m.name, i, np.eye(4), (0,)) for i, m in enumerate(meshes))
    return s.Scene(tuple(meshes), instances, (material or matte(),), tuple(lights), **more)


def tracer(*arguments, **more) -> Tracer:
    return Tracer(Geometry(scene(*arguments, **more)))
