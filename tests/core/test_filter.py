# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
from gi_bake.gi_core import filter as smoothing
from gi_bake.gi_core import images, surfels, tiles
from gi_bake.gi_core.kernels.bilateral import bilateral
from gi_bake.gi_core.surfels import Surfels
from gi_bake.tests import shapes


def plain(value, position, normal, footprint, step, walls):
    """The filter's definition, one pixel and one tap after the other."""
    h, w, c = value.shape
    spline = np.array([1, 4, 6, 4, 1]) / 16
    out = np.zeros((h, w, c))
    for y in range(h):
        for x in range(w):
            if footprint[y, x] == 0:
                continue
            total = 0.0
            for j in range(-2, 3):
                for i in range(-2, 3):
                    v, u = y + j * step, x + i * step
                    if not (0 <= v < h and 0 <= u < w) or footprint[v, u] == 0:
                        continue
                    if walls[y, x, 0] != walls[y, u, 0] or walls[y, u, 1] != walls[v, u, 1]:
                        continue
                    cosine = max(0.0, float(normal[y, x] @ normal[v, u]))
                    plane = float(normal[y, x] @ (position[v, u] - position[y, x])) / (footprint[y, x] * step)
                    weight = spline[j + 2] * spline[i + 2] * cosine**16 / (1 + plane**2) ** 2
                    total += weight
                    out[y, x] += weight * value[v, u]
            out[y, x] /= total
    return out


def surface(h, w, seed=0):
    rng = np.random.default_rng(seed)
    position = np.dstack([*np.meshgrid(np.arange(w), np.arange(h)), rng.normal(0, 0.7, (h, w))]).astype(np.float32)
    normal = rng.normal((0, 0, 2), 0.4, (h, w, 3)).astype(np.float32)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    normal[rng.random((h, w)) < 0.2] = 0
    return rng.random((h, w, 3)).astype(np.float32), position, normal


def test_the_filter_is_its_definition():
    for h, w, step in ((9, 13, 1), (17, 8, 2), (1, 1, 1), (6, 5, 4)):
        value, position, normal = surface(h, w)
        footprint = smoothing.pixel_footprint(position, normal)
        rng = np.random.default_rng(step)
        walls = np.stack([np.cumsum(rng.random((h, w)) < 0.1, 1), np.cumsum(rng.random((h, w)) < 0.1, 0)], -1)
        for between in (np.zeros_like(walls), walls):
            ours = bilateral(value, position, normal, footprint, step, between.astype(np.float32))
            assert np.allclose(ours, plain(value, position, normal, footprint, step, between), rtol=1e-4, atol=1e-6)
        without = bilateral(value, position, normal, footprint, step)
        assert np.array_equal(without, bilateral(value, position, normal, footprint, step, np.zeros((h, w, 2))))


def test_tiles_do_not_show(monkeypatch):
    value, position, normal = surface(50, 20)
    whole = tiles.finish(smoothing.smooth(value, position, normal, 3))
    monkeypatch.setattr(smoothing, "_PIXELS", 16 * 20)
    assert np.array_equal(whole, tiles.finish(smoothing.smooth(value, position, normal, 3)))


def test_noise_goes_and_edges_stay():
    """Two planes that meet at a right angle, one lit, one dark, seen side by side, with noise on both."""
    rng = np.random.default_rng(0)
    x, y = np.meshgrid(np.arange(40.0), np.arange(40.0))
    left = x < 20
    position = np.dstack([np.where(left, x, 20), y, np.where(left, 0, x - 20)]).astype(np.float32)
    normal = np.where(left[..., None], (0, 0, 1), (-1, 0, 0)).astype(np.float32)
    clean = np.where(left, 1.0, 0.0)[..., None].repeat(3, -1).astype(np.float32)
    noisy = clean + rng.normal(0, 0.3, clean.shape).astype(np.float32)
    done = tiles.finish(smoothing.smooth(noisy, position, normal, 3))
    assert done[:, :20].std() < 0.06 and done[:, 20:].std() < 0.06
    assert abs(done[:, 19].mean() - 1) < 0.05 and abs(done[:, 20].mean()) < 0.05


