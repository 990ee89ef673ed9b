# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
from gi_bake.gi_core.vectors import offset
from gi_bake.tests import shapes


def test_closest_hit_of_a_plane():
    tracer = shapes.tracer([shapes.plate(1.5, 1)])
    rng = np.random.default_rng(0)
    origins = np.c_[rng.uniform(-0.9, 0.9, (1000, 2)), np.full(1000, 4)].astype(np.float32)
    down = np.broadcast_to(np.float32([0, 0, -1]), (1000, 3))
    hits = tracer.closest(origins, down)
    assert np.allclose(hits.distance, 2.5, atol=1e-5) and np.allclose(hits.weights.sum(-1), 1, atol=1e-6)
    points = tracer.geometry.position(hits.triangle, hits.weights)
    assert np.allclose(points, np.c_[origins[:, :2], np.full(1000, 1.5)], atol=1e-5)
    assert (tracer.closest(origins, -down).triangle == -1).all()


def test_offset_leaves_the_surface_near_and_far_from_the_origin():
    for distance in (0.0, 1.0, 1e3, 1e5):
        half = max(1.0, distance * 0.1)
        tracer = shapes.tracer([shapes.plate(distance, half, center=(distance, -distance))])
        rng = np.random.default_rng(1)
        weights = rng.dirichlet((1, 1, 1), 5000).astype(np.float32)
        points = tracer.geometry.position(np.zeros(5000, np.int64), weights)
        up = np.broadcast_to(np.float32([0, 0, 1]), points.shape)
        grazing = rng.standard_normal((5000, 3)).astype(np.float32)
        grazing[:, 2] = np.abs(grazing[:, 2]) * 0.05 + 0.001
        grazing /= np.linalg.norm(grazing, axis=-1, keepdims=True)
        assert not tracer.occluded(offset(points, up), grazing, np.full(5000, 1e6)).any()


def test_two_points_see_each_other_unless_something_is_between():
    wall = shapes.plate(0.5, 0.25)
    tracer = shapes.tracer([shapes.plate(0, 1, name="low"), shapes.plate(1, 1, up=False, name="high"), wall])
    x = np.linspace(-0.9, 0.9, 36)
    low = offset(np.c_[x, 0 * x, 0 * x].astype(np.float32), np.tile(np.float32([0, 0, 1]), (36, 1)))
    high = offset(np.c_[x, 0 * x, 0 * x + 1].astype(np.float32), np.tile(np.float32([0, 0, -1]), (36, 1)))
    assert np.array_equal(tracer.connected(low, high), np.abs(x) > 0.25)


def test_a_scene_without_triangles_blocks_nothing():
    tracer = shapes.tracer([])
    one = np.ones((5, 3), np.float32)
    assert (tracer.closest(one, one).triangle == -1).all() and not tracer.occluded(one, one, np.ones(5)).any()


def test_rays_at_an_edge_meet_the_same_triangle_from_either_side_of_it():
    """Rays into the diagonals and the corners of a box, moved by a unit in the last place: what they meet is the same,
    and where they meet it is where the plane is."""
    tracer = shapes.tracer([shapes.box(1)])
    steps = np.linspace(-0.99, 0.99, 199, dtype=np.float32)
    one = np.ones_like(steps)
    ends = [np.stack(v, -1) for v in ((steps, steps, one), (steps, -steps, one), (one, one, steps), (steps, one, -one))]
    d = np.concatenate(ends)
    d = (d / np.linalg.norm(d, axis=-1, keepdims=True)).astype(np.float32)
    found = []
    for moved in (d, np.nextafter(d, np.float32(2)), np.nextafter(d, np.float32(-2))):
        hits = tracer.closest(np.zeros_like(d), moved)
        at = tracer.geometry.position(hits.triangle, hits.weights)
        np.testing.assert_allclose(np.abs(at).max(-1), 1, atol=1e-6)
        np.testing.assert_allclose(hits.distance, 1 / np.abs(d).max(-1), rtol=1e-5)
        found.append(hits.triangle)
    assert np.array_equal(found[0], found[1]) and np.array_equal(found[0], found[2])
