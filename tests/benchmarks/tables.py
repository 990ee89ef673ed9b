# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's numbers as Markdown."""

from pathlib import Path

# Title -> the cases whose rows stand there. The order is the file's.
TITLES = {
    "Samples": ("sample",),
    "Cycles’ camera images": ("cycles",),
    "A camera image at four bounces, both denoised": ("camera",),
    "Convergence of camera images, no denoiser, without the reference’s noise": ("convergence",),
    "Many lightmaps, both denoised": ("lightmaps",),
    "Reading scenes": ("reading",),
    "Rays": ("rays",),
    "Kernels": ("of_kernels",),
    "Growth": ("triangles", "texels", "lights", "cells"),
}
# Measure -> how it is written. The order is the tables'.
COLUMNS = {
    "seconds": "{:.3g}", "processor [s]": "{:.3g}", "memory [MB]": "{:.0f}", "relMSE": "{:.5f}", "noise": "{:.5f}",
    "bias": "{:+.1%}", "Cycles, same error": "{:.3g} s", "Cycles, same time": "{:.3g}", "triangles": "{}",
    "p of relMSE ~ Nᵖ": "{:.2f}", "Cycles, seconds / ours": "{:.1f}",
    "calls": "{}", "one core [Mrays/s]": "{:.2f}", "all cores [Mrays/s]": "{:.2f}",
}  # fmt: skip
BEFORE = ("seconds", "relMSE")
BEGIN, END = "<!-- tables of make bench -->", "<!-- end of tables -->"


def document_as_markdown(document: dict, before: dict | None = None) -> str:
    """About, who is sooner, a table for each kind of case, exponents. before: an earlier document, shown beside."""
    about, rows = document["about"], document["rows"]
    lines = [f"{k}: {v}  " for k, v in about.items() if k != "sizes"]
    if before:
        lines.append(f"before: {before['about']['date']}, {before['about']['version']}, {before['about']['command']}  ")
    lines += ["", *_sooner(rows)]
    earlier = before["rows"] if before else None
    for title, cases in TITLES.items():
        part = {name: row for name, row in rows.items() if row["case"] in cases}
        if part:
            lines += ["", f"### {title}", "", *_table(part, earlier)]
    if exponents := document["exponents"]:
        then = before["exponents"] if before else {}
        cells = [
            [k, f"{v:.2f}", *([f"{then[k]:.2f}" if k in then else ""] if before else [])] for k, v in exponents.items()
        ]
        lines += ["", *_grid(["p of seconds ~ nᵖ", "", *(["before"] if before else [])], cells)]
    return "\n".join(lines) + "\n"


def put_between_markers(file: Path, text: str):
    """Replaces what stands between BEGIN and END. Raises ValueError where the file has no such place."""
    whole = file.read_text(encoding="utf-8")
    head, begin, rest = whole.partition(BEGIN)
    _, end, tail = rest.partition(END)
    if not begin or not end:
        raise ValueError(f"{file} has no place for tables: put the lines '{BEGIN}' and '{END}' into it")
    file.write_text(f"{head}{BEGIN}\n\n{text}\n{END}{tail}", encoding="utf-8")


def _sooner(rows):
    """Who is sooner at the same error, target by target, as lines."""
    lines = []
    for target in ("image", "lightmap", "vertices"):
        ours, theirs, unknown = [], [], 0
        for name, row in rows.items():
            if row["case"] != "sample" or name.split()[1] != target or "Cycles, same error" not in row:
                continue
            there = row["Cycles, same error"]
            label = name.replace(f" {target}", "")
            if there == "within noise":
                unknown += 1
            elif there == "not reached" or there > row["seconds"]:
                ours.append(label if there == "not reached" else f"{label} ({there / row['seconds']:.2g} ×)")
            else:
                theirs.append(f"{label} ({row['seconds'] / there:.2g} ×)")
        if ours or theirs or unknown:
            lines.append(
                f"- {target}: GI Bake is sooner at the same error in {len(ours)}: {', '.join(ours) or 'none'}; "
                f"**Cycles is sooner in {len(theirs)}**: {', '.join(theirs) or 'none'}; "
                f"{unknown} are within the reference's noise"
            )
    return lines


def _table(rows, earlier):
    columns = [c for c in COLUMNS if any(c in row for row in rows.values())]
    then = [c for c in BEFORE if earlier is not None and any(c in earlier.get(name, {}) for name in rows)]
    remarks = any("failed" in row or "refused" in row for row in rows.values())
    head = ["", *columns, *(f"{c} before" for c in then), *(["remark"] if remarks else [])]
    cells = []
    for name, row in rows.items():
        line = [name, *(_cell(row, c) for c in columns), *(_cell(earlier.get(name, {}), c) for c in then)]
        remark = f"failed: {row['failed']}" if "failed" in row else row.get("refused", "")
        cells.append([*line, *([remark.replace("|", "/")] if remarks else [])])
    return _grid(head, cells)


def _cell(row, column):
    value = row.get(column, "")
    return value if isinstance(value, str) else COLUMNS[column].format(value)


def _grid(head, rows):
    return ["| " + " | ".join(head) + " |", "|" + "---|" * len(head), *("| " + " | ".join(r) + " |" for r in rows)]
