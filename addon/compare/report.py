# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The report of a comparison with Cycles: one HTML page that carries its pictures, and the same numbers as JSON."""

import base64
import html
import json
import math
from pathlib import Path

from ...gi_core import display, png
from . import pictures
from .plot import log_log
from .subject import Subject

# What a number says, and how it is written.
MEASURES = {
    "relmse": ("relMSE", "mean of (ours − Cycles)² / (Cycles² + 0.01); 0 is equal", "{:.5f}"),
    "relmse_all": ("relMSE, edges too", "the same with the pixels that the mask leaves out", "{:.5f}"),
    "rmse": ("RMSE", "root of the mean square error, in the unit of the image", "{:.5f}"),
    "bias": ("Bias", "how much too bright (+) or too dark (−) on the whole", "{:+.2%}"),
    "psnr": ("PSNR [dB]", "of the exposed sRGB pictures; higher is better", "{:.2f}"),
    "ssim": ("SSIM", "of the exposed sRGB pictures; 1 is equal", "{:.4f}"),
    "flip": ("FLIP", "the difference that an eye sees when pictures alternate; 0 is equal", "{:.4f}"),
    "leak": ("Leak", "light in the region marked as dark over Cycles' light elsewhere", "{:.3%}"),
}
KINDS = ("indirect", "direct", "combined", "glossy indirect", "glossy direct")
# Pictures of so many objects, those with the largest errors; a page with hundreds could not be opened.
MOST_PICTURES = 12
NOISE = "Cycles’ own noise"
_HERE = Path(__file__).parent


def write_report(
    folder: Path,
    title: str,
    subjects: list[Subject],
    techniques: dict[str, dict],
    reference: dict,
    about: dict,
    curves: dict[str, list[dict]] | None = None,
    ratios: list[dict] | None = None,
) -> tuple[Path, Path]:
    """Write FOLDER/report.html and FOLDER/report.json, which replace earlier ones; their paths.

    techniques: label -> "device", "seconds", "stages" (name -> seconds), "settings" (name -> value), "approximated" and
        "warnings" (sentences). reference: how Cycles rendered, name -> value. about: what else there is to tell.
    curves, ratios: what `curves.curves` and `curves.against_cycles` gave.
    All must be what JSON can hold. Numbers that are not finite are null in JSON.
    """
    folder = Path(folder)
    page, numbers = folder / "report.html", folder / "report.json"
    document = {
        "title": title, **about,
        "techniques": {
            label: {**told, "comparisons": {s.name: s.measures[label] for s in subjects}}
            for label, told in techniques.items()
        },
        "reference": {**reference, "noise": {s.name: s.floor for s in subjects}},
        "counted": {s.name: int(s.mask.sum()) for s in subjects},
        "curves": curves or {},
        "equal error and equal time": ratios or [],
    }  # fmt: skip
    _replace(numbers, json.dumps(finite(document), indent=2, ensure_ascii=False, allow_nan=False) + "\n")
    _replace(page, _page(title, subjects, techniques, reference, about, curves or {}, ratios or []))
    return page, numbers


def finite(value):
    """The same with None for the numbers that JSON has no way to write."""
    if isinstance(value, dict):
        return {k: finite(v) for k, v in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(v) for v in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def _page(title, subjects, techniques, reference, about, curves, ratios):
    kinds = [kind for kind in KINDS if any(s.kind == kind for s in subjects)]
    shown = {s.name for kind in kinds for s in _worst([s for s in subjects if s.kind == kind and s.flat])}
    noise = subjects[0].floor.get("relmse", 0.0) if subjects else 0.0
    parts = [
        f"<h1>{html.escape(title)}</h1>",
        _table(about),
        _controls(kinds) if subjects else "",
        *(_subject(s, s.name in shown) for s in subjects),
        _legend(),
        _section("Error over time", _curves(curves, ratios, noise)),
        _section("Time by stage [s]", _columns({k: v["stages"] for k, v in techniques.items()}, "{:.2f}", total=True)),
        _section("Reference", _table(reference)),
        _section("Settings", _columns({k: _settings(v) for k, v in techniques.items()}, "{}", "settings")),
        _section("Approximated", _sentences(techniques, "approximated")),
        _section("Warnings", _sentences(techniques, "warnings")),
    ]
    style, script = ((_HERE / name).read_text(encoding="utf-8") for name in ("page.css", "page.js"))
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<link rel="icon" href="data:,">\n<title>{html.escape(title)}</title>\n<style>\n{style}</style>\n</head>\n'
        "<body>\n"
        + "\n".join(filter(None, parts))
        + (f"\n<script>\n{script}</script>" if subjects else "")
        + "\n</body>\n</html>\n"
    )


