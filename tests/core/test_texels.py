# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core import texels


def clip_area(triangle, x, y):
    """Area of a triangle within the unit square at (x, y): Sutherland–Hodgman, one half-plane after the other."""
    polygon = [np.array(p) for p in triangle]
    for axis, bound, sign in ((0, x, 1), (0, x + 1, -1), (1, y, 1), (1, y + 1, -1)):
        clipped = []
        for a, b in zip(polygon, polygon[1:] + polygon[:1]):
            da, db = sign * (a[axis] - bound), sign * (b[axis] - bound)
            if da >= 0:
                clipped.append(a)
            if da * db < 0:
                clipped.append(a + (b - a) * da / (da - db))
        polygon = clipped
        if not polygon:
            return 0.0
    p = np.array(polygon)
    q = np.roll(p, -1, 0)
    return abs((p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0]).sum()) / 2


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("mirrored", [False, True])
def test_every_texel_that_a_triangle_covers_is_there(seed, mirrored):
    triangle = np.random.default_rng(seed).uniform(0.5, 11.5, (3, 2))
    triangle = triangle[::-1] if mirrored else triangle
    found = texels.covered_texels(triangle[None] / (12, 16), (12, 16))
    covered = np.array([[clip_area(triangle, x, y) for x in range(12)] for y in range(16)])
    listed = np.zeros(12 * 16, bool)
    listed[found.place] = True
    listed = listed.reshape(16, 12)
    assert listed[covered > 1e-6].all()
    # What is listed beyond that at most touches the triangle's border.
    assert not listed[covered == 0].any()


def test_points_are_texel_centres_or_clamped_into_the_face():
    uv = np.array([[[0.1, 0.1], [0.83, 0.2], [0.3, 0.9]]])
    found = texels.covered_texels(uv, (16, 16))
    assert (found.weights >= 0).all() and np.allclose(found.weights.sum(-1), 1, atol=1e-6)
    point = found.weights @ (uv[0] * 16)
    center = np.stack([found.place % 16, found.place // 16], -1) + 0.5
    distance = np.linalg.norm(point - center, axis=-1)
    assert np.allclose(distance[found.centred], 0, atol=1e-5)
    assert (distance[~found.centred] > 0).all() and (distance <= np.sqrt(0.5) + 0.25 + 1e-6).all()


def test_a_texel_belongs_to_the_triangle_with_its_centre():
    left = [[0, 0], [0.53, 0], [0.53, 1]]
    right = [[0.53, 0], [1, 0], [0.53, 1]]
    found = texels.covered_texels(np.array([left, right], float), (10, 1))
    assert found.triangle[found.place == 5] == 1


def test_odd_triangles():
    nothing = texels.covered_texels(np.zeros((0, 3, 2)), (8, 8))
    assert len(nothing.place) == 0
    outside = np.array([[[2.0, 2], [3, 2], [2, 3]]])
    assert len(texels.covered_texels(outside, (8, 8)).place) == 0
    not_a_number = np.full((1, 3, 2), np.nan)
    assert len(texels.covered_texels(not_a_number, (8, 8)).place) == 0
    tiny = np.array([[[0.51, 0.51], [0.52, 0.51], [0.51, 0.52]]])
    assert texels.covered_texels(tiny, (8, 8)).place.tolist() == [4 * 8 + 4]


def test_batches_do_not_show(monkeypatch):
    uv = np.random.default_rng(1).uniform(0, 1, (40, 3, 2))
    whole = texels.covered_texels(uv, (32, 32))
    monkeypatch.setattr(texels, "_BATCH", 97)
    parts = texels.covered_texels(uv, (32, 32))
    assert np.array_equal(whole.place, parts.place) and np.array_equal(whole.triangle, parts.triangle)
    assert np.array_equal(whole.weights, parts.weights)
