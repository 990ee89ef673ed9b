# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each pass of screen-space GI against its definition, written as plain loops over small images: borders, background,
grazing views, the first frame."""

import math

import numpy as np
import pytest
from gi_bake.gi_core import sampling
from gi_bake.gi_core.kernels.bilateral_upsample import bilateral_upsample
from gi_bake.gi_core.kernels.depth_march import depth_march
from gi_bake.gi_core.kernels.depth_pyramid import NOTHING, depth_pyramid
from gi_bake.gi_core.kernels.diffuse_filter import diffuse_filter
from gi_bake.gi_core.kernels.horizon_scan import SECTORS, horizon_scan
from gi_bake.gi_core.kernels.march_cells import march_cells
from gi_bake.gi_core.kernels.reproject import reproject
from gi_bake.gi_core.kernels.surface_weight import surface_weight
from gi_bake.gi_core.kernels.temporal import history_taps, temporal

# Camera space of the small images here: x to the right, y up, z ahead, a focal length of F pixels.
F = 12.0


def surface(h, w, seed=0, empty=0.15):
    """A bumpy wall about 4 m away, with steps in depth and holes: depth, position, normal, all in camera space."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:h, :w] - np.array([(h - 1) / 2, (w - 1) / 2])[:, None, None]
    depth = (4 + rng.normal(0, 0.03, (h, w)) + 2 * (x > w / 5)).astype(np.float32)
    normal = rng.normal((0, 0, -1), (0.5, 0.5, 0.3), (h, w, 3))
    position = np.dstack([x / F * depth, y / F * depth, depth]).astype(np.float32)
    # Seen from its front, at whatever angle.
    normal *= -np.sign(np.sum(normal * position, -1, keepdims=True))
    normal = (normal / np.linalg.norm(normal, axis=-1, keepdims=True)).astype(np.float32)
    hole = rng.random((h, w)) < empty
    depth[hole], position[hole], normal[hole] = np.inf, 0, 0
    return depth, position, normal


def matrix(h, w):
    """World (here camera space) to x · w, y · w, depth, w; centres at whole numbers."""
    return np.array([[F, 0, (w - 1) / 2, 0], [0, F, (h - 1) / 2, 0], [0, 0, 1, 0], [0, 0, 1, 0]])


def weight(z0, p0, n0, z1, p1, n1, scale, literal=False):
    """The bilateral weight, as the source has it."""
    cosine = max(0.0, float(n0 @ n1))
    closeness = math.sqrt(math.sqrt(cosine)) if literal else cosine**4
    dq = (p1 - p0).astype(float)
    d = math.sqrt(dq @ dq)
    if d < 0.01 * scale:
        plane = 1.0
    else:
        plane = max(0.0, 1 - 2 * max(abs(dq @ n0), abs(dq @ n1)) / d) ** 2
    return max(0.0, 1 - abs(float(z0) - float(z1))) * min(1, closeness) * plane


@pytest.mark.parametrize("shape", [(9, 13), (8, 16), (1, 5), (1, 1)])
def test_the_pyramid_keeps_the_nearest(shape):
    h, w = shape
    nearest = np.random.default_rng(0).random(shape).astype(np.float32)
    nearest[0, -1] = NOTHING
    levels, table = depth_pyramid(nearest, 7)
    assert len(table) == min(7, math.ceil(math.log2(max(h, w))) + 1)
    for k, (offset, width, height) in enumerate(table):
        side = 2**k
        assert (width, height) == (math.ceil(w / side), math.ceil(h / side))
        for y in range(height):
            for x in range(width):
                block = nearest[y * side : (y + 1) * side, x * side : (x + 1) * side]
                assert levels[offset + y * width + x] == block.min()