def _controls(kinds):
    radios = "".join(
        f'<label><input type="radio" name="kind" value="{kind}"{" checked" if i == 0 else ""}> {kind}</label>'
        for i, kind in enumerate(kinds)
    )
    return (
        f'<div class="controls" hidden><fieldset aria-label="Light">{radios}</fieldset><label>Cycles '
        '<input type="range" id="wipe" min="0" max="100" value="50" step="any"> GI Bake</label></div>'
    )


def _subject(s, with_pictures):
    parts = [f"<h2>{html.escape(s.name)}</h2>", _measures(s)]
    if with_pictures:
        exposure = display.exposure_of(s.reference, s.mask)
        cycles = display.picture(s.reference, exposure, s.seen)
        for label, ours in s.ours.items():
            picture = display.picture(ours, exposure, s.seen)
            name = f"{s.name}, {label}"
            parts.append(f'<h3>{html.escape(label)}</h3>\n<div class="row">')
            parts.append(
                f'<figure><div class="wipe">{_image(cycles, f"{s.name}, Cycles")}'
                f"{_image(picture, name, 'ours')}</div>"
                f'<figcaption>{html.escape(label)}<span class="screen"> to the left, Cycles to the right</span>'
                "</figcaption></figure>"
            )
            parts.append(_figure(pictures.error(ours, s.reference, s.seen), f"{name}, error", "Relative error"))
            signed = display.difference(ours, s.reference, exposure, s.seen)
            parts.append(_figure(signed, f"{name}, signed", "Red too bright, blue too dark"))
            parts.append(_figure(pictures.flip(ours, s.reference, s.seen), f"{name}, FLIP", "FLIP"))
            parts.append("</div>")
        parts.append('<h3>Cycles</h3>\n<div class="row">')
        parts.append(_figure(cycles, f"{s.name}, reference", "Cycles"))
        noisy = pictures.error(s.reference + s.noise, s.reference, s.seen)
        parts.append(_figure(noisy, f"{s.name}, noise", "Its own noise, as relative error"))
        counted = pictures.counted(s.reference, exposure, s.mask, s.seen, s.dark)
        caption = "What counts; orange is left out" + (", blue is the region to be dark" if s.dark is not None else "")
        parts.append(_figure(counted, f"{s.name}, counted", caption))
        parts.append("</div>")
        height, width = s.mask.shape
        parts.append(
            f'<p class="soft">{width} × {height} pixels, {s.mask.sum()} count. Exposure × {exposure:.4g}: the 99th '
            "percentile of Cycles’ light is white, in sRGB; Blender’s view transform plays no part.</p>"
        )
    elif s.flat:
        parts.append(f'<p class="soft">Pictures are of the {MOST_PICTURES} with the largest errors.</p>')
    return f'<section data-kind="{s.kind}">\n' + "\n".join(parts) + "\n</section>"


