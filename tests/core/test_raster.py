# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Drawn triangles: in each pixel the one that its ray meets first, wherever the camera and the triangles are."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import raster
from gi_bake.gi_core.bvh import Bvh
from gi_bake.gi_core.kernels.raster import MISS
from gi_bake.gi_core.kernels.raster import raster as drawn
from gi_bake.gi_core.kernels.rays import closest
from gi_bake.gi_core.rsm.views import texel_rays, views
from gi_bake.gi_core.scene import Camera
from gi_bake.gi_core.surfels import camera_rays
from gi_bake.tests import shapes


def soup(n, seed):
    """Triangles of all sizes about the unit cube."""
    rng = np.random.default_rng(seed)
    corners = rng.random((n, 1, 3)) + 10.0 ** rng.uniform(-2.5, 0.5, (n, 1, 1)) * rng.normal(size=(n, 3, 3))
    return corners.reshape(-1, 3).astype(np.float32), np.arange(3 * n, dtype=np.int32).reshape(-1, 3)


def camera(seed, kind="PERSPECTIVE", resolution=(19, 13), near=1e-3) -> Camera:
    """Somewhere among the triangles, turned anyhow, with a window that is not in the middle."""
    rng = np.random.default_rng(seed)
    matrix = np.eye(4)
    matrix[:3, :3] = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    matrix[:3, :3] *= np.linalg.det(matrix[:3, :3])
    matrix[:3, 3] = rng.random(3)
    return Camera(kind, matrix, (-0.9, 0.4, -0.3, 0.8), resolution, (near, 100.0))


def as_every_triangle(grid, origins, directions, vertices, triangles):
    """What is drawn is what is met by rays that look at all triangles."""
    corners = [np.ascontiguousarray(vertices[triangles[:, k]]) for k in range(3)]
    which, rectangle = raster.covered(grid, vertices, triangles)
    found = drawn(origins, directions, grid.size[0], corners, which, rectangle, MISS)
    bvh = Bvh(np.zeros(0), np.zeros(0), *corners, np.arange(len(triangles)))
    expected = closest(origins, directions, np.full(len(origins), MISS, np.float32), bvh)
    np.testing.assert_array_equal(found[:, 0], expected[:, 0])
    np.testing.assert_array_equal(found, expected)
    return found[:, 0] >= 0


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
@pytest.mark.parametrize("resolution, subpixels", [((19, 13), 1), ((1, 1), 1), ((5, 8), 2)])
def test_what_a_camera_sees_is_drawn(kind, resolution, subpixels):
    hit = []
    for seed in range(12):
        eye = camera(seed, kind, resolution, near=(1e-3, 0.2)[seed % 2])
        vertices, triangles = soup(40, seed)
        rays = camera_rays(eye, subpixels)
        hit.append(as_every_triangle(raster.of_camera(eye, subpixels), *rays, vertices, triangles))
    assert 0.2 < np.mean(hit) < 1


@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_far_from_the_origin_of_the_world(kind):
    """Where rays start, by rounding, beside where they should; with edges along the rows and columns."""
    eye = replace(camera(1, kind, (90, 80)), matrix=np.eye(4))
    eye.matrix[:3, 3] = np.float64([0.1, 0.7, 0.3]) + 1e5
    x, y, z = np.random.default_rng(2).uniform(-1, 1, (3, 200)) * [[1], [1], [0.3]]
    corners = np.stack([np.stack([x + dx, y + dy, z - 1], -1) for dx, dy in ((0, 0), (0.2, 0), (0, 0.2))], 1)
    vertices = (corners + eye.matrix[:3, 3]).reshape(-1, 3).astype(np.float32)
    hit = as_every_triangle(raster.of_camera(eye), *camera_rays(eye), vertices, np.arange(600).reshape(-1, 3))
    assert 0.2 < hit.mean() < 1


