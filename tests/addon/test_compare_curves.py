# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Error over time: ratios of curves that can be worked out by hand, and their picture."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
from gi_bake.addon.compare import curves
from gi_bake.addon.compare.plot import log_log
from gi_bake.addon.job import Job
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.rsm.settings import RsmSettings


def row(seconds, relmse):
    return {"budget": "some", "seconds": seconds, "relmse": relmse, "bias": 0.0}


# A path tracer: half the error for double the time. Denoised, four times better.
CYCLES = [row(t, 1 / t) for t in (1, 2, 4, 8, 16)]
DENOISED = [row(t, 0.25 / t) for t in (1, 4, 16)]


def ratios(ours, noise=0.0):
    found = {"ours": ours, curves.CYCLES: CYCLES, curves.DENOISED: DENOISED}
    return {r["against"]: r for r in curves.against_cycles(found, noise)}


def test_equal_error_and_equal_time_lie_on_the_curves():
    """0.1 after 3 s: Cycles has it after 10 s, and has 1/3 after 3 s."""
    r = ratios([row(1, 0.5), row(3, 0.1)])
    assert r[curves.CYCLES]["times faster"] == pytest.approx(10 / 3)
    assert r[curves.CYCLES]["times better"] == pytest.approx(10 / 3)
    assert r[curves.DENOISED]["times faster"] == pytest.approx(2.5 / 3)
    assert r[curves.DENOISED]["times better"] == pytest.approx((0.25 / 3) / 0.1)


def test_beyond_the_pictures_nothing_is_guessed():
    r = ratios([row(0.5, 0.01)])
    assert r[curves.CYCLES]["times faster"] is None and r[curves.CYCLES]["times better"] is None


def test_where_cycles_first_picture_is_nearer_already_it_has_taken_that_ones_time():
    assert ratios([row(4, 2.0)])[curves.CYCLES]["times faster"] == pytest.approx(1 / 4)


def test_noise_of_the_reference_is_taken_off_and_said():
    noise = 0.05
    found = [
        [row(r["seconds"], r["relmse"] + noise) for r in rows] for rows in (CYCLES, DENOISED, [row(3, 0.1)])
    ]
    measured = {curves.CYCLES: found[0], curves.DENOISED: found[1], "ours": found[2]}
    r = next(r for r in curves.against_cycles(measured, noise) if r["against"] == curves.CYCLES)
    assert r["times faster"] == pytest.approx(10 / 3) and not r["doubtful"]
    assert ratios([row(3, 0.06)], noise)[curves.CYCLES]["doubtful"]


def test_a_picture_that_is_slower_and_worse_than_another_is_no_part_of_the_curve():
    rows = [*CYCLES, row(3, 0.9)]
    assert curves.time_at(rows, 0.4) == pytest.approx(curves.time_at(CYCLES, 0.4))
    assert curves.error_at(rows, 3) == pytest.approx(1 / 3)


def test_budgets_stay_within_their_bounds_and_none_comes_twice():
    job = Job(settings=RsmSettings(samples=64, light_samples=32))
    found = dict(curves.jobs(job, (1 / 4, 1 / 16, 1 / 64, 1 / 128, 1)))
    assert list(found) == ["1 samples", "4 samples", "16 samples"]
    assert [j.settings.light_samples for j in found.values()] == [1, 2, 8]
    lpv = Job(method="lpv", settings=LpvSettings(cells=64))
    assert list(dict(curves.jobs(lpv, (1 / 16, 1 / 4, 1 / 2)))) == ["16 cells", "32 cells"]


def test_the_plot_is_straight_where_a_power_law_is():
    svg = log_log({"a <b>": [(t, 1 / t, "x & y") for t in (1, 10, 100)]}, "s", "e", floor=0.02)
    tree = ET.fromstring(svg)
    line = next(p for p in tree.iter("path") if p.get("class") == "line").get("d")
    places = np.array([[float(n) for n in p.split()] for p in line[1:].split("L")])
    steps = np.diff(places, axis=0)
    assert steps[0] == pytest.approx(steps[1], abs=0.2)
    # Later is to the right, less error is lower.
    assert (steps > 0).all()
    assert "a <b>" in "".join(tree.itertext())
    assert any(p.get("class") == "floor" for p in tree.iter("path"))
