# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a comparison with Cycles: one HTML page that carries its pictures, and the same numbers as JSON."""

import base64
import html
import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from ...gi_core import display, png

# What a number says, and how it is written; metrics without an entry are shown by their name.
METRICS = {
    "relmse": ("relMSE", "mean of (ours − Cycles)² / (Cycles² + 0.01); 0 is equal", "{:.5f}"),
    "bias": ("Bias", "how much too bright (+) or too dark (−) on the whole", "{:+.2%}"),
    "rmse": ("RMSE", "root of the mean square error, in the unit of the image", "{:.5f}"),
    "psnr": ("PSNR [dB]", "of the exposed sRGB pictures; higher is better", "{:.2f}"),
    "ssim": ("SSIM", "of the exposed sRGB pictures; 1 is equal", "{:.4f}"),
    "flip": ("FLIP", "the difference that an eye sees when pictures alternate; 0 is equal", "{:.4f}"),
}
STYLE = """
:root { color-scheme: light dark; }
body { font: 15px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.5rem; } h2 { font-size: 1.15rem; margin-top: 2.5rem; }
.pictures { display: grid; grid-template-columns: repeat(3, minmax(0, 1fr)); gap: .75rem; }
figure { margin: 0; }
img { width: 100%; display: block; image-rendering: pixelated; background: #8883; outline: 1px solid #8885; }
figcaption, small { color: color-mix(in srgb, CanvasText 65%, Canvas); }
table { border-collapse: collapse; margin: 1rem 0; }
th, td { text-align: left; font-weight: normal; padding: .25rem 1.5rem .25rem 0; border-bottom: 1px solid #8885; }
td { font-variant-numeric: tabular-nums; }
tfoot * { font-weight: 600; border: 0; }
"""


@dataclass(frozen=True)
class Comparison:
    """One image beside Cycles' of the same thing.

    ours, reference: (h, w, 3) float32 scene-linear. mask: (h, w) bool, the pixels that count; None means all.
    metrics: what `metrics.measure` gave.
    """

    name: str
    ours: np.ndarray
    reference: np.ndarray
    mask: np.ndarray | None
    metrics: dict[str, float]


def write_report(folder: Path, title: str, comparisons: list[Comparison], facts: dict) -> tuple[Path, Path]:
    """Write FOLDER/report.html and FOLDER/report.json, which replace earlier ones; their paths.

    facts: what else there is to tell. "stages" (name -> seconds), "settings" (name -> value), "reference" (how Cycles
        rendered, name -> value), "approximated" and "warnings" (sentences) have places of their own, the others make a
        table at the top. All must be what JSON can hold. Numbers that are not finite are null in JSON.
    """
    folder = Path(folder)
    page, numbers = folder / "report.html", folder / "report.json"
    measured = {c.name: c.metrics for c in comparisons}
    document = finite({"title": title, **facts, "comparisons": measured})
    _replace(numbers, json.dumps(document, indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    _replace(page, _page(title, comparisons, facts))
    return page, numbers


def _page(title, comparisons, facts):
    sections = ("stages", "settings", "reference", "approximated", "warnings")
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        _table({k: v for k, v in facts.items() if k not in sections}),
        *(_comparison(c) for c in comparisons),
        _stages(facts.get("stages", {})),
        _section("Settings", _table(facts.get("settings", {}))),
        _section("Reference", _table(facts.get("reference", {}))),
        _section("Approximated", _list(facts.get("approximated", ()))),
        _section("Warnings", _list(facts.get("warnings", ()))),
    ]
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>{html.escape(title)}</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        + "\n".join(filter(None, parts))
        + "\n</body>\n</html>\n"
    )


def _comparison(c):
    exposure = display.exposure_of(c.reference, c.mask)
    pictures = {
        "GI Bake": display.picture(c.ours, exposure, c.mask),
        "Cycles": display.picture(c.reference, exposure, c.mask),
        "Difference: red too bright, blue too dark": display.difference(c.ours, c.reference, exposure, c.mask),
    }
    figures = "\n".join(_figure(f"{c.name}, {caption}", caption, pixels) for caption, pixels in pictures.items())
    height, width = c.reference.shape[:2]
    note = f"{width} × {height} pixels, exposure × {exposure:.4g}; full red or blue is a quarter of white"
    if c.mask is not None:
        note += f"; {np.count_nonzero(c.mask)} pixels count, the others are transparent"
    rows = []
    for name, value in c.metrics.items():
        label, meaning, form = METRICS.get(name, (name, "", "{:.5g}"))
        rows.append(f"<tr><th>{label}</th><td>{_number(value, form)}</td><td><small>{meaning}</small></td></tr>")
    return _section(
        c.name,
        f'<div class="pictures">\n{figures}\n</div>\n<p><small>{note}</small></p>\n<table>{"".join(rows)}</table>',
    )


def _figure(alt, caption, pixels):
    data = base64.b64encode(png.encode(pixels)).decode()
    return (
        f'<figure><img alt="{html.escape(alt)}" src="data:image/png;base64,{data}">'
        f"<figcaption>{html.escape(caption)}</figcaption></figure>"
    )


def _stages(stages):
    if not stages:
        return ""
    rows = "".join(f"<tr><th>{html.escape(k)}</th><td>{v:.2f}</td></tr>" for k, v in stages.items())
    total = f"<tfoot><tr><th>Together</th><td>{sum(stages.values()):.2f}</td></tr></tfoot>"
    return _section("Time [s]", f"<table><tbody>{rows}</tbody>{total}</table>")


def _table(values):
    rows = (f"<tr><th>{html.escape(str(k))}</th><td>{html.escape(_text(v))}</td></tr>" for k, v in values.items())
    return f"<table>{''.join(rows)}</table>" if values else ""


def _list(sentences):
    items = (f"<li>{html.escape(s)}</li>" for s in sentences)
    return f"<ul>{''.join(items)}</ul>" if sentences else ""


def _section(title, content):
    return f"<h2>{html.escape(title)}</h2>\n{content}" if content else ""


def _text(value):
    if isinstance(value, (list, tuple)):
        return ", ".join(map(_text, value))
    return f"{value:.4g}" if isinstance(value, float) else str(value)


def _number(value, form):
    if math.isnan(value):
        return "–"
    return form.format(value) if math.isfinite(value) else ("∞" if value > 0 else "−∞")


def finite(value):
    """The same with None for the numbers that JSON has no way to write."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _replace(path, text):
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
