# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The benchmark's own machinery: a case that breaks costs its row only, and tables say who is sooner."""

import sys

import pytest
from gi_bake.tests.benchmarks import camera, suite, tables
from gi_bake.tests.benchmarks.worker import Worker

ANSWERS = """
import json, sys, time
for line in sys.stdin:
    case, arguments = json.loads(line)
    print("Blender says something", flush=True)
    if case == "die": sys.exit("out of luck")
    if case == "hang": time.sleep(60)
    if case == "raise": print(json.dumps({"failed": "ValueError: no"}), flush=True)
    else: print(json.dumps({case: {"served": arguments["n"]}}), flush=True)
"""


def test_a_case_that_breaks_costs_no_other():
    with Worker([sys.executable, "-c", ANSWERS], limit=5) as worker:
        assert worker.ask("one", {"n": 1}) == {"one": {"served": 1}}
        first = worker.process.pid
        assert worker.ask("die", {}) == {"failed": "ended with 1: out of luck"}
        assert worker.ask("two", {"n": 2}) == {"two": {"served": 2}} and worker.process.pid != first
        second = worker.process.pid
        assert worker.ask("raise", {}) == {"failed": "ValueError: no"}
        assert worker.ask("three", {"n": 3}) == {"three": {"served": 3}} and worker.process.pid != second
        worker.limit = 0.5
        assert worker.ask("hang", {}) == {"failed": "took longer than 0.5 s"}
        worker.limit = 5
        assert worker.ask("four", {"n": 4}) == {"four": {"served": 4}}
        last = worker.process
    assert last.poll() is not None


@pytest.mark.parametrize("sizes", [suite.FULL, suite.QUICK], ids=["full", "quick"])
def test_the_plan_has_everything_once(sizes, tmp_path):
    names = [suite.name_of(*case) for group in suite.plan_of(sizes, tmp_path) for case in group]
    assert len(set(names)) == len(names)
    assert set(suite.SCENES) == {p.stem for p in (suite.HERE.parents[1] / "sample_blends").glob("*.blend")}
    for scene in suite.SCENES:
        asked = [name for name in names if name.startswith(f"sample {scene} ")]
        assert len(asked) == 3 * 3 + 1 and f"sample {scene} volume lpv" in asked
    assert {name.split()[0] for name in names} == {c for cases in tables.TITLES.values() for c in cases}


def test_exponents_are_those_of_power_laws():
    rows = [("texels", {"count": n}, {"lightmap": {"seconds": 2e-6 * n**3}}) for n in (64, 128, 256)]
    rows += [("triangles", {"count": n}, {"t": {"seconds": n}, "r": {"seconds": 5.0}}) for n in (10, 100)]
    # By texels, of which there are n² on n × n.
    wanted = {"time by texels": 1.5, "trees by triangles": 1, "rays by triangles": 0}
    assert suite.exponents(rows) == pytest.approx(wanted, abs=1e-9)


def image(seconds, relmse, noise=0.001, **more):
    return {"case": "sample", "seconds": seconds, "relMSE": relmse, "noise": noise, **more}


def test_who_is_sooner_at_the_same_error():
    """Denoised Cycles: 0.1 after 1 s and 0.01 after 10 s, the noise of the reference taken off."""
    rows = {
        f"a image Cycles, OIDN, {n} samples": {"case": "cycles", "seconds": s, "relMSE": e + 0.001, "noise": 0.001}
        for n, s, e in ((1, 1.0, 0.1), (8, 10.0, 0.01))
    }
    # Half a second to the first sample, a tenth for each further one: two renders of 40 samples.
    bakes = {"Cycles' seconds": 9.0, "Cycles' samples": 80, "Cycles' first sample": 0.5}
    rows |= {
        "a image fast": image(2.0, 0.011), "a image slow": image(20.0, 0.101), "a image poor": image(2.0, 0.5),
        "a image near": image(2.0, 0.006), "a image as good": image(2.0, 0.0012),
        "a vertices dark": image(2.0, 0, 0), "a lightmap fast": image(0.9, 0.011, **bakes),
        "a lightmap first": image(0.4, 0.5, **bakes),
    }  # fmt: skip
    suite.against_cycles(rows)
    there = {name.removeprefix("a image "): row.get("Cycles, same error") for name, row in rows.items()}
    assert there["fast"] == pytest.approx(10) and there["slow"] == pytest.approx(1)
    # One that is worse than Cycles' first picture, one that is better than its last, one that cannot be told.
    assert there["poor"] == 1 and there["near"] == "not reached" and there["as good"] == "within noise"
    assert rows["a image fast"]["Cycles, same time"] == pytest.approx(0.1 / 2)
    assert rows["a image slow"]["Cycles, same time"] == pytest.approx(0.01)
    assert rows["a vertices dark"]["Cycles, same error"] == "within noise"
    # Ten times the noise of the reference: eight samples. After four more than the first it has 16 times that noise.
    assert rows["a lightmap fast"]["Cycles, same error"] == pytest.approx(0.5 + 0.1 * 7)
    assert rows["a lightmap fast"]["Cycles, same time"] == pytest.approx(0.001 * 80 / 5)
    first = rows["a lightmap first"]
    assert first["Cycles, same error"] == 0.5 and first["Cycles, same time"] == "no picture"
    text = tables.document_as_markdown({"about": {"machine": "m"}, "rows": rows, "exponents": {}})
    sooner = "at the same error in 2: a fast (5 ×), a near; **Cycles is sooner in 2**: a slow (20 ×), a poor (2 ×);"
    assert sooner in text
    assert "- image: " in text and "; 1 are within" in text


