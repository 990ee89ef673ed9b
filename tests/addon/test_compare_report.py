# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report as a reader of HTML and of JSON finds it, and as a browser runs it."""

import json
import re

import bpy
import numpy as np
import pytest
from gi_bake.addon.compare import pictures
from gi_bake.addon.compare.report import MOST_PICTURES, write_report
from gi_bake.addon.compare.subject import Subject, summed
from gi_bake.tests.addon.page import BROWSER, Page, in_browser, pages_of_paper, pixels_of, without_browser

rng = np.random.default_rng(0)
TOLD = {
    "device": "cpu", "seconds": 1.5, "stages": {"read": 0.25, "gather": 1.25}, "settings": {"samples": 64},
    "approximated": ["Material 'Wood': one colour"], "warnings": ["Object '<script>alert(1)</script>' & more"],
}  # fmt: skip
TECHNIQUES = {"rsm": TOLD, "lpv": {**TOLD, "stages": {"read": 0.25, "maps": 3.0}, "warnings": []}}
REFERENCE = {"samples": 1024, "renderer": "Cycles"}
ROWS = [{"budget": "4 samples", "seconds": t, "relmse": 1 / t, "bias": 0.0} for t in (1.0, 2.0)]
CURVES = {"rsm": ROWS, "Cycles": ROWS, "Cycles, OIDN": ROWS}


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def subject(kind="indirect", name="Diffuse <Indirect>", size=(16, 24), spread=0.001):
    reference = rng.random((*size, 3)).astype(np.float32)
    noise = (spread * rng.normal(size=reference.shape)).astype(np.float32)
    bright, dim = reference.copy(), reference.copy()
    bright[0] *= 2  # the bottom row is too bright
    dim[-1] *= 0.5
    seen = np.ones(size, bool)
    seen[:, -1] = False
    mask = seen.copy()
    mask[:, -2] = False
    return Subject(name, kind, reference, noise, mask, seen, {"rsm": bright, "lpv": dim})


def report(folder, subjects, **more):
    return write_report(folder, "a.blend & Cycles", subjects, TECHNIQUES, REFERENCE, {"scene": "a"}, **more)


def three():
    direct, indirect = subject("direct", "Direct"), subject()
    return [indirect, direct, summed(direct, indirect, "Both")]


def test_page_shows_everything_and_needs_nothing_else(tmp_path):
    indirect = three()[0]
    path, _ = report(tmp_path, [indirect], curves=CURVES, ratios=[])
    page, text = Page(path), path.read_text(encoding="utf-8")
    for words in (
        "a.blend & Cycles", "Diffuse <Indirect>", "gather", "1.25", "1024", *TOLD["approximated"],
        "rsm: " + TOLD["warnings"][0],
        *(f"{m['relmse']:.5f}" for m in indirect.measures.values()), f"{indirect.floor['relmse']:.5f}",
        *(f"{m['bias']:+.2%}" for m in indirect.measures.values()),
    ):  # fmt: skip
        assert words in page.text
    # Nothing is fetched: the only addresses are of what the page carries.
    links = [v for _, attributes in page.tags for k, v in attributes.items() if k in ("src", "href")]
    assert links and all(v.startswith("data:") for v in links)
    assert not re.search(r"https?:|@import|url\((?!#)", text)
    assert {tag for tag, _ in page.tags}.isdisjoint({"iframe", "object", "embed"})
    assert "color-scheme: light dark" in text and "@media print" in text


def test_pictures_are_what_they_say(tmp_path):
    s = subject()
    page = Page(report(tmp_path, [s])[0])
    found = {alt.removeprefix("Diffuse <Indirect>, "): pixels_of(uri) for alt, uri in page.pictures.items()}
    cycles, ours = found["Cycles"], found["rsm"]
    assert cycles.shape == (16, 24, 4)
    # All at one exposure, so they are equal where the light is; what nothing is seen in is transparent.
    assert np.array_equal(ours[1:], cycles[1:]) and np.array_equal(found["reference"], cycles)
    assert (ours[0, :-1, :3] >= cycles[0, :-1, :3]).all() and not np.array_equal(ours[0], cycles[0])
    assert (ours[..., 3] == np.where(s.seen, 255, 0)).all()
    signed, dim = found["rsm, signed"], found["lpv, signed"]
    assert (signed[1:, :-1, :3] == 255).all() and (signed[0, :-1, 0] > signed[0, :-1, 2]).all()
    assert (dim[-1, :-1, 2] > dim[-1, :-1, 0]).all()
    # No error is black; the doubled row is bright, by the pixel's own share of relMSE.
    assert (found["rsm, error"][1:, :-1, :3].sum(-1) < 10).all()
    assert found["rsm, error"][0, :-1, :3].sum(-1).min() > 200
    assert found["rsm, FLIP"][0, :-1, :3].sum() > found["rsm, FLIP"][-1, :-1, :3].sum()
    # The mask: orange what is seen and left out.
    counted = found["counted"]
    assert (counted[:, -2, 0] > counted[:, -2, 2] + 100).all()
    assert (counted[:, :-2, 0] == counted[:, :-2, 2]).all()


def test_false_colours_are_their_scale():
    r = np.ones((1, 3, 3), np.float32)
    relative = np.array([0.01, 0.1, 1.0])
    x = r + (relative * np.sqrt(1.01))[None, :, None].astype(np.float32)
    found = pictures.error(x, r, np.ones((1, 3), bool))[0, :, :3]
    assert found.tolist() == [np.rint(255 * pictures.magma(np.array(v))).tolist() for v in (0, 0.5, 1)]