def _measures(s):
    names = [n for n in MEASURES if n in s.floor]
    head = "".join(f'<th title="{html.escape(MEASURES[n][1])}">{MEASURES[n][0]}</th>' for n in names)
    rows, doubtful = [], False
    for label, values in s.measures.items():
        cells = []
        for n in names:
            mark = "†" if n == "relmse" and values[n] <= 2 * s.floor[n] else ""
            doubtful |= bool(mark)
            cells.append(f"<td>{_number(values[n], MEASURES[n][2])}{mark}</td>")
        rows.append(f"<tr><th>{html.escape(label)}</th>{''.join(cells)}</tr>")
    floor = "".join(f"<td>{_number(s.floor[n], MEASURES[n][2])}</td>" for n in names)
    rows.append(f'<tr class="floor"><th>{NOISE}</th>{floor}</tr>')
    note = (
        '<p class="soft">† No more than twice the noise of the reference itself: more samples of Cycles are needed to '
        "tell how far off it is.</p>"
        if doubtful
        else ""
    )
    return (
        f'<div class="wide"><table><thead><tr><th></th>{head}</tr></thead><tbody>{"".join(rows)}</tbody></table></div>'
        + note
    )


def _worst(subjects):
    order = sorted(subjects, key=lambda s: -max(m["relmse"] for m in s.measures.values()))
    return order[:MOST_PICTURES]


def _legend():
    ticks = (0.01, 0.03, 0.1, 0.3, 1.0)
    span = math.log(pictures.HIGH / pictures.LOW)
    error = _scale(
        [(math.log(t / pictures.LOW) / span, f"{t:.0%}") for t in ticks],
        [_hex(pictures.magma(i / 16)) for i in range(17)],
    )
    flip = _scale([(t, f"{t:g}") for t in (0, 0.25, 0.5, 0.75, 1)], [_hex(pictures.magma(i / 16)) for i in range(17)])
    signed = _scale(
        [(0, f"−{pictures.SIGNED:.0%} of white"), (0.5, "0"), (1, f"+{pictures.SIGNED:.0%}")],
        ["#0d40d9", "#ffffff", "#cc1a0d"],
    )
    rows = "".join(
        f"<tr><th>{html.escape(MEASURES[n][0])}</th><td>{html.escape(MEASURES[n][1])}</td></tr>" for n in MEASURES
    )
    return (
        "<h2>Scales</h2>\n"
        f'<div class="row"><figure>{error}<figcaption>Relative error of a pixel: the root of its share of relMSE'
        f"</figcaption></figure><figure>{signed}<figcaption>Signed difference of luminance</figcaption></figure>"
        f"<figure>{flip}<figcaption>FLIP</figcaption></figure></div>\n<table>{rows}<tr><th>{NOISE}</th><td>the "
        "reference is the mean of two renders; one of them is measured against it, which is as far from it as it is "
        "from the truth; SSIM and FLIP compare structure, of which a noisy picture has its own</td></tr></table>"
    )


def _scale(ticks, colors):
    stops = "".join(f'<stop offset="{i / (len(colors) - 1):.4f}" stop-color="{c}"/>' for i, c in enumerate(colors))
    name = f"from-{colors[0][1:]}"
    texts = "".join(
        f'<text x="{4 + 292 * place:.1f}" y="30" text-anchor="{_anchor(place)}">{html.escape(text)}</text>'
        for place, text in ticks
    )
    return (
        f'<svg class="scale" viewBox="0 0 300 34" preserveAspectRatio="none"><defs><linearGradient id="{name}">{stops}'
        f'</linearGradient></defs><rect x="4" y="2" width="292" height="14" fill="url(#{name})"/>{texts}</svg>'
    )


def _anchor(place):
    return "start" if place < 0.02 else "end" if place > 0.98 else "middle"


def _hex(rgb):
    return "#" + "".join(f"{round(255 * float(c)):02x}" for c in rgb)


