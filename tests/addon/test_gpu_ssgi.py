# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space GI on the graphics card: each kernel against numpy's, on random images."""

import numpy as np
import pytest
from gi_bake.gi_core import sampling
from gi_bake.gi_core.kernels.bilateral_upsample import bilateral_upsample
from gi_bake.gi_core.kernels.clamped import clamped
from gi_bake.gi_core.kernels.depth_march import depth_march
from gi_bake.gi_core.kernels.depth_pyramid import NOTHING, depth_pyramid
from gi_bake.gi_core.kernels.diffuse_filter import diffuse_filter
from gi_bake.gi_core.kernels.hit_light import hit_light
from gi_bake.gi_core.kernels.horizon_scan import horizon_scan
from gi_bake.gi_core.kernels.march_cells import march_cells
from gi_bake.gi_core.kernels.pixel_planes import pixel_planes
from gi_bake.gi_core.kernels.reflected import reflected
from gi_bake.gi_core.kernels.reproject import reproject
from gi_bake.gi_core.kernels.scan_light import scan_light
from gi_bake.gi_core.kernels.screen_trace import screen_trace
from gi_bake.gi_core.kernels.slice_draws import slice_draws
from gi_bake.gi_core.kernels.spread import spread
from gi_bake.gi_core.kernels.surface_weight import surface_weight
from gi_bake.gi_core.kernels.temporal import history_taps, temporal
from gi_bake.gi_core.scene import Camera
from gi_bake.gi_core.ssgi.frame import DepthMap
from gi_bake.gi_core.ssgi.screen import Screen

F = 40.0
SIZES = [(1, 1), (5, 70), (64, 64), (33, 129)]
LENGTHS = [0, 1, 64, 1000]


def random(*shape, seed=0):
    return np.random.default_rng(seed).random(shape, np.float32)


def units(n, seed=0, spread=0.5):
    v = np.random.default_rng(seed).normal((0, 0, 1), spread, (n, 3)).astype(np.float32)
    return v / np.linalg.norm(v, axis=-1, keepdims=True)