def test_json_has_the_same_numbers(tmp_path):
    indirect = subject()
    equal = Subject("Equal", "direct", *(getattr(indirect, k) for k in ("reference", "noise", "mask", "seen")),
                    {"rsm": indirect.reference, "lpv": indirect.reference})  # fmt: skip
    page, path = report(tmp_path, [indirect, equal], curves=CURVES)
    document = json.loads(path.read_text(encoding="utf-8"), parse_constant=lambda name: pytest.fail(name))
    for label in TECHNIQUES:
        told = document["techniques"][label]
        assert told["comparisons"]["Diffuse <Indirect>"]["relmse"] == indirect.measures[label]["relmse"]
        assert {key: told[key] for key in TOLD} == TECHNIQUES[label]
    assert document["reference"]["noise"]["Diffuse <Indirect>"]["rmse"] == indirect.floor["rmse"]
    assert document["counted"]["Diffuse <Indirect>"] == indirect.mask.sum() and document["curves"] == CURVES
    # JSON has no infinity; the page has.
    assert document["techniques"]["rsm"]["comparisons"]["Equal"]["psnr"] is None
    assert "∞" in Page(page).text


def test_noise_is_not_read_as_error(tmp_path):
    """A technique that is exactly right differs from a noisy mean as one of its halves does, and is marked."""
    truth = np.full((64, 64, 3), 0.5, np.float32)
    a, b = (truth + 0.1 * rng.normal(size=truth.shape).astype(np.float32) for _ in range(2))
    every = np.ones((64, 64), bool)
    s = Subject("S", "indirect", (a + b) / 2, (a - b) / 2, every, every, {"right": truth, "wrong": truth * 1.5})
    # Where the mean is too dark by chance, the truth's error weighs more: some 10 % on the whole at so much noise.
    assert s.floor["relmse"] == pytest.approx(s.measures["right"]["relmse"], rel=0.15)
    assert s.floor["rmse"] == pytest.approx(0.1 / np.sqrt(2), rel=0.03)
    techniques = {label: TOLD for label in s.ours}
    text = Page(write_report(tmp_path, "T", [s], techniques, {}, {})[0]).text
    assert f"{s.measures['right']['relmse']:.5f}†" in text and f"{s.measures['wrong']['relmse']:.5f}†" not in text


def test_a_dark_region_is_measured():
    light = np.ones((16, 16, 3), np.float32)
    light[:, 8:] = 0
    leaking = light + np.where(light > 0, 0, 0.02).astype(np.float32)
    every, dark = np.ones((16, 16), bool), light[..., 0] == 0
    s = Subject("S", "indirect", light, 0 * light, every, every, {"rsm": leaking}, dark)
    assert s.measures["rsm"]["leak"] == pytest.approx(0.02) and s.floor["leak"] == 0


def test_pictures_of_many_objects_are_few_and_numbers_are_all(tmp_path):
    subjects = [subject(name=f"Object {i}", size=(12, 12)) for i in range(MOST_PICTURES + 3)]
    page = Page(report(tmp_path, subjects)[0])
    assert all(s.name in page.text for s in subjects)
    assert len({alt.partition(",")[0] for alt in page.pictures}) == MOST_PICTURES


def test_a_new_report_replaces_the_old_one_whole_or_not_at_all(tmp_path):
    first = [path.read_bytes() for path in report(tmp_path, three())]
    with pytest.raises(TypeError):
        write_report(tmp_path, "Second", [], {"rsm": {**TOLD, "settings": {"device": object()}}}, {}, {})
    assert [(tmp_path / name).read_bytes() for name in ("report.html", "report.json")] == first
    write_report(tmp_path, "Second", [], TECHNIQUES, {}, {})
    assert "Second" in Page(tmp_path / "report.html").text
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report.html", "report.json"]


def assert_works(found):
    """The lights one at a time, the wipe by slider and pointer."""
    assert found["errors"] == [] and found["controls"]
    assert found["first"] == ["indirect"]
    assert found["shown"] == {kind: [kind] for kind in ("indirect", "direct", "combined")}
    assert found["slider"] == "20%" and found["pressed"] == "75%"
    # A pointer that is not pressed does nothing; one beyond the picture stops at its side.
    assert found["moved"] == "75%" and found["dragged"] == "100%" and found["value"] == 100


def test_the_pages_script_switches_and_wipes(tmp_path):
    pytest.importorskip("py_mini_racer")
    assert_works(without_browser(Page(report(tmp_path, three())[0])))


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome here; the script's own test runs without")
def test_the_page_in_a_browser(tmp_path):
    found, console = in_browser(report(tmp_path, three(), curves=CURVES)[0], tmp_path)
    assert_works(found)
    assert console == []
    # The picture on top is cut at the wipe, here at its right side.
    assert found["clip"] in ("inset(0px 0% 0px 0px)", "inset(0px calc(0%) 0px 0px)")


@pytest.mark.skipif(BROWSER is None, reason="no Chromium or Chrome here to print with")
def test_on_paper_every_light_is_there_and_begins_a_page(tmp_path):
    one = pages_of_paper(report(tmp_path, three()[:1])[0], tmp_path)
    assert pages_of_paper(report(tmp_path, three())[0], tmp_path) == one + 2
