# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at triangles' corners: the mean at vertices, and what fills corners without any."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import surfels
from gi_bake.gi_core.corners import Corners
from gi_bake.tests import shapes


def cube(turn: int):
    """A cube of eight vertices whose faces are cut along one diagonal or the other."""
    mesh = shapes.box(1)
    vertices, index = np.unique(mesh.vertices, axis=0, return_inverse=True)
    quads = [np.roll(face, turn) for face in np.arange(24).reshape(6, 4)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))])
    normals = np.repeat(mesh.normals.reshape(6, 6, 3)[:, :1], 6, 1).reshape(12, 3, 3)
    return replace(mesh, vertices=vertices, triangles=index.ravel()[triangles].astype(np.int32), normals=normals)


@pytest.mark.parametrize("turn", [0, 1])
def test_a_vertex_is_the_mean_of_its_faces_however_they_are_cut(turn):
    corners = Corners.of(shapes.tracer([cube(turn)]).geometry, "box")
    assert corners.count == 8 and len(np.unique(corners.point)) == 24
    values = np.repeat(np.eye(6, dtype=np.float32), 6, 0)  # each face is lit by itself
    known = np.ones(36, bool)
    mean = corners.at_vertices(values, known)
    assert np.allclose(np.sort(mean, 1), [0, 0, 0, 1 / 3, 1 / 3, 1 / 3], atol=1e-6)
    # Without the first face its vertices have the mean of the two others.
    mean = corners.at_vertices(values, values[:, 0] == 0)
    touched = np.unique(corners.vertex[:6])
    assert np.allclose(np.sort(mean[touched], 1), [0, 0, 0, 0, 0.5, 0.5], atol=1e-6)
    # With none of a vertex's corners it has the mean of what they are.
    assert np.allclose(corners.at_vertices(values, ~known), corners.at_vertices(values, known))


def test_what_is_hidden_is_filled_from_its_own_face_ring_by_ring():
    count = 6
    grid = np.array([(x, y, 0) for x in range(count) for y in range(2)], np.float32)
    quads = [(2 * k, 2 * k + 2, 2 * k + 3, 2 * k + 1) for k in range(count - 1)]
    triangles = np.array([t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))], np.int32)
    normals = np.broadcast_to(np.float32([0, 0, 1]), (len(triangles), 3, 3)).copy()
    normals[-2:] = (1, 0, 0)  # a hard edge: what lies beyond is another surface
    mesh = replace(
        shapes.plate(0, 1), vertices=grid, triangles=triangles, normals=normals, uvs={}, slots=np.zeros(10, np.int32)
    )
    corners = Corners.of(shapes.tracer([mesh]).geometry, "plate")
    place = grid[corners.vertex][:, 0]
    values, known = np.zeros((30, 3), np.float32), place <= 1
    values[known] = 7
    filled = corners.filled(values, known)
    assert (filled[:24] == 7).all() and (filled[24:] == 0).all()
    assert np.array_equal(corners.filled(values, np.zeros(30, bool)), values)


def test_corners_lie_a_hair_inside_of_their_triangles():
    large, small = shapes.plate(0, 300), shapes.plate(1, 1e-5, name="small")
    geometry = shapes.tracer([large, small]).geometry
    for name, mesh in (("plate", large), ("small", small)):
        points = surfels.from_corners(geometry, name)
        there = mesh.vertices[mesh.triangles.ravel()]
        center = np.repeat(mesh.vertices[mesh.triangles].mean(1), 3, 0)
        # Cycles: 1e-4 of the largest coordinate or of a metre, and never beyond the centre.
        wanted = np.minimum(1e-4 * np.maximum(1, np.abs(there).max(-1)), np.linalg.norm(center - there, axis=-1))
        assert np.allclose(np.linalg.norm(points.position - there, axis=-1), wanted, rtol=0.01)
        assert points.place.tolist() == list(range(6))