def surface(h, w, seed=0, empty=0.15):
    """A bumpy wall with steps in depth and holes: depth, position, normal, in camera space."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:h, :w] - np.array([(h - 1) / 2, (w - 1) / 2])[:, None, None]
    depth = (4 + rng.normal(0, 0.03, (h, w)) + 2 * (x > w / 5)).astype(np.float32)
    normal = units(h * w, seed, 0.3).reshape(h, w, 3) * np.float32([1, 1, -1])
    position = np.dstack([x / F * depth, y / F * depth, depth]).astype(np.float32)
    normal *= -np.sign(np.sum(normal * position, -1, keepdims=True))
    hole = rng.random((h, w)) < empty
    depth[hole], position[hole], normal[hole] = np.inf, 0, 0
    return depth, position, normal


def seen(h, w, seed, kind="PERSPECTIVE"):
    """The same by a camera in the world: its Screen, depth, position, normal."""
    depth, position, normal = surface(h, w, seed)
    if kind == "ORTHOGRAPHIC":
        position[..., :2] *= np.where(np.isfinite(depth), 4 / depth, 0)[..., None]
    half = np.float64([w, h]) / 2 / (F if kind == "PERSPECTIVE" else F / 4)
    camera = Camera(kind, np.eye(4), (-half[0], half[0], -half[1], half[1]), (w, h), (0.1, 100))
    return Screen(camera), depth, *(v * np.float32([1, 1, -1]) for v in (position, normal))


def mostly(gpu, kernel, *arguments, share=0.999, **settings):
    """Holds a kernel whose results may be another where a number is within rounding of a border: all else is the same
    to 1e-4."""
    expected, found = kernel(*arguments, **settings), gpu.run(kernel, *arguments, **settings)
    if not isinstance(expected, tuple):
        expected, found = (expected,), (found,)
    alike = np.ones(len(expected[0]), bool)
    for e, f in zip(expected, map(gpu.numpy, found), strict=True):
        assert f.shape == e.shape and f.dtype.kind == e.dtype.kind
        same = f == e if e.dtype.kind != "f" else np.isclose(f, e, rtol=1e-4, atol=1e-4 * np.abs(e).max(initial=0))
        alike &= same.all(tuple(range(1, e.ndim)))
    assert alike.mean() >= share if len(alike) else True, f"{np.count_nonzero(~alike)} of {len(alike)} differ"


@pytest.mark.parametrize("size", SIZES)
def test_the_pyramid(same, size):
    nearest = random(*size)
    nearest[random(*size, seed=1) < 0.2] = NOTHING
    for levels in (1, 4, 7):
        same(depth_pyramid, nearest, levels)


@pytest.mark.parametrize("n", LENGTHS)
def test_the_march(gpu, n):
    h, w = 39, 53
    depth, position, normal = surface(h, w, 3)
    there = np.isfinite(depth)
    device = np.where(there, -1 / depth, NOTHING).astype(np.float32)
    over = np.where(there, np.sum(normal * position, -1), 1)
    slope = np.where(there[..., None], -normal[..., :2] / over[..., None] / F, 0)
    most = 0.3 * np.abs(np.where(there, device, 0))
    slope *= np.minimum(1, most / np.maximum(np.abs(slope).sum(-1), 1e-9))[..., None]
    slope = slope.astype(np.float32)
    nearest = np.where(there, device - np.abs(slope).sum(-1) / 2, NOTHING).astype(np.float32)
    rng = np.random.default_rng(n)
    pixel, z = rng.integers(0, h * w, n), rng.uniform(1, 8, n)
    origin = np.stack([pixel % w + 0.5, pixel // w + 0.5, -1 / z], -1).astype(np.float32)
    direction = (rng.normal(0, 1, (n, 3)) * (1, 1, 0.02)).astype(np.float32)
    direction[: n // 10, 0] = 0
    pyramid, table = depth_pyramid(nearest, 7)
    cells = march_cells(device, slope, pyramid)
    hit, _ = depth_march(origin, direction, cells, table, -2.0, 1 / 1.1, 256)
    assert n < 100 or 0.1 * n < np.count_nonzero(hit >= 0) < 0.9 * n
    for steps, sure in ((5, False), (256, False), (256, True)):
        mostly(gpu, depth_march, origin, direction, cells, table, -2.0, 1 / 1.1, steps, sure)


@pytest.mark.parametrize("size", SIZES)
def test_what_a_march_reads(same, size):
    depth, slope = random(*size), random(*size, 2, seed=1)
    same(march_cells, depth, slope, depth_pyramid(depth, 7)[0])


@pytest.mark.parametrize("size", [*SIZES, (0, 0)])
@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
def test_planes_of_pixels(same, size, kind):
    screen, depth, position, normal = seen(*size, 7, kind)
    same(pixel_planes, depth.ravel(), position.reshape(-1, 3), normal.reshape(-1, 3), screen)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", ["PERSPECTIVE", "ORTHOGRAPHIC"])
@pytest.mark.parametrize("certain", [False, True])
def test_rays_over_the_screen(gpu, size, kind, certain):
    (h, w), (screen, depth, position, normal) = size, seen(*size, 8, kind)
    planes = pixel_planes(depth.ravel(), position.reshape(-1, 3), normal.reshape(-1, 3), screen)
    pyramid, table = depth_pyramid(planes[2].reshape(size), 7)
    march = DepthMap(march_cells(planes[0].reshape(size), planes[1].reshape(h, w, 2), pyramid), table)
    tilted = (normal + random(h, w, 3, seed=9) * np.float32(0.3)) / np.float32(1.1)
    pixels = np.flatnonzero(np.isfinite(depth)).astype(np.int32)
    valid, points = random(h * w, seed=10) > 0.1, random(3, 2, seed=11)
    given = depth, position, normal, normal, march, points, screen, 2**33 + 5, 1 / 1.1, 64, certain
    for few in (pixels[:0], pixels[:1], pixels):
        mostly(gpu, screen_trace, few, few + 2**20, valid, *given, share=0.99)
    mostly(gpu, screen_trace, pixels, pixels, None, *given, tilted, share=0.99)
    met = screen_trace(pixels, pixels, None, *given) >= 0
    assert h * w < 1000 or certain or 0.01 < met.mean() < 0.9


@pytest.mark.parametrize("n", LENGTHS)
def test_reprojection(same, n):
    h, w, m = 7, 90, 500
    color, depth = random(h, w, 3), random(h, w, seed=1) + 2
    depth[random(h, w, seed=2) < 0.2] = np.inf
    before = (random(m, 3, seed=3) * np.float32([w + 4, h + 4, 1]) + np.float32([-2, -2, 2])).astype(np.float32)
    before[::7] = np.nan
    hit = np.random.default_rng(n).integers(-1, m, n).astype(np.int32)
    same(reproject, hit, before, color, depth, 0.1)


@pytest.mark.parametrize("n", LENGTHS)
def test_history_taps(same, n):
    h, w = 6, 80
    _, position, normal = surface(h, w, 1)
    before = (random(n, 2) * np.float32([w + 2, h + 2]) - np.float32(1.5)).astype(np.float32)
    before[::9] = np.nan
    pick = np.random.default_rng(n).integers(0, h * w, n)
    expected = position.reshape(-1, 3)[pick] + random(n, 3, seed=2) * np.float32(0.3)
    here = normal.reshape(-1, 3)[pick]
    limit = np.full(n, 0.5, np.float32)
    arguments = before, expected, here, np.full(n, 0.3, np.float32), random(n), position, normal
    same(history_taps, *arguments, limit)
    same(history_taps, *arguments, 0.25)


@pytest.mark.parametrize("n", LENGTHS)
@pytest.mark.parametrize("hdrp", [False, True])
def test_the_temporal_filter(same, n, hdrp):
    h, w = 9, 70
    taps = np.random.default_rng(n).integers(0, h * w, (n, 4)).astype(np.int32)
    weights = random(n, 4) * (random(n, 1, seed=3) > 0.2)
    weights /= np.maximum(weights.sum(-1, keepdims=True), np.float32(1e-9))
    count = np.floor(random(h, w, seed=1) * 12).astype(np.float32)
    for skipped in (0,) if hdrp else (0, 4):
        same(temporal, random(n, 3), random(h, w, 3), count, taps, weights, hdrp, skipped)


@pytest.mark.parametrize("n", LENGTHS)
@pytest.mark.parametrize("literal", [False, True])
def test_the_surface_weight(same, n, literal):
    points = random(2, n, 3) * np.where(random(n) < 0.2, np.float32(1e-3), np.float32(0.3))[:, None]
    depth = random(2, n)
    pairs = depth[0], points[0], units(n), depth[1], points[1], units(n, 1)
    same(surface_weight, *pairs, 0.8, literal)
    same(surface_weight, *pairs, random(n), literal)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("turned", [False, True])
def test_the_diffuse_filter(gpu, size, turned):
    h, w = size
    depth, position, normal = surface(h, w, 2)
    matrix = np.array([[F, 0, (w - 1) / 2, 0], [0, F, (h - 1) / 2, 0], [0, 0, 1, 0], [0, 0, 1, 0]])
    pixels = np.arange(h * w, dtype=np.int32)
    radius = random(h * w) * 2 + np.float32(0.3)
    taps = sampling.disk(random(9, 2) if turned else random(h * w, 9, 2))
    seed = 12345678901 if turned else None
    for literal in (False, True):
        mostly(gpu, diffuse_filter, pixels, random(h, w, 3), depth, position, normal, radius, taps, matrix, 50.0, 0.8,
               literal, seed)  # fmt: skip
    for few in (pixels[:0], pixels[-1:]):
        mostly(gpu, diffuse_filter, few, random(h, w, 2), depth, position, normal, radius[few],
               taps if turned else taps[few], matrix, 50.0, random(len(few)), False, seed)  # fmt: skip


@pytest.mark.parametrize("n", LENGTHS)
@pytest.mark.parametrize("size", SIZES)
def test_the_upsample(same, n, size):
    h, w = size
    depth, position, normal = surface(h, w, 4)
    at = random(n, 2) * np.float32([w, h]) - np.float32(0.5)
    at[::5] = np.nan
    pick = np.random.default_rng(n).integers(0, h * w, n)
    z = np.where(np.isfinite(depth), depth, 1).ravel()[pick].astype(np.float32)
    here, up = position.reshape(-1, 3)[pick], units(n) * np.float32([1, 1, -1])
    same(bilateral_upsample, at, z, here, up, random(h, w, 3), depth, position, normal, 50.0, z / np.float32(5))


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("parallel", [False, True])
@pytest.mark.parametrize("slices", [1, 3])
def test_the_horizon_scan(gpu, size, parallel, slices):
    h, w = size
    _, position, normal = surface(h, w, 5)
    if parallel:
        normal = np.where(normal[..., 2:] > 0, -normal, normal)
    pixels = np.flatnonzero(normal.any(-1)).astype(np.int32)
    u = random(len(pixels) * slices, 3)
    rest = (position, normal, random(h, w, 3)), (u, (F, F), parallel, 0.1, 6, 50.0)
    mostly(gpu, horizon_scan, pixels, *rest[0], *rest[1], share=0.99)
    mostly(gpu, horizon_scan, pixels[:0], *rest[0], u[:0], *rest[1][1:])
    _, _, shown = surface(h, w, 6)
    mostly(gpu, horizon_scan, pixels, *rest[0], *rest[1], shown, share=0.99)


@pytest.mark.parametrize("n", LENGTHS)
def test_draws_are_the_very_same(gpu, n):
    place = np.arange(n, dtype=np.int32) * 7 + 100000
    for count, seed in ((1, 0), (3, 4096 * 70000 + 5)):
        found = gpu.numpy(gpu.run(slice_draws, place, 5, count, seed))
        np.testing.assert_array_equal(found, slice_draws(place, 5, count, seed))


@pytest.mark.parametrize("n", LENGTHS)
@pytest.mark.parametrize("rays", [1, 4])
def test_the_light_of_hits_and_slices(same, n, rays):
    h, w = 5, 90
    hit = np.random.default_rng(n).integers(-2, h * w, n * rays).astype(np.int32)
    for rest in (None, random(n, 2, 3)):
        same(hit_light, hit, random(h, w, 3), rest, 1, rays)
        same(scan_light, random(n * rays, 3), random(n * rays), rest, 1, rays)


@pytest.mark.parametrize("size", [*SIZES, (0, 0)])
def test_images_of_lists_and_what_surfaces_send(same, size):
    row = np.random.default_rng(1).integers(-1, 40, size).astype(np.int32)
    same(spread, random(40, 3), row)
    same(spread, random(0, 3), np.full(size, -1, np.int32))
    same(reflected, random(*size, 3), random(*size, 3, seed=1), random(*size, 3, seed=2))
    for most in (0.0, 0.5):
        same(clamped, random(*size, 3), most)
