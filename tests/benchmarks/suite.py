# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole benchmark: one table in Markdown, the same as JSON, an earlier run's beside it where one is named.

    python tests/benchmarks/suite.py [--quick] [--output out/bench] [--previous out/bench/bench.json] [--only WORD]

Every sample scene with each technique for each target against Cycles, Cycles' own curve, reading scenes, rays, kernels,
and how time grows with triangles, texels, lamps and cells. `--quick` takes small pictures and few samples of all of it.
"""

import argparse
import json
import os
import subprocess
import sys
import time
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from gi_bake.addon.compare.curves import error_at, time_at
from gi_bake.addon.compare.machine import processor, version
from gi_bake.gi_core.techniques import METHODS

HERE = Path(__file__).resolve().parent
SCENES = ("cornell", "sunlit_room", "thin_wall", "corridor", "emissive", "props", "pan", "materials")
FULL = {
    "side": 256, "texels": 64, "reference": 1024, "settings": {},
    "triangles": (10_000, 100_000, 1_000_000, 10_000_000), "texel counts": (64, 256, 1024, 4096),
    "lights": (1, 4, 16, 64, 256), "cells": (16, 32, 64, 128), "cycles": (1, 4, 16, 64, 256),
}  # fmt: skip
QUICK = {
    "side": 32, "texels": 16, "reference": 32,
    "settings": {"samples": 8, "light_samples": 8, "map_resolution": 64, "cells": 16, "cascades": 2, "frames": 2,
                 "probe_cells": 4, "probe_rays": 64},
    "triangles": (10_000, 100_000, 1_000_000), "texel counts": (64, 128, 256), "lights": (1, 4, 16),
    "cells": (16, 32, 64), "cycles": (1, 8),
}  # fmt: skip
# Measure -> how it is written. The order is the table's.
COLUMNS = {
    "seconds": "{:.3g}", "memory [MB]": "{:.0f}", "relMSE": "{:.5f}", "noise": "{:.5f}", "bias": "{:+.1%}",
    "Cycles, OIDN, same error": "{}", "Cycles, OIDN, same time": "{}", "triangles": "{}", "calls": "{}",
    "one core [Mrays/s]": "{:.2f}", "all cores [Mrays/s]": "{:.2f}",
}  # fmt: skip


def run(case: str, **arguments) -> dict[str, dict]:
    """The rows of a case; one row that tells the error where it failed."""
    command = [sys.executable, str(HERE / "cases.py"), case, json.dumps(arguments)]
    done = subprocess.run(command, capture_output=True, text=True)
    if done.returncode:
        words = (done.stderr.strip().splitlines() or ["no output"])[-1]
        named = [str(arguments[k]) for k in ("name", "method", "count") if k in arguments]
        return {" ".join([case, *named]): {"failed": words}}
    # Blender may say something about its memory as it ends.
    return json.JSONDecoder().raw_decode(done.stdout)[0]


def exponent(rows: dict[int, float]) -> float:
    """p of seconds ~ nᵖ over the larger half, where what does not grow weighs least."""
    points = sorted(rows.items())[-max(2, -(-len(rows) // 2)) :]
    x, y = np.log(np.array(points)).T
    return float(np.polyfit(x, y, 1)[0])


def measured(plan: dict, folder: Path, only: str, tell) -> tuple[dict, dict]:
    """Rows by name, and exponents by what grows."""
    rows, exponents = {}, {}

    def add(case, **arguments):
        if only not in f"{case} {arguments.get('name', '')}":
            return {}
        begin = time.perf_counter()
        found = run(case, **arguments)
        rows.update(found)
        tell(f"{case} {arguments.get('name', arguments.get('count', ''))}: {time.perf_counter() - begin:.0f} s")
        return found

    kept = str(folder / "references")
    common = {"side": plan["side"], "reference": plan["reference"], "settings": plan["settings"], "folder": kept}
    for name in SCENES:
        ours = {}
        for method in METHODS:
            ours |= add("sample", name=name, method=method, texels=plan["texels"], **common)
        theirs = add("cycles", name=name, counts=plan["cycles"], **common)
        against(ours, theirs)
        add("reading", name=name)
    add("rays")
    add("of_kernels", side=plan["side"], settings=plan["settings"])
    for case in ("triangles", "texels", "lights", "cells"):
        grown = {}
        for count in plan["texel counts" if case == "texels" else case]:
            for i, row in enumerate(add(case, count=count).values()):
                if "seconds" in row:
                    # Along a side there are so many; how many there are in all is what time grows with.
                    grown.setdefault(i, {})[count ** {"texels": 2, "cells": 3}.get(case, 1)] = row["seconds"]
        labels = {"triangles": ("trees by triangles", "rays by triangles")}.get(case, (f"time by {case}",))
        for i, found in grown.items():
            if len(found) > 1:
                exponents[labels[i]] = exponent(found)
    return rows, exponents


def against(ours: dict, theirs: dict):
    """Puts into rows of camera images how denoised Cycles does in the same time and for the same error."""
    curve = [
        {"seconds": r["seconds"], "relmse": max(r["relMSE"] - r["noise"], 1e-9)}
        for name, r in theirs.items() if "OIDN" in name
    ]  # fmt: skip
    for name, row in ours.items():
        if curve and " image " in name and "relMSE" in row:
            own = row["relMSE"] - row["noise"]
            if own < row["noise"]:
                row["Cycles, OIDN, same error"] = row["Cycles, OIDN, same time"] = "within noise"
                continue
            there, then = time_at(curve, own), error_at(curve, row["seconds"])
            row["Cycles, OIDN, same error"] = f"{there:.3g} s" if there else "not reached"
            row["Cycles, OIDN, same time"] = f"{then:.5f}" if then else "no picture"


def table(rows: dict[str, dict], exponents: dict, about: dict, before: dict | None) -> str:
    """All of it as Markdown. before: an earlier document."""
    columns = [c for c in COLUMNS if any(c in row for row in rows.values())]
    earlier = before["rows"] if before else {}
    head = ["", *columns, *(["seconds before", "relMSE before"] if before else []), "remark"]
    lines = [f"{k}: {v}  " for k, v in about.items()]
    if before:
        lines.append(f"before: {before['about']['date']}, {before['about']['version']}, {before['about']['command']}  ")
    lines += ["", "| " + " | ".join(head) + " |", "|" + "---|" * len(head)]

    def cell(row, column):
        return COLUMNS[column].format(row[column]) if column in row else ""

    for name, row in rows.items():
        cells = [cell(row, c) for c in columns]
        cells += [cell(earlier.get(name, {}), c) for c in ("seconds", "relMSE")] if before else []
        remark = row.get("failed") or row.get("refused") or ""
        lines.append("| " + " | ".join([name, *cells, remark.replace("|", "/")]) + " |")
    if exponents:
        titles = ["", "exponent", *(["before"] if before else [])]
        lines += ["", "| " + " | ".join(titles) + " |", "|" + "---|" * len(titles)]
    for name, value in exponents.items():
        then = before["exponents"].get(name) if before else None
        more = [f"{then:.2f}" if then is not None else ""] if before else []
        lines.append("| " + " | ".join([name, f"{value:.2f}", *more]) + " |")
    return "\n".join(lines) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--output", type=Path, default=Path("out/bench"))
    parser.add_argument("--previous", type=Path, help="bench.json of an earlier run, shown beside")
    parser.add_argument("--only", default="", help="cases whose name holds this")
    a = parser.parse_args()
    before = json.loads(a.previous.read_text()) if a.previous else None
    a.output.mkdir(parents=True, exist_ok=True)
    begin = time.perf_counter()
    rows, exponents = measured(QUICK if a.quick else FULL, a.output, a.only, lambda t: os.write(2, f"{t}\n".encode()))
    about = {
        "machine": f"{processor()}, {os.cpu_count()} cores", "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "version": f"GI Bake {version()}", "command": "make bench" + (" QUICK=1" if a.quick else ""),
        "seconds": round(time.perf_counter() - begin),
    }  # fmt: skip
    document = {"about": about, "rows": rows, "exponents": exponents}
    (a.output / "bench.json").write_text(json.dumps(document, indent=1))
    text = table(rows, exponents, about, before)
    (a.output / "bench.md").write_text(text, encoding="utf-8")
    os.write(1, text.encode())
    # What a technique cannot do is told as such; what broke is an error.
    sys.exit(any("failed" in row for row in rows.values()))


if __name__ == "__main__":
    main()