def test_a_camera_image_is_as_much_sooner_as_cycles_curve_says():
    def curve(*rows):
        return [{"samples": 1, "seconds": 9.0, "processor [s]": s, "relmse": e} for s, e in rows]

    # In logarithms halfway between a second and a hundred; worse than Cycles' first picture; better than its last.
    ours = curve((2.0, 0.01), (4.0, 0.5), (3.0, 0.0001))
    found = {camera.OURS: ours, camera.DENOISED: curve((1.0, 0.1), (100.0, 0.001))}
    assert camera.sooner(found) == [pytest.approx(5), pytest.approx(0.25), None]
    # To Cycles' last picture, 0.001, ours takes halfway between 2 s and 3 s; its first is no better than ours at 2 s.
    both = "RSM is sooner at relMSE 0.00100 (40.82 ×), 0.01000 (5.00 ×); Cycles is sooner at relMSE 0.10000 (2.00 ×)"
    assert camera.verdict(found) == f"{both}, 0.50000 (4.00 ×)"


def test_tables_have_each_row_an_earlier_run_and_remarks():
    rows = {
        "a image rsm": image(2.0, 0.011), "read a": {"case": "reading", "seconds": 0.5, "triangles": 12},
        "sample b image rsm": {"case": "sample", "failed": "ValueError: a | b"},
        "a vertices rsm": {"case": "sample", "refused": "VERTICES_NOT_WRITABLE"},
    }  # fmt: skip
    document = {"about": {"machine": "m", "sizes": {}}, "rows": rows, "exponents": {"time by cells": 0.9}}
    about = {"date": "d", "version": "v", "command": "c"}
    before = {"about": about, "rows": {"a image rsm": image(3.0, 0.02)}, "exponents": {"time by cells": 1.1}}
    lines = tables.document_as_markdown(document, before).splitlines()
    assert "| a image rsm | 2 | 0.01100 | 0.00100 | 3 | 0.02000 |  |" in lines
    assert "| sample b image rsm |  |  |  |  |  | failed: ValueError: a / b |" in lines
    assert "| a vertices rsm |  |  |  |  |  | VERTICES_NOT_WRITABLE |" in lines
    assert "| read a | 0.5 | 12 |" in lines and "| time by cells | 0.90 | 1.10 |" in lines
    assert "machine: m  " in lines and not any("sizes" in line for line in lines)


def test_tables_go_between_their_markers_and_nowhere_else(tmp_path):
    file = tmp_path / "README.md"
    file.write_text(f"# Head\n\n{tables.BEGIN}\nold\n{tables.END}\n\ntail\n")
    for text in ("one\n", "two\n"):
        tables.put_between_markers(file, text)
    assert file.read_text() == f"# Head\n\n{tables.BEGIN}\n\ntwo\n\n{tables.END}\n\ntail\n"
    file.write_text("# Head\n")
    with pytest.raises(ValueError, match="no place"):
        tables.put_between_markers(file, "three")
    assert file.read_text() == "# Head\n"


def test_this_repositorys_readme_has_the_place():
    text = (suite.HERE / "README.md").read_text(encoding="utf-8")
    assert text.count(tables.BEGIN) == text.count(tables.END) == 1 and text.index(tables.BEGIN) < text.index(tables.END)
