# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One light of several gets the shadow ray: the mean stays, the noise falls."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import gathering
from gi_bake.gi_core.kernels.vpl_gather import chosen
from gi_bake.gi_core.refine import Goal, refined
from gi_bake.gi_core.sampling import Samples
from gi_bake.gi_core.surfels import Surfels
from gi_bake.gi_core.tiles import finish
from gi_bake.gi_core.vpls import Packed, Vpls
from gi_bake.tests import shapes

# A half-high wall between the lights of a ceiling and half of the floor.
WALL = shapes.quad((0, -3, 0), (0, 3, 0), (0, 3, 0.8), (0, -3, 0.8), name="wall")
TRACER = shapes.tracer([shapes.plate(-1, 9, name="ground"), WALL])


def ceiling(n=4096):
    """Lights of one brightness over a square at height 1, coloured, from −2 to 2."""
    rng = np.random.default_rng(4)
    place = (rng.random((n, 3)) * [4, 4, 0] + [-2, -2, 1]).astype(np.float32)
    down = np.broadcast_to(np.float32([0, 0, -1]), place.shape)
    flux = np.where(place[:, :1] < 0, np.float32([3, 0, 0]), np.float32([0, 1, 2])) * np.float32(1 / n)
    return Vpls(place, place, down, flux, np.full(n, 1e-4, np.float32))


def floor(x, n=40_000):
    here = np.tile(np.float32([x, 0, 0]), (n, 1))
    up = np.broadcast_to(np.float32([0, 0, 1]), here.shape)
    return Surfels(here, up, up, 0 * here, 0 * here, np.arange(n))


def gathered(points, lights, candidates, samples=8, visibility=True):
    pattern = gathering.Strided.of(lights, Samples(samples), 1, candidates)
    return finish(gathering.gather(TRACER, points, lights, pattern, visibility, candidates=candidates))


@pytest.mark.parametrize("x", [0.3, 1.5])
@pytest.mark.parametrize("candidates", [2, 4, 7])
def test_the_mean_is_that_of_all_lights_with_their_shadows(x, candidates):
    lights, points = ceiling(), floor(x)
    all_lights = gathering.Every(len(lights))
    every = finish(gathering.gather(TRACER, points[:1], lights, all_lights))
    open_ = finish(gathering.gather(TRACER, points[:1], lights, all_lights, False))
    # The wall counts.
    assert every[0, 0] < 0.9 * open_[0, 0]
    assert np.allclose(gathered(points, lights, candidates).mean(0), every[0], rtol=0.03)


def test_noise_falls_with_candidates_at_as_many_rays(monkeypatch):
    lights, points = ceiling(), floor(1.5)
    rays = []
    connected = type(TRACER).connected
    monkeypatch.setattr(type(TRACER), "connected", lambda self, a, b: rays.append(len(a)) or connected(self, a, b))
    noise = []
    for candidates in (1, 2, 4, 8):
        rays.clear()
        noise.append(gathered(points, lights, candidates).sum(-1).var())
        assert sum(rays) <= 8 * len(points)
    assert noise[1] < 0.7 * noise[0] and noise[2] < 0.7 * noise[1] and noise[3] < noise[2]


def test_candidates_that_bring_nothing_do_no_harm():
    lights, points = ceiling(), floor(0.3)
    behind = Surfels(points.position, -points.normal, -points.face, points.albedo, points.emission, points.place)
    assert not gathered(behind, lights, 4).any()


def test_passes_draw_their_survivors_anew():
    """By one number for all passes, the light that a point takes of a group would be of the same rank every time."""
    lights = ceiling()
    lights = replace(lights, flux=np.ones_like(lights.flux))
    # From so far below all lights bring the same.
    points = floor(0, 2000)
    points = replace(points, position=points.position - np.float32([0, 0, 500]))
    ranks = []
    for first in (0, 4):
        pattern = gathering.Strided.of(lights, Samples(4, first), 1, 4)
        drawn = chosen(points, Packed.of(lights), pattern, "disc", 4)[..., 0]
        every = pattern(points)[0].reshape(2000, 4, 4)
        ranks.append(np.argmax(every == drawn.T[..., None], -1))
    # Independent draws of four equals agree in a quarter.
    assert abs(np.mean(ranks[0] == ranks[1]) - 0.25) < 0.03


def test_the_spread_of_passes_tells_the_noise():
    lights, points = ceiling(), floor(1.5, 4000)
    truth = finish(gathering.gather(TRACER, points[:1], lights, gathering.Every(len(lights)), False))

    def one_pass(samples):
        pattern = gathering.Strided.of(lights, samples, 1, 4)
        light = yield from gathering.gather(TRACER, points, lights, pattern, False, candidates=4)
        return light[:, None]

    estimate = finish(refined(one_pass, Goal(32)))
    error = np.mean(np.sum((estimate.values[:, 0] - truth) ** 2, -1))
    # Passes lie in each other's gaps, so that their mean is a little better than their spread says.
    assert 0.9 < np.mean(estimate.variance.sum(-1)) / error < 1.6
