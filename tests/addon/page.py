# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A report's page as its readers have it: parsed, run in a browser, or its script run where there is no browser."""

import base64
import html
import json
import re
import shutil
import subprocess
import tempfile
from html.parser import HTMLParser
from pathlib import Path

import bpy
import numpy as np

BROWSER = next((b for name in ("chromium", "google-chrome", "chrome") if (b := shutil.which(name))), None)
VOID = {"meta", "link", "img", "input"}


class Page(HTMLParser):
    """The text, the pictures and the tags of a page; fails where tags do not match."""

    def __init__(self, path):
        super().__init__()
        self.text, self.pictures, self.open, self.tags, self.script = "", {}, [], [], ""
        self.feed(path.read_text(encoding="utf-8"))
        self.close()
        assert self.open == []

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        if tag == "img":
            self.pictures.setdefault(dict(attrs)["alt"], dict(attrs)["src"])
        if tag not in VOID:
            self.open.append(tag)

    def handle_startendtag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))

    def handle_endtag(self, tag):
        assert self.open.pop() == tag

    def handle_data(self, data):
        if self.open and self.open[-1] == "script":
            self.script += data
        else:
            self.text += data


def pixels_of(uri):
    """What Blender sees in a picture: (h, w, 4) int, 0…255."""
    kind, data = uri.split(",")
    assert kind == "data:image/png;base64"
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "picture.png"
        path.write_bytes(base64.b64decode(data))
        image = bpy.data.images.load(str(path))
        image.alpha_mode = "CHANNEL_PACKED"
        pixels = np.empty((image.size[1], image.size[0], 4), np.float32)
        image.pixels.foreach_get(pixels.ravel())
        bpy.data.images.remove(image)
    return np.rint(pixels * 255).astype(int)


# What the browser, or what stands in for it, does: each light in turn, the slider, a pointer on a picture.
STEPS = """
const found = {shown: {}, errors: errors};
const style = document.documentElement.style;
const kinds = () => sections.filter(s => !s.hidden).map(s => s.dataset.kind);
found.first = kinds();
for (const radio of document.querySelectorAll("input[name=kind]")) {
  radio.checked = true; radio.dispatchEvent(new Event("change"));
  found.shown[radio.value] = kinds();
}
const range = document.querySelector("#wipe");
range.value = 20; range.dispatchEvent(new Event("input"));
found.slider = style.getPropertyValue("--wipe");
const picture = [...document.querySelectorAll(".wipe")].find(p => p.getBoundingClientRect().width > 0);
const box = picture.getBoundingClientRect();
const pointer = (kind, share, buttons) => picture.dispatchEvent(
  new PointerEvent(kind, {clientX: box.left + share * box.width, buttons}));
pointer("pointerdown", 0.75, 1); found.pressed = style.getPropertyValue("--wipe");
pointer("pointermove", 0.1, 0); found.moved = style.getPropertyValue("--wipe");
pointer("pointermove", 2, 1); found.dragged = style.getPropertyValue("--wipe"); found.value = Number(range.value);
found.controls = !document.querySelector(".controls").hidden;
"""


def in_browser(path, folder):
    """What the steps find in a real browser, and the lines of its console."""
    page = path.read_text(encoding="utf-8")
    listen = "<script>const errors = []; addEventListener('error', e => errors.push(String(e.message)));</script>"
    clip = (
        'found.clip = getComputedStyle(document.querySelector(".ours")).clipPath;'
        "document.documentElement.dataset.found = JSON.stringify(found);"
    )
    steps = f"<script>{STEPS}{clip}</script>"
    copy = folder / "driven.html"
    copy.write_text(page.replace("<body>", f"<body>{listen}").replace("</body>", f"{steps}</body>"), encoding="utf-8")
    done = subprocess.run(
        [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}",
         "--enable-logging=stderr", "--window-size=1200,900", "--dump-dom", copy.resolve().as_uri()],
        capture_output=True, text=True, timeout=120,
    )  # fmt: skip
    console = [line for line in done.stderr.splitlines() if "CONSOLE" in line]
    _, _, found = done.stdout.partition('data-found="')
    assert found, done.stderr[-2000:]
    return json.loads(html.unescape(found.partition('"')[0])), console


def driven(path, folder):
    """What the steps find, in a browser where there is one; no line may stand in its console."""
    if BROWSER is None:
        return without_browser(Page(path))
    found, console = in_browser(path, folder)
    assert console == []
    return found


def pages_of_paper(path, folder):
    """How many a browser prints the page on."""
    pdf = folder / "printed.pdf"
    subprocess.run(
        [BROWSER, "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={folder / 'profile'}",
         f"--print-to-pdf={pdf}", path.resolve().as_uri()],
        capture_output=True, timeout=120, check=True,
    )  # fmt: skip
    return len(re.findall(rb"/Type\s*/Page\b", pdf.read_bytes()))


# As much of a document as the page's script touches.
_DOCUMENT = """
class Event { constructor(type, more) { Object.assign(this, more); this.type = type; } preventDefault() {} }
const PointerEvent = Event;
class Element {
  constructor(about) { Object.assign(this, about); this.heard = {}; this.hidden = "hidden" in about; }
  addEventListener(type, f) { (this.heard[type] ??= []).push(f); }
  dispatchEvent(event) { for (const f of this.heard[event.type] ?? []) f(event); }
  getBoundingClientRect() { return {left: 10, width: 200}; }
}
const errors = [];
const elements = ABOUT.map(about => new Element(about));
const properties = {};
const matches = {
  ".controls": e => e.class === "controls", "section[data-kind]": e => e.tag === "section",
  "#wipe": e => e.id === "wipe", "input[name=kind]": e => e.name === "kind", ".wipe": e => e.class === "wipe",
};
const document = {
  querySelectorAll: s => elements.filter(matches[s]), querySelector: s => elements.find(matches[s]),
  documentElement: {style: {setProperty: (k, v) => { properties[k] = v; }, getPropertyValue: k => properties[k]}},
};
"""


def without_browser(page):
    """What the steps find when a JavaScript engine runs the page's script on a stand-in for its document."""
    from py_mini_racer import MiniRacer

    about = []
    for tag, attributes in page.tags:
        about.append({**attributes, "tag": tag, "dataset": {"kind": attributes.get("data-kind")}})
        about[-1]["checked"] = "checked" in attributes
    document = _DOCUMENT.replace("ABOUT", json.dumps(about))
    return json.loads(MiniRacer().eval(f"{document}{page.script}{STEPS}; JSON.stringify(found)"))