def plain_march(origin, direction, depth, slope, back, end):
    """Pixel by pixel along the ray, without a pyramid: the pixel hit, −1 for none; whether it went behind something."""
    h, w = depth.shape
    o, d = origin.astype(float), direction.astype(float)
    t = min(abs(0.5 / d[0]), abs(0.5 / d[1]))
    below = hidden = False
    while t < end:
        x, y = o[0] + (t + 1e-7) * d[0], o[1] + (t + 1e-7) * d[1]
        i, j = math.floor(x), math.floor(y)
        if not (0 <= i < w and 0 <= j < h):
            break
        leave = min(
            (i + (d[0] > 0) - o[0]) / d[0],
            (j + (d[1] > 0) - o[1]) / d[1],
        )
        leave = min(leave, end)

        def gap(t, i=i, j=j):
            plane = depth[j, i] + slope[j, i] @ (o[0] + t * d[0] - i - 0.5, o[1] + t * d[1] - j - 0.5)
            return o[2] + t * d[2] - plane, plane

        (g, plane), (after, _) = gap(t), gap(leave)
        if g > 0:
            hidden = True
            if o[2] + t * d[2] <= plane * back:
                return (-1 if below else j * w + i), hidden
            if after < 0:
                return -1, hidden
        elif after >= 0:
            return j * w + i, hidden
        below = g > 0
        t = leave
    return -1, hidden


