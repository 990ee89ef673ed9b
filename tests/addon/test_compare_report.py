# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report as a reader of HTML and of JSON finds it."""

import base64
import json
import re
from html.parser import HTMLParser

import bpy
import numpy as np
import pytest
from gi_bake.addon.compare.report import Comparison, write_report
from gi_bake.gi_core import metrics

rng = np.random.default_rng(0)
FACTS = {
    "method": "rsm",
    "seconds": 1.5,
    "stages": {"read": 0.25, "gather": 1.25},
    "settings": {"samples": 64},
    "reference": {"samples": 1024},
    "approximated": ["Material 'Wood': one colour"],
    "warnings": ["Object '<script>alert(1)</script>' & more"],
}


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


class Page(HTMLParser):
    """The text, the pictures and the tags of a page; fails where tags do not match."""

    def __init__(self, path):
        super().__init__()
        self.text, self.pictures, self.open, self.tags = "", {}, [], set()
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.add(tag)
        if tag == "img":
            self.pictures[dict(attrs)["alt"]] = dict(attrs)["src"]
        elif tag != "meta":
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        self.text += data


def pixels_of(uri, folder):
    """What Blender sees in a picture: (h, w, 4) uint8."""
    kind, data = uri.split(",")
    assert kind == "data:image/png;base64"
    (folder / "picture.png").write_bytes(base64.b64decode(data))
    image = bpy.data.images.load(str(folder / "picture.png"))
    image.alpha_mode = "CHANNEL_PACKED"
    pixels = np.empty((image.size[1], image.size[0], 4), np.float32)
    image.pixels.foreach_get(pixels.ravel())
    bpy.data.images.remove(image)
    return np.rint(pixels * 255).astype(int)


@pytest.fixture
def comparison():
    reference = rng.random((6, 9, 3)).astype(np.float32)
    ours = reference.copy()
    ours[0] *= 2  # the bottom row is too bright
    mask = np.ones((6, 9), bool)
    mask[:, -1] = False
    return Comparison("Diffuse <Indirect>", ours, reference, mask, metrics.measure(ours, reference, mask))


def test_page_shows_everything_and_needs_nothing_else(tmp_path, comparison):
    path, _ = write_report(tmp_path, "a.blend & Cycles", [comparison], FACTS)
    page = Page(path)
    for text in (
        "a.blend & Cycles",
        "Diffuse <Indirect>",
        f"{comparison.metrics['relmse']:.5f}",
        f"{comparison.metrics['bias']:+.2%}",
        "gather",
        "1.25",
        "1024",
        *FACTS["approximated"],
        *FACTS["warnings"],
    ):
        assert text in page.text
    assert page.tags.isdisjoint({"script", "link", "iframe"})
    assert not re.search(r"https?:", path.read_text(encoding="utf-8"))
    assert "color-scheme: light dark" in page.text


def test_pictures_are_what_they_say(tmp_path, comparison):
    page = Page(write_report(tmp_path, "T", [comparison], {})[0])
    ours, cycles, difference = (pixels_of(uri, tmp_path) for uri in page.pictures.values())
    assert ours.shape == (6, 9, 4)
    # Both at one exposure, so they are equal where the light is; what the mask leaves out is transparent.
    assert np.array_equal(ours[1:], cycles[1:])
    assert (ours[0, :-1, :3] >= cycles[0, :-1, :3]).all()
    assert (ours[..., 3] == np.where(comparison.mask, 255, 0)).all()
    assert (difference[1:, :-1, :3] == 255).all()
    assert (difference[0, :-1, 0] > difference[0, :-1, 2]).all()


def test_json_has_the_same_numbers(tmp_path, comparison):
    equal = Comparison(
        "Equal", comparison.ours, comparison.ours, None, metrics.measure(comparison.ours, comparison.ours)
    )
    page, path = write_report(tmp_path, "T", [comparison, equal], FACTS)
    document = json.loads(path.read_text(encoding="utf-8"), parse_constant=lambda name: pytest.fail(name))
    assert document["comparisons"]["Diffuse <Indirect>"]["relmse"] == comparison.metrics["relmse"]
    assert {key: document[key] for key in FACTS} == FACTS
    # JSON has no infinity; the page has.
    assert document["comparisons"]["Equal"]["psnr"] is None
    assert "∞" in Page(page).text


def test_a_new_report_replaces_the_old_one_whole_or_not_at_all(tmp_path, comparison):
    first = [path.read_bytes() for path in write_report(tmp_path, "First", [comparison], FACTS)]
    with pytest.raises(TypeError):
        write_report(tmp_path, "Second", [comparison], {"settings": {"device": object()}})
    assert [(tmp_path / name).read_bytes() for name in ("report.html", "report.json")] == first
    write_report(tmp_path, "Second", [], {})
    assert "Second" in Page(tmp_path / "report.html").text
    assert sorted(p.name for p in tmp_path.iterdir()) == ["report.html", "report.json"]