def test_rows_of_a_camera():
    eye, rows = camera(3, resolution=(16, 30)), slice(7, 12)
    hit = as_every_triangle(raster.of_camera(eye, 1, rows), *camera_rays(eye, 1, rows), *soup(60, 3))
    assert hit.any()


LAMPS = {
    "hard point": ("POINT", {}),
    "soft point": ("POINT", {"radius": 0.3}),
    "disk": ("POINT", {"radius": 0.3, "soft_falloff": True}),
    "spot": ("SPOT", {"spot_angle": 1.2, "radius": 0.05}),
    "sun": ("SUN", {}),
    "wide sun": ("SUN", {"angle": 0.4}),
}


@pytest.mark.parametrize("name", LAMPS)
def test_what_a_lamp_sees_is_drawn(name):
    kind, more = LAMPS[name]
    hit = []
    for seed in range(3):
        vertices, triangles = soup(40, seed)
        lamp = shapes.lamp(kind, at=(0.5, 0.4, 0.6 + seed), **more)
        for k, view in enumerate(views(lamp, np.stack([vertices.min(0), vertices.max(0)]), 24)):
            rays = texel_rays(view, seed + k)
            hit.append(as_every_triangle(view.grid, rays.origin, rays.direction, vertices, triangles))
    assert np.mean(np.concatenate(hit)) > 0.1


def test_a_map_of_a_mirrored_lamp_with_skewed_axes():
    vertices, triangles = soup(60, 5)
    matrix = np.eye(4)
    matrix[:3, :3] = [[-1, 0.3, 0], [0, 1, 0.2], [0.1, 0, 1]]
    matrix[:3, 3] = 0.5, 0.5, 1.5
    lamp = replace(shapes.lamp("SPOT", spot_angle=1.0, radius=0.1), matrix=matrix)
    (view,) = views(lamp, np.stack([vertices.min(0), vertices.max(0)]), 24)
    rays = texel_rays(view, 1)
    assert as_every_triangle(view.grid, rays.origin, rays.direction, vertices, triangles).mean() > 0.2


def test_straight_edges_are_curved_on_a_hemisphere():
    for view in views(shapes.lamp("AREA"), np.float32([[0, 0, 0], [1, 1, 1]]), 32):
        assert view.grid is None


def test_small_triangles_take_few_pixels():
    """Rectangles are no larger than they must be: those of small triangles are about their size."""
    eye = replace(camera(0, resolution=(400, 400)), matrix=np.eye(4), window=(-1, 1, -1, 1))
    rng = np.random.default_rng(1)
    corners = np.float32([0, 0, -2]) + rng.uniform(-1, 1, (500, 1, 3)) * [1, 1, 0] + rng.normal(size=(500, 3, 3)) * 0.01
    vertices, triangles = corners.reshape(-1, 3).astype(np.float32), np.arange(1500).reshape(-1, 3)
    for centred, most in ((True, 1.0), (False, 2.0)):
        which, rectangle = raster.covered(replace(raster.of_camera(eye), centred=centred), vertices, triangles)
        on_screen = corners[which][..., :2] / -corners[which][..., 2:] * 200
        extent = np.ptp(on_screen, 1)
        inside = (np.abs(on_screen).max((1, 2)) < 199)[:, None]
        size = rectangle[:, 1::2] - rectangle[:, ::2]
        assert np.all((size <= extent + most + 0.01) | ~inside) and inside.mean() > 0.9


def test_nothing_to_draw():
    eye = camera(1)
    which, rectangle = raster.covered(raster.of_camera(eye), np.zeros((0, 3), np.float32), np.zeros((0, 3), np.int32))
    assert which.shape == (0,) and rectangle.shape == (0, 4)
    origins, directions = camera_rays(eye)
    found = drawn(origins, directions, 19, [np.zeros((0, 3), np.float32)] * 3, which, rectangle, MISS)
    assert (found[:, 0] == -1).all() and (found[:, 3] == MISS).all()
