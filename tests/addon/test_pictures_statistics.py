# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The test that holds pictures against Cycles' passes what is right within noise, and finds what is not."""

import numpy as np
import pytest
from gi_bake.tests.addon import test_pictures
from gi_bake.tests.addon.page import Page
from gi_bake.tests.addon.test_pictures import share_off

SHAPE = (48, 48, 3)


def two_renders(truth, deviation, rng, alike=1):
    """Mean and half difference of two, with as much noise as light, which so many pixels each way have in common."""
    side = -(-SHAPE[0] // alike)
    noises = (np.kron(rng.normal(size=(side, side, 3)), np.ones((alike, alike, 1))) for _ in range(2))
    a, b = (truth * (1 + deviation * noise[: SHAPE[0], : SHAPE[1]]) for noise in noises)
    return (a + b) / 2, (a - b) / 2


@pytest.mark.parametrize("seed", range(5))
def test_noise_passes_and_errors_do_not(seed):
    rng = np.random.default_rng(seed)
    light = np.broadcast_to(np.linspace(0.1, 1, 48)[:, None, None], SHAPE)
    theirs, spread = two_renders(light, 0.2, rng)
    mask = np.ones(SHAPE[:2], bool)

    def off(truth, known=0.0, **more):
        return share_off(*two_renders(truth, 0.3, rng, **more), theirs, spread, mask, known)

    assert off(light) == 0 and off(light, alike=5) == 0
    assert off(light * 1.35) > 0.8 and off(light * 1.35, known=0.4) == 0
    # One block that is wrong is found among all others.
    wrong = light.copy()
    wrong[12:18, 30:36] *= 2
    assert off(wrong) == pytest.approx(1 / 64)
    # So is a band of blocks that has too little of one colour.
    wrong = light.copy()
    wrong[:6, :, 2] *= 0.4
    assert off(wrong) >= 6 / 64


def test_what_fails_leaves_a_report(tmp_path, monkeypatch):
    monkeypatch.setattr(test_pictures, "EVIDENCE", tmp_path)
    rng = np.random.default_rng(0)
    light = rng.random((12, 12, 3), dtype=np.float32)
    truth = {"Diffuse Indirect": light, "Diffuse Indirect Noise": 0.01 * light}
    every, off = np.ones((12, 12), bool), {"Diffuse Indirect": (0.25, 0.1)}
    page = Page(test_pictures.evidence("room", "rsm", truth, {"Diffuse Indirect": 2 * light}, every, off))
    assert "0.25" in page.text and "Diffuse Indirect, rsm, signed" in page.pictures