def _curves(curves, ratios, noise):
    if not curves:
        return ""
    series = {
        label: [
            (r["seconds"], r["relmse"], f"{r['budget']}, {r['seconds']:.2f} s, relMSE {r['relmse']:.5f}") for r in rows
        ]
        for label, rows in curves.items()
    }
    drawn = {label: [p for p in rows if p[1] > 0] for label, rows in series.items()}
    sentences = []
    for r in ratios:
        faster = _times(r["times faster"], "faster", "slower") or "none of its pictures is so near"
        better = _times(r["times better"], "nearer", "farther off") or "all its pictures took longer, or less"
        name, error = f"{r['technique']}, {r['budget']}", f"{r['relmse']:.5f}" + "†" * r["doubtful"]
        cells = (f"{r['seconds']:.2f}", error, r["against"], faster, better)
        sentences.append(
            f"<tr><th>{html.escape(name)}</th>" + "".join(f"<td>{html.escape(cell)}</td>" for cell in cells) + "</tr>"
        )
    table = (
        "<thead><tr><th>Best picture</th><th>Seconds</th><th>relMSE less noise</th><th>Against</th>"
        f"<th>At equal error</th><th>At equal time</th></tr></thead><tbody>{''.join(sentences)}</tbody>"
    )
    return (
        log_log({k: v for k, v in drawn.items() if v}, "seconds of everything", "relMSE of indirect light", noise)
        + f'<div class="wide"><table>{table}</table></div>'
        '<p class="soft">All on this machine, one after the other. Cycles’ picture is denoised as ours is: the pass '
        "that is measured, with its albedo and normal as guides. The reference’s noise is taken off each error in the "
        "table; † where most of what was measured is that noise, so that ratios say little.</p>"
    )


def _times(ratio, more, less):
    if ratio is None:
        return ""
    return f"{ratio:.3g} × {more}" if ratio >= 1 else f"{1 / ratio:.3g} × {less}"


def _settings(told):
    """What was asked for, and the device that `auto` took."""
    return told["settings"] | {"device": told["device"]}


def _columns(tables, form, style="", total=False):
    """Rows of all tables beside each other."""
    names = list(dict.fromkeys(name for table in tables.values() for name in table))
    if not names:
        return ""
    head = "".join(f"<th>{html.escape(label)}</th>" for label in tables)

    def cells(values):
        return "".join("<td></td>" if v is None else f"<td>{html.escape(form.format(v))}</td>" for v in values)

    rows = "".join(
        f"<tr><th>{html.escape(name)}</th>{cells([t.get(name) for t in tables.values()])}</tr>" for name in names
    )
    foot = ""
    if total:
        foot = f"<tfoot><tr><th>together</th>{cells([sum(t.values()) for t in tables.values()])}</tr></tfoot>"
    table = f"<table><thead><tr><th></th>{head}</tr></thead><tbody>{rows}</tbody>{foot}</table>"
    return f'<div class="{" ".join(filter(None, ("wide", style)))}">{table}</div>'


def _sentences(techniques, name):
    """Each sentence once, with the techniques that it is about where it is not about all."""
    about = {}
    for label, told in techniques.items():
        for sentence in told[name]:
            about.setdefault(sentence, []).append(label)
    items = []
    for sentence, labels in about.items():
        prefix = "" if len(labels) == len(techniques) else f"{', '.join(labels)}: "
        items.append(f"<li>{html.escape(prefix + sentence)}</li>")
    return f"<ul>{''.join(items)}</ul>" if items else ""


def _figure(pixels, alt, caption):
    return f"<figure>{_image(pixels, alt)}<figcaption>{html.escape(caption)}</figcaption></figure>"


def _image(pixels, alt, style="whole"):
    data = base64.b64encode(png.encode(pixels)).decode()
    return f'<img class="{style}" alt="{html.escape(alt)}" src="data:image/png;base64,{data}">'


def _table(values):
    rows = (f"<tr><th>{html.escape(str(k))}</th><td>{html.escape(_text(v))}</td></tr>" for k, v in values.items())
    return f"<table>{''.join(rows)}</table>" if values else ""


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


def _replace(path, text):
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_text(text, encoding="utf-8")
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)