def test_a_constant_stays_and_nothing_comes_from_outside():
    _, position, normal = surface(30, 30)
    done = tiles.finish(smoothing.smooth(np.full((30, 30, 3), 0.7, np.float32), position, normal, 4))
    valid = np.any(normal != 0, -1)
    assert np.allclose(done[valid], 0.7, atol=1e-5) and (done[~valid] == 0).all()


def test_islands_of_one_plane_keep_apart():
    """Floors beside each other on a lightmap, and far apart in one plane: light of one is nothing to the others."""
    row, column = (n.ravel() for n in np.mgrid[:41, :41])
    there = (row != 20) & (column != 20)
    row, column = row[there], column[there]
    position = np.stack([column + 50 * (column > 20), row + 50 * (row > 20), 0 * row], -1).astype(np.float32)
    up = np.broadcast_to(np.float32([0, 0, 1]), position.shape)
    points = Surfels(position, up, up, 0 * position, 0 * position, row * 41 + column)
    tracer = shapes.tracer([shapes.plate(-1, 1)])
    light = np.random.default_rng(0).random((len(points), 3)).astype(np.float32)
    other = (row > 20) | (column > 20)
    done = [tiles.finish(images.smoothed(light * np.where(other, factor, 1)[:, None].astype(np.float32), points,
                                         points.place, (41, 41), 3, tracer=tracer)) for factor in (1, 1000)]
    assert np.array_equal(done[0][~other], done[1][~other]) and not np.allclose(done[0], light, atol=0.1)


def test_light_does_not_pass_under_a_wall():
    """A floor of two rooms, lit on the left, as one lightmap: the wall between them keeps the filter out."""
    wall = shapes.quad((0, -1, 0), (0, 1, 0), (0, 1, 1), (0, -1, 1), name="wall")
    tracer = shapes.tracer([shapes.plate(0, 1), wall])
    points, _ = surfels.from_texels(tracer.geometry, "plate", "", (40, 40))
    lit = (points.position[:, :1] < 0).astype(np.float32)
    done = tiles.finish(images.smoothed(lit, points, points.place, (40, 40), 3, tracer=tracer))
    assert np.array_equal(done > 0.5, lit > 0.5) and np.abs(done - lit).max() < 1e-5
    through = tiles.finish(images.smoothed(lit, points, points.place, (40, 40), 3))
    assert np.abs(through - lit).max() > 0.3


def test_what_is_no_noise_is_given_back():
    """A shadow's edge on an even floor, noisy: with the noise known the filter keeps the edge and calms the rest."""
    side, rng = 96, np.random.default_rng(8)
    row, column = np.mgrid[:side, :side]
    position = np.stack([column, row, 0 * row], -1).reshape(-1, 3).astype(np.float32)
    up = np.broadcast_to(np.float32([0, 0, 1]), position.shape)
    points = Surfels(position, up, up, 0 * position, 0 * position, np.arange(side * side))
    truth = np.where(column < side / 2, 1.0, 3.0).reshape(-1, 1) * np.ones(3)
    for sigma in (0.05, 0.3, 1.0):
        noisy = (truth + rng.normal(0, sigma, truth.shape)).astype(np.float32)
        # In two parts, of whose sum the variance is known.
        parts = np.concatenate([noisy - 0.25, 0 * noisy + 0.25], -1)
        variance = np.full(noisy.shape, sigma**2, np.float32)
        plain, kept = (
            tiles.finish(images.smoothed(parts, points, points.place, (side, side), 3, known)).reshape(-1, 2, 3).sum(1)
            for known in (None, variance)
        )
        errors = [np.mean((image - truth) ** 2) for image in (noisy, plain, kept)]
        assert errors[2] < 0.7 * errors[0] and errors[2] < errors[1]
        # Away from the edge nothing is left to give back.
        away = (np.abs(column - side / 2) > 20).ravel()
        assert np.mean((kept - truth)[away] ** 2) < 0.1 * sigma**2


def test_detail_is_what_noise_does_not_explain():
    taken, noise = np.array([0.0, 1.0, 1.0, 4.0]), np.array([0.0, 1.0, 2.0, 1.0])
    assert images.detail(taken, noise).tolist() == [0, 0, 0, 0.75]
