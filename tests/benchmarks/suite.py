# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The whole benchmark: tables in Markdown, the same as JSON, an earlier run's beside it where one is named.

    python tests/benchmarks/suite.py [--quick] [--output FOLDER] [--previous bench.json] [--only WORD] [--readme FILE]

Every sample scene with each technique for each target against Cycles, Cycles' own curve, RSM's camera image beside it,
how RSM's error falls with samples, many lightmaps beside Cycles' bakes, reading scenes, rays, kernels,
and how time grows with triangles, texels, lamps and cells. `--quick` takes small pictures and few samples of all of it.
Both files are written anew after each case; a case that fails says so in its row.
"""

import argparse
import importlib.metadata
import json
import os
import shutil
import sys
import time
from collections.abc import Iterator
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
from gi_bake.addon.compare.curves import error_at, time_at
from gi_bake.addon.compare.machine import processor, version
from gi_bake.gi_core.techniques import METHODS
from gi_bake.tests.benchmarks.tables import document_as_markdown, put_between_markers
from gi_bake.tests.benchmarks.worker import Worker

HERE = Path(__file__).resolve().parent
SCENES = ("cornell", "sunlit_room", "thin_wall", "corridor", "emissive", "props", "pan", "materials")
FULL = {
    "limit": 600, "side": 128, "texels": 64, "objects": 6, "settings": {},
    "reference": {"image": 1024, "lightmap": 256, "vertices": 256}, "cycles": (1, 4, 16, 64, 256),
    "camera": {"side": 256, "bounces": 4, "counts": (4, 8, 16, 64), "reference": 1024, "runs": 2},
    "convergence": {"side": 64, "reference": 4096, "counts": (16, 64, 256, 1024)},
    "lightmaps": {"name": "props", "side": 64, "cycles_samples": 4, "samples": 4, "interpolation": 1, "objects": 60,
                  "reference": 6},
    "triangles": (10_000, 100_000, 1_000_000, 10_000_000), "texel counts": (64, 256, 1024, 4096),
    "lights": (1, 4, 16, 64, 256), "cells": (16, 32, 64, 128),
}  # fmt: skip
QUICK = {
    "limit": 120, "side": 32, "texels": 16, "objects": 3,
    "settings": {"samples": 8, "light_samples": 8, "map_resolution": 64, "cells": 16, "cascades": 1, "frames": 2,
                 "probe_cells": 4, "probe_rays": 64},
    "reference": {"image": 32, "lightmap": 32, "vertices": 32}, "cycles": (1, 8),
    "camera": {"side": 32, "bounces": 4, "counts": (4, 8), "reference": 32, "runs": 1},
    "convergence": {"side": 32, "reference": 32, "counts": (16, 64)},
    "lightmaps": {"name": "cornell", "side": 16, "cycles_samples": 4, "samples": 4, "interpolation": 1, "objects": 3,
                  "reference": 1},
    "triangles": (10_000, 100_000, 1_000_000), "texel counts": (64, 128, 256), "lights": (1, 4, 16),
    "cells": (16, 32, 64),
}  # fmt: skip
# What grows, by the rows of its case in their order; a side's count is of one of so many dimensions.
GROWING = {
    "triangles": (("trees by triangles", "rays by triangles"), 1),
    "texels": (("time by texels",), 2),
    "lights": (("time by lights",), 1),
    "cells": (("time by cells",), 3),
}


def plan_of(sizes: dict, folder: Path) -> Iterator[list[tuple[str, dict]]]:
    """Cases with their arguments, in groups that have a process each."""
    common = {"folder": str(folder), **{k: sizes[k] for k in ("side", "reference", "settings")}}
    for name in SCENES:
        asked = {"texels": sizes["texels"], "objects": sizes["objects"], "name": name, **common}
        yield [
            ("reading", {"name": name}),
            *(
                ("sample", {**asked, "method": method, "target": target})
                for method in METHODS
                for target in ("image", "lightmap", "vertices", *(["volume"] if method == "lpv" else []))
            ),
            ("cycles", {"name": name, "counts": sizes["cycles"], **common}),
        ]
    yield [("camera", {"name": "cornell", **sizes["camera"]})]
    yield [("convergence", {"name": name, **sizes["convergence"]}) for name in ("cornell", "sunlit_room", "emissive")]
    yield [("lightmaps", sizes["lightmaps"])]
    yield [("rays", {})]
    yield [("of_kernels", {k: sizes[k] for k in ("side", "settings")})]
    for case in GROWING:
        yield [(case, {"count": n}) for n in sizes["texel counts" if case == "texels" else case]]


def name_of(case: str, arguments: dict) -> str:
    """A case in words, which is the row of one that fails."""
    return " ".join([case, *(str(arguments[k]) for k in ("name", "target", "method", "count") if k in arguments)])


def measured(plan: list, limit: float, tell) -> Iterator[tuple[str, dict, dict[str, dict]]]:
    """Case, arguments and rows, one after the other."""
    whole, done = sum(map(len, plan)), 0
    for group in plan:
        with Worker([sys.executable, str(HERE / "cases.py")], limit) as worker:
            for case, arguments in group:
                begin = time.perf_counter()
                rows = worker.ask(case, arguments)
                if "failed" in rows:
                    rows = {name_of(case, arguments): rows}
                done += 1
                failed = "; ".join(row["failed"] for row in rows.values() if "failed" in row)
                seconds = time.perf_counter() - begin
                tell(f"[{done}/{whole}] {name_of(case, arguments)}: {seconds:.1f} s {failed}")
                yield case, arguments, {name: {"case": case, **row} for name, row in rows.items()}


def exponents(found: list[tuple[str, dict, dict[str, dict]]]) -> dict[str, float]:
    """What grows -> p of seconds ~ nᵖ, over the larger half, where what does not grow weighs least."""
    grown = {}
    for case, arguments, rows in found:
        labels, dimensions = GROWING.get(case, ((), 1))
        for label, row in zip(labels, rows.values()):
            if "seconds" in row:
                grown.setdefault(label, {})[arguments["count"] ** dimensions] = row["seconds"]
    return {label: exponent(times) for label, times in grown.items() if len(times) > 1}


def exponent(times: dict[int, float]) -> float:
    """p of seconds ~ nᵖ by count -> seconds."""
    points = sorted(times.items())[-max(2, -(-len(times) // 2)) :]
    x, y = np.log(np.array(points)).T
    return float(np.polyfit(x, y, 1)[0])


def against_cycles(rows: dict[str, dict]):
    """Puts into rows how Cycles does for the same error and in the same time.

    Of camera images it is denoised Cycles, by its curve. Of lightmaps and vertices it is Cycles as it bakes: by its
    first sample and by the reference, two renders whose error falls as one over their samples.
    """
    for name, row in rows.items():
        if "relMSE" not in row or row["case"] != "sample":
            continue
        scene, target = name.split()[:2]
        own, noise = row["relMSE"] - row["noise"], row["noise"]
        # Noise is known to some hundredths of itself; of what is left of the error, that may be all.
        if own <= noise / 4:
            row["Cycles, same error"] = "within noise"
        elif target == "image":
            curve = [
                {"seconds": r["seconds"], "relmse": max(r["relMSE"] - r["noise"], 1e-9)}
                for other, r in rows.items() if other.startswith(f"{scene} image Cycles, OIDN") and "relMSE" in r
            ]  # fmt: skip
            if curve:
                row["Cycles, same error"] = time_at(curve, own) or "not reached"
                last = max(curve, key=lambda r: r["seconds"])
                begun = row["seconds"] < last["seconds"]
                then = error_at(curve, row["seconds"]) if begun else last["relmse"]
                row["Cycles, same time"] = then or "no picture"
        else:
            first, samples = row["Cycles' first sample"], row["Cycles' samples"]
            each = max(row["Cycles' seconds"] - 2 * first, 1e-9) / samples
            row["Cycles, same error"] = first + each * max(samples * noise / own - 1, 0)
            made = 1 + (row["seconds"] - first) / each
            row["Cycles, same time"] = noise * samples / made if made >= 1 else "no picture"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--output", type=Path, default=Path("out/bench"))
    parser.add_argument("--previous", type=Path, help="bench.json of an earlier run, shown beside")
    parser.add_argument("--only", default="", help="cases whose name holds this")
    parser.add_argument("--readme", type=Path, help="a file that has markers, between which the tables go at the end")
    a = parser.parse_args()
    before = json.loads(a.previous.read_text()) if a.previous else None
    a.output.mkdir(parents=True, exist_ok=True)
    # Kept ones would tell the time of another day.
    references = a.output / "references"
    shutil.rmtree(references, ignore_errors=True)

    sizes = QUICK if a.quick else FULL
    plan = [[c for c in group if a.only in name_of(*c)] for group in plan_of(sizes, references)]
    begin = time.perf_counter()
    about = {
        "machine": f"{processor()}, {os.cpu_count()} cores", "date": datetime.now(UTC).strftime("%Y-%m-%d"),
        "version": f"GI Bake {version()}, Blender {importlib.metadata.version('bpy')}",
        "command": " ".join(["make bench", *(["QUICK=1"] if a.quick else []), *(["--only", a.only] if a.only else [])]),
        "sizes": sizes,
    }  # fmt: skip
    found, document = [], {"about": about, "rows": {}, "exponents": {}}
    for step in measured(plan, sizes["limit"], lambda text: os.write(2, f"{text}\n".encode())):
        found.append(step)
        document["rows"] |= step[2]
        against_cycles(document["rows"])
        document["exponents"] = exponents(found)
        about["seconds"] = round(time.perf_counter() - begin)
        (a.output / "bench.json").write_text(json.dumps(document, indent=1, ensure_ascii=False), encoding="utf-8")
        (a.output / "bench.md").write_text(document_as_markdown(document, before), encoding="utf-8")
    text = document_as_markdown(document, before)
    os.write(1, text.encode())
    if a.readme:
        put_between_markers(a.readme, text)
    # What a technique cannot do is told as such; what broke is an error.
    sys.exit(any("failed" in row for row in document["rows"].values()))


if __name__ == "__main__":
    main()