def test_the_march_finds_what_pixel_by_pixel_finds():
    h, w = 19, 23
    rng = np.random.default_rng(3)
    depth, position, normal = surface(h, w, 3)
    device = np.where(np.isfinite(depth), -1 / depth, NOTHING).astype(np.float32)
    over = np.where(np.isfinite(depth), np.sum(normal * position, -1), 1)
    slope = np.where(np.isfinite(depth)[..., None], -normal[..., :2] / over[..., None] / F, 0)
    most = 0.3 * np.abs(np.where(np.isfinite(depth), device, 0))
    slope *= np.minimum(1, most / np.maximum(np.abs(slope).sum(-1), 1e-9))[..., None]
    slope = slope.astype(np.float32)
    nearest = np.where(np.isfinite(depth), device - np.abs(slope).sum(-1) / 2, NOTHING).astype(np.float32)
    pyramid, table = depth_pyramid(nearest, 7)

    n = 4000
    pixel = rng.integers(0, h * w, n)
    z = rng.uniform(1, 8, n)
    origin = np.stack([pixel % w + 0.5, pixel // w + 0.5, -1 / z], -1).astype(np.float32)
    direction = (rng.normal(0, 1, (n, 3)) * (1, 1, 0.02)).astype(np.float32)
    near, back = -1 / 0.5, 1 / 1.1
    cells = march_cells(device, slope, pyramid)
    hit, hidden = depth_march(origin, direction, cells, table, near, back, 4096)
    sure, _ = depth_march(origin, direction, cells, table, near, back, 4096, sure=True)
    assert np.array_equal(sure, np.where(hidden, -1, hit))
    same, hits = 0, 0
    for k in range(n):
        o, d = origin[k].astype(float), direction[k].astype(float)
        end = min((w - 0.5 - o[0]) / d[0] if d[0] > 0 else (0.5 - o[0]) / d[0],
                  (h - 0.5 - o[1]) / d[1] if d[1] > 0 else (0.5 - o[1]) / d[1],
                  -o[2] / d[2] if d[2] > 0 else (near - o[2]) / d[2])  # fmt: skip
        expected = plain_march(origin[k], direction[k], device, slope, back, end)
        same += (hit[k], hidden[k]) == expected
        hits += expected[0] >= 0
    # Rays through corners of pixels may take either.
    assert same >= 0.995 * n and 0.1 * n < hits < 0.9 * n


def test_a_march_of_too_few_steps_finds_nothing():
    depth = np.full((8, 8), -0.25, np.float32)
    pyramid, table = depth_pyramid(depth, 1)
    origin, direction = np.array([[0.5, 4.5, -0.5]], np.float32), np.array([[1, 0, 0.04]], np.float32)
    flat = np.zeros((8, 8, 2), np.float32)
    cells = march_cells(depth, flat, pyramid)
    many, few = (depth_march(origin, direction, cells, table, -10, 0.9, n)[0][0] for n in (64, 3))
    assert many == 4 * 8 + 6 and few == -1


def test_a_ray_does_not_meet_the_slanted_plane_that_it_leaves():
    """Steps at the centres' depth would catch a good part of them."""
    h = w = 32
    slope_y = 0.006
    depth = (-0.3 + slope_y * (np.arange(h)[:, None] - 16) + np.zeros(w)).astype(np.float32)
    slope = np.zeros((h, w, 2), np.float32)
    rng = np.random.default_rng(0)
    pixel = rng.integers(0, h * w, 2000)
    start = np.stack([pixel % w + 0.5, pixel // w + 0.5, depth.ravel()[pixel] * 1.001], -1).astype(np.float32)
    way = rng.normal(0, 1, (2000, 3)).astype(np.float32)
    # Away from the plane, towards the eye's side of it.
    way[:, 2] = slope_y * way[:, 1] - np.abs(way[:, 2]) * 0.002
    caught = []
    for value in (slope_y, 0):
        slope[..., 1] = value
        nearest = depth - np.abs(slope).sum(-1) / 2
        pyramid, table = depth_pyramid(nearest, 7)
        hit, _ = depth_march(start, way, march_cells(depth, slope, pyramid), table, -9, 0.9, 256)
        caught.append((hit >= 0).mean())
    assert caught[0] == 0 and caught[1] > 0.1


def test_reprojection_is_its_definition():
    h, w, n = 7, 9, 300
    rng = np.random.default_rng(0)
    color, depth = rng.random((h, w, 3)).astype(np.float32), rng.uniform(2, 3, (h, w)).astype(np.float32)
    depth[rng.random((h, w)) < 0.2] = np.inf
    before = np.stack([rng.uniform(-2, w + 1, 50), rng.uniform(-2, h + 1, 50), rng.uniform(2, 3, 50)], -1)
    before[::7] = np.nan
    before = before.astype(np.float32)
    hit = rng.integers(-1, 50, n).astype(np.int32)
    got, valid = reproject(hit, before, color, depth, 0.1)
    for k in range(n):
        expected = None
        if hit[k] >= 0 and not np.isnan(before[hit[k], 0]):
            x, y, z = before[hit[k]]
            i, j = round(float(x)), round(float(y))
            if -0.5 < x < w - 0.5 and -0.5 < y < h - 0.5 and abs(depth[j, i] - z) <= 0.1 * z:
                expected = color[j, i]
        assert valid[k] == (expected is not None)
        assert np.array_equal(got[k], np.zeros(3) if expected is None else expected)
    assert 0.1 < valid.mean() < 0.9


def test_history_is_taken_where_it_shows_the_same_surface():
    h, w, n = 6, 8, 400
    rng = np.random.default_rng(1)
    _, position, normal = surface(h, w, 1)
    before = np.stack([rng.uniform(-1.5, w + 0.5, n), rng.uniform(-1.5, h + 0.5, n)], -1).astype(np.float32)
    before[::9] = np.nan
    pick = rng.integers(0, h * w, n)
    expected = (position.reshape(-1, 3)[pick] + rng.normal(0, 0.1, (n, 3))).astype(np.float32)
    here = normal.reshape(-1, 3)[rng.integers(0, h * w, n)]
    slant = rng.uniform(0, 1, n).astype(np.float32)
    slant[0] = 0
    footprint = np.full(n, 0.3, np.float32)
    limit = np.full(n, 0.5, np.float32)
    taps, weights = history_taps(before, expected, here, footprint, slant, position, normal, limit)
    counted = 0
    for k in range(n):
        found = {}
        if not np.isnan(before[k, 0]):
            x, y = (math.floor(v) for v in before[k])
            u, v = before[k, 0] - x, before[k, 1] - y
            for j, b in ((y, 1 - v), (y + 1, v)):
                for i, a in ((x, 1 - u), (x + 1, u)):
                    if not (0 <= i < w and 0 <= j < h):
                        continue
                    near = np.linalg.norm(position[j, i] - expected[k]) <= max(0.5, 4 * 0.3 / max(slant[k], 1e-6))
                    if near and normal[j, i] @ here[k] >= 0.65:
                        found[j * w + i] = float(a * b)
        total = sum(found.values())
        found = {p: f / total for p, f in found.items()} if total > 1e-3 else {}
        got = {}
        for p, f in zip(taps[k], weights[k]):
            if f:
                got[int(p)] = got.get(int(p), 0) + float(f)
        assert set(got) == {p for p, f in found.items() if f}
        assert all(math.isclose(got[p], found[p], rel_tol=1e-4, abs_tol=1e-6) for p in got)
        counted += bool(found)
    assert 20 < counted < n - 50


@pytest.mark.parametrize("hdrp", [False, True])
def test_the_temporal_filter_is_its_definition(hdrp):
    """Forty passes over three pixels: one that always has a history, one that loses it, one that never has any."""
    rng = np.random.default_rng(0)
    frames = rng.random((40, 3, 2)).astype(np.float32)
    taps = np.tile(np.arange(3, dtype=np.int32)[:, None], (1, 4))
    history, count = np.zeros((1, 3, 2), np.float32), np.zeros((1, 3), np.float32)
    mean, n = np.zeros((3, 2)), np.zeros(3)
    for k, value in enumerate(frames):
        weights = np.zeros((3, 4), np.float32)
        weights[0, 0], weights[1, 0] = k > 0, k > 0 and k != 20
        history, count = (a.reshape(1, 3, -1) for a in temporal(value, history, count, taps, weights, hdrp))
        count = count[..., 0]
        for p in range(3):
            if not weights[p].any():
                mean[p], n[p] = value[p], 1
                continue
            factor = 0.93 if hdrp and n[p] >= 8 else n[p] / (n[p] + 1)
            n[p] = min(n[p] + 1, 8) if hdrp else n[p] + 1
            mean[p] = value[p] * (1 - factor) + mean[p] * factor
        assert np.allclose(history[0], mean, rtol=1e-5) and np.array_equal(count[0], n)
    if not hdrp:
        assert np.allclose(history[0, 0], frames[:, 0].mean(0), rtol=1e-5)
        assert np.allclose(history[0, 1], frames[20:, 1].mean(0), rtol=1e-5)
    assert np.array_equal(history[0, 2], frames[-1, 2])


def test_one_value_may_stand_for_several_frames():
    """As often mixed in as frames were skipped, and once more; where nothing came before them, it is all there is."""
    rng = np.random.default_rng(0)
    value, history = rng.random((2, 3)).astype(np.float32), rng.random((1, 2, 3)).astype(np.float32)
    taps, weights = np.tile(np.arange(2, dtype=np.int32)[:, None], (1, 4)), np.tile(np.float32([1, 0, 0, 0]), (2, 1))
    before = np.array([[5, 0]], np.float32)
    once, count = temporal(value, history, before + 3, taps, weights, skipped=3)
    again, n = history, before
    for _ in range(4):
        again, n = (a.reshape(1, 2, -1) for a in temporal(value, again, n[..., :2].reshape(1, 2), taps, weights))
    assert np.allclose(once, again[0], rtol=1e-5) and np.array_equal(count, n.ravel()) and count[0] == 9
    assert np.allclose(once[1], value[1])


def test_history_between_pixels_is_mixed():
    history = np.array([[[0.0], [1.0]], [[2.0], [4.0]]], np.float32)
    count = np.array([[1, 1], [3, 3]], np.float32)
    taps, weights = np.array([[0, 1, 2, 3]], np.int32), np.array([[0.5, 0, 0.25, 0.25]], np.float32)
    mixed, n = temporal(np.array([[7.0]], np.float32), history, count, taps, weights)
    assert n[0] == 3 and np.isclose(mixed[0, 0], 7 / 3 + 1.5 * 2 / 3)


def test_the_surface_weight_is_its_definition():
    rng = np.random.default_rng(0)
    n = 500
    normals = rng.normal((0, 0, 1), 0.5, (2, n, 3))
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    points = rng.normal(0, 1, (2, n, 3)) * np.where(rng.random(n) < 0.2, 1e-3, 0.3)[:, None]
    depth = rng.random((2, n))
    for literal in (False, True):
        got = surface_weight(depth[0], points[0], normals[0], depth[1], points[1], normals[1], 0.8, literal)
        expected = [
            weight(depth[0, k], points[0, k], normals[0, k], depth[1, k], points[1, k], normals[1, k], 0.8, literal)
            for k in range(n)
        ]
        assert np.allclose(got, expected, rtol=1e-4, atol=1e-6)
    turned = np.array([math.sin(math.radians(30)), 0, math.cos(math.radians(30))])
    up, zero = np.array([0, 0, 1.0]), np.zeros(3)
    assert np.isclose(surface_weight(0, zero, up, 0, zero, turned, 1.0), 0.5625)
    assert np.isclose(surface_weight(0, zero, up, 0, zero, turned, 1.0, literal=True), 0.9647, atol=1e-4)


@pytest.mark.parametrize("literal", [False, True])
def test_the_diffuse_filter_is_its_definition(literal):
    h, w, c, far, scale = 11, 14, 2, 50.0, 0.8
    rng = np.random.default_rng(2)
    depth, position, normal = surface(h, w, 2)
    normal[depth < 5] = (0, 0, -1)
    value = rng.random((h, w, c)).astype(np.float32)
    pixels = np.arange(h * w)
    radius = rng.uniform(0.3, 2.5, h * w).astype(np.float32)
    taps = sampling.disk(rng.random((h * w, 9, 2))).astype(np.float32)
    got = diffuse_filter(pixels, value, depth, position, normal, radius, taps, matrix(h, w), far, scale, literal)
    used = 0
    for p in range(h * w):
        j, i = divmod(p, w)
        if not np.isfinite(depth[j, i]):
            assert (got[p] == 0).all()
            continue
        t, b = sampling.frame(normal[j, i].astype(float))
        total, weights = value[j, i].astype(float), 1.0
        for u, v in taps[p]:
            point = position[j, i] + radius[p] * (u * t + v * b)
            if point[2] <= 0:
                continue
            x, y = F * point[0] / point[2] + (w - 1) / 2, F * point[1] / point[2] + (h - 1) / 2
            if not (-0.5 < x < w - 0.5 and -0.5 < y < h - 0.5):
                continue
            j2, i2 = round(y), round(x)
            if not np.isfinite(depth[j2, i2]) or abs(depth[j2, i2] - point[2]) > radius[p] / 6:
                continue
            f = math.exp(-(u * u + v * v) / 0.81) * weight(
                depth[j, i] / far, position[j, i], normal[j, i],
                depth[j2, i2] / far, position[j2, i2], normal[j2, i2], scale, literal,
            )  # fmt: skip
            total, weights = total + f * value[j2, i2], weights + f
            used += f > 0
        assert np.allclose(got[p], total / weights, rtol=2e-3, atol=1e-5)
    assert used > 100


def test_the_upsample_is_its_definition():
    h, w, n, far, scale = 6, 7, 300, 50.0, 0.8
    rng = np.random.default_rng(4)
    depth, position, normal = surface(h, w, 4)
    value = rng.random((h, w, 3)).astype(np.float32)
    at = np.stack([rng.uniform(-0.5, w - 0.5, n), rng.uniform(-0.5, h - 0.5, n)], -1).astype(np.float32)
    pick = rng.choice(np.flatnonzero(np.isfinite(depth)), n)
    z, here, up = depth.ravel()[pick], position.reshape(-1, 3)[pick], normal.reshape(-1, 3)[pick]
    got, shown = bilateral_upsample(at, z, here, up, value, depth, position, normal, far, scale)
    for p in range(n):
        x, y = min(max(float(at[p, 0]), 0), w - 1), min(max(float(at[p, 1]), 0), h - 1)
        i0, j0 = min(math.floor(x), w - 2), min(math.floor(y), h - 2)
        total, weights, best = np.zeros(3), 0.0, 0.0
        for j, b in ((j0, 1 - (y - j0)), (j0 + 1, y - j0)):
            for i, a in ((i0, 1 - (x - i0)), (i0 + 1, x - i0)):
                if np.isfinite(depth[j, i]):
                    like = weight(z[p] / far, here[p], up[p], depth[j, i] / far, position[j, i], normal[j, i], scale)
                    total += a * b * max(like, 1e-4) * value[j, i]
                    weights += a * b * max(like, 1e-4)
                    dq = (position[j, i] - here[p]).astype(float)
                    d = math.sqrt(dq @ dq)
                    plane = 1.0 if d < 0.01 * scale else max(0.0, 1 - 2 * abs(dq @ normal[j, i]) / d) ** 2
                    best = max(best, plane * (a * b > 0) * (normal[j, i] @ up[p] > 0))
        assert np.allclose(got[p], total / max(weights, 1e-20), rtol=2e-3, atol=1e-5)
        assert np.isclose(shown[p], best, rtol=1e-3, atol=1e-5)


def plain_scan(p, position, normal, color, u, thickness, steps, span):
    """One slice from one pixel, sector by sector: mean radiance, and the share of what is not seen."""
    h, w = color.shape[:2]
    row, column = divmod(p, w)
    here, n = position[row, column].astype(float), normal[row, column].astype(float)
    v = -here / np.linalg.norm(here)
    b1, b2 = sampling.frame(v)
    along = math.cos(math.pi * u[0]) * b1 + math.sin(math.pi * u[0]) * b2
    gamma, length = math.atan2(n @ along, n @ v), math.hypot(n @ v, n @ along)
    # The sectors' edges by adding up the integrand, not by its closed form.
    theta = np.linspace(gamma - math.pi / 2, gamma + math.pi / 2, 20001)
    middle = (theta[1:] + theta[:-1]) / 2
    sums = np.concatenate([[0], np.cumsum(np.cos(middle - gamma) * np.abs(np.sin(middle)) * np.diff(theta))])
    way = (along[:2] * here[2] - here[:2] * along[2]) * F
    way /= np.hypot(*way)
    taken, total, lit = [False] * SECTORS, np.zeros(color.shape[2]), 0

    def reach(k):
        return 1 + k + span * (max(k + float(u[1]), 0) / steps) ** 2.5

    for k in range(steps):
        begin, end = (reach(k - 1) + reach(k)) / 2 if k else 0.5, (reach(k) + reach(k + 1)) / 2
        for side in (1, -1):
            i, j = (round(float(a + side * reach(k) * b)) for a, b in zip((column, row), way))
            if not (0 <= i < w and 0 <= j < h) or not normal[j, i].any():
                continue
            at, facing = position[j, i].astype(float), normal[j, i].astype(float)
            edges = []
            for r in (begin, end):
                ray = np.array([(column + side * r * way[0] - (w - 1) / 2) / F,
                                (row + side * r * way[1] - (h - 1) / 2) / F, 1.0])  # fmt: skip
                with np.errstate(divide="ignore"):
                    z = (facing @ at) / (facing @ ray)
                z = min(max(z if z > 0 else math.inf, at[2] / 1.5), at[2] * 1.5)
                edges.append(ray * z)
            edges.append(edges[1] * (1 + thickness))
            bits = []
            for e in edges:
                angle = math.atan2((e - here) @ along, (e - here) @ v)
                share = np.interp(angle, theta, sums / sums[-1])
                bits.append(math.floor(share * SECTORS + u[2]))
            faces = facing @ (at - here) < 0
            for s in range(min(bits), max(bits)):
                if not taken[s] and faces:
                    total += color[j, i]
                    lit += 1
                taken[s] = True
    scale = length * sums[-1] / SECTORS
    return total * scale, (SECTORS - lit) * scale


def test_the_horizon_scan_is_its_definition():
    h, w = 15, 17
    rng = np.random.default_rng(5)
    _, position, normal = surface(h, w, 5)
    color = rng.random((h, w, 2)).astype(np.float32)
    pixels = np.flatnonzero(normal.any(-1)).astype(np.int32)
    u = rng.random((len(pixels), 3)).astype(np.float32)
    got, unseen = horizon_scan(pixels, position, normal, color, u, (F, F), False, 0.1, 6, 20.0)
    differ = 0
    for k, p in enumerate(pixels):
        expected, rest = plain_scan(p, position, normal, color, u[k], 0.1, 6, 20.0)
        same = np.allclose(got[k], expected, rtol=1e-3, atol=1e-4) and np.isclose(unseen[k], rest, rtol=1e-3, atol=1e-4)
        differ += not same
    # An angle within rounding of a sector's edge may fall to either side.
    assert differ <= 0.03 * len(pixels)
    assert 0.05 < np.mean(got > 0)


@pytest.mark.parametrize("parallel", [False, True])
def test_a_slice_of_nothing_is_the_whole_hemisphere(parallel):
    """Averaged over turns the shares of what is not seen add up to 1, at any slant."""
    for tilt in (0.0, 40.0, 80.0):
        n = 4096
        position, normal = np.zeros((1, 1, 3), np.float32), np.zeros((1, 1, 3), np.float32)
        position[0, 0] = (0, 0, 3)
        normal[0, 0] = (math.sin(math.radians(tilt)), 0, -math.cos(math.radians(tilt)))
        u = np.stack([(np.arange(n) + 0.5) / n, np.full(n, 0.5), np.full(n, 0.5)], -1).astype(np.float32)
        pixels = np.zeros(n, np.int32)
        color = np.ones((1, 1, 1), np.float32)
        arrived, share = horizon_scan(pixels, position, normal, color, u, (F, F), parallel, 0.1, 4, 4.0)
        assert not arrived.any() and np.isclose(share.mean(), 1, rtol=1e-3)
