# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The command line as a user meets it: processes, exit codes, what is printed where."""

import hashlib
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import bpy
import pytest
from gi_bake.gi_core import exr

GI_BAKE = [sys.executable, "-c", "import sys; from gi_bake.addon.console import main; sys.exit(main())"]


def gi_bake(*arguments, **more):
    return subprocess.run([*GI_BAKE, *map(str, arguments)], capture_output=True, text=True, timeout=300, **more)


QUICK = ("--resolution", 24, "--set", "samples=4", "--set", "map_resolution=32")


def test_bake_writes_what_it_says(sample, tmp_path):
    done = gi_bake("bake", sample("cornell"), "--output", tmp_path, "--json", "--save", *QUICK)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert list(answer) == [
        "method",
        "target",
        "device",
        "stages",
        "seconds",
        "outputs",
        "metrics",
        "approximated",
        "warnings",
    ]
    assert (answer["method"], answer["target"], answer["device"], answer["metrics"]) == ("rsm", "image", "cpu", None)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["cornell.blend", "image.exr", "image.png"]
    assert sorted(answer["outputs"]) == sorted(str(p) for p in tmp_path.iterdir())
    layers = exr.read_layers(tmp_path / "image.exr")
    assert layers["Diffuse Indirect"].shape == (24, 24, 3) and layers["Diffuse Indirect"].max() > 0
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "cornell.blend"))
    assert any(image.get("gi_bake_result") and image.size[0] == 24 for image in bpy.data.images)


def test_lightmaps_of_two_objects(sample, tmp_path):
    done = gi_bake(
        "bake", sample("cornell"), "--target", "lightmap", "--objects", "Floor,Ceiling", "--output", tmp_path, *QUICK
    )
    assert done.returncode == 0, done.stderr
    assert sorted(p.name for p in tmp_path.glob("*.exr")) == ["Ceiling Lightmap.exr", "Floor Lightmap.exr"]


def test_light_at_vertices_is_saved(sample, tmp_path):
    file = tmp_path / "lit.blend"
    done = gi_bake(
        "bake", sample("cornell"), "--target", "vertices", "--output", tmp_path, "--save", file, "--json", *QUICK[2:]
    )
    assert done.returncode == 0, done.stderr
    bpy.ops.wm.open_mainfile(filepath=str(file))
    assert "gi_irradiance" in bpy.data.objects["Floor"].data.attributes


def test_compare_measures(sample, tmp_path):
    done = gi_bake("compare", sample("cornell"), "--output", tmp_path, "--reference-samples", 16, "--json", *QUICK)
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert answer["metrics"]["rsm"]["Diffuse Indirect"]["relmse"] > 0
    assert {"report.html", "report.json", "reference.exr"} <= {p.name for p in tmp_path.iterdir()}
    assert {str(p) for p in tmp_path.iterdir()} - set(answer["outputs"]) == {str(tmp_path / "reference.npz")}


def test_techniques_side_by_side(sample, tmp_path):
    """A setting goes to the methods that have it; each method's files lie in a folder of their own."""
    done = gi_bake(
        "compare", sample("thin_wall"), "--method", "rsm,ssgi", "--output", tmp_path, "--reference-samples", 8,
        "--json", "--curves", "--dark", "0.1 -9 -9 9 9 9", "--set", "frames=2", "--set", "denoise=none",
        "--save", *QUICK,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    answer = json.loads(done.stdout)
    assert (answer["method"], list(answer["metrics"])) == ("rsm,ssgi", ["rsm", "ssgi"])
    assert {p.name for p in (tmp_path / "ssgi").iterdir()} == {"image.exr", "image.png", "thin_wall.blend"}
    told = json.loads((tmp_path / "report.json").read_text())
    assert told["techniques"]["ssgi"]["settings"]["frames"] == 2
    assert told["techniques"]["rsm"]["settings"]["samples"] == told["techniques"]["ssgi"]["settings"]["samples"] == 4
    assert {"rsm", "ssgi", "Cycles", "Cycles, OIDN"} == set(told["curves"])
    # The right room is dark; rays find no way through its wall.
    assert told["techniques"]["rsm"]["comparisons"]["Diffuse Indirect"]["leak"] < 1e-6


@pytest.mark.parametrize(
    "arguments, words",
    [
        (("bake", "{}", "--method", "raytrace"), "raytrace"),
        (("bake", "{}", "--method", "magic"), "magic"),
        (("bake", "{}", "--target", "volume"), "volume"),
        (("bake", "{}", "--set", "samples"), "KEY=VALUE"),
        (("bake", "{}", "--set", "samples=none"), "samples"),
        (("bake", "{}", "--resolution", "1"), "resolution"),
        (("bake", "{}.no"), "no file"),
        (("bake", "{}", "--target", "vertices"), "--save"),
        (("bake", "{}", "--save", "/nowhere/at/all.blend"), "folder"),
        (("bake", "{}", "--frame", "99999999999"), "frame"),
        (("compare", "{}", "--reference-samples", "0"), "less than 1"),
        (("compare", "{}", "--method", "rsm,magic"), "magic"),
        (("compare", "{}", "--method", "rsm,lpv", "--set", "frames=2"), "frames"),
        (("compare", "{}", "--method", "rsm,lpv", "--save", "file.blend"), "one method"),
        (("compare", "{}", "--dark", "Nobody"), "Nobody"),
        (("compare", "{}", "--target", "lightmap", "--curves"), "camera"),
        (("bake",), "required"),
        (("fry", "{}"), "invalid choice"),
    ],
)
def test_wrong_usage_is_2(sample, arguments, words):
    done = gi_bake(*(str(a).format(sample("cornell")) for a in arguments))
    assert done.returncode == 2 and words in done.stderr and not done.stdout


def test_the_open_file_is_overwritten_by_its_name_only(sample, tmp_path):
    file = tmp_path / "mine.blend"
    file.write_bytes(sample("cornell").read_bytes())
    before = file.read_bytes()
    done = gi_bake("bake", file, "--output", tmp_path, "--save", *QUICK)
    assert done.returncode == 2 and "overwrite" in done.stderr and file.read_bytes() == before
    done = gi_bake("bake", file, "--output", "//results", "--save", file, *QUICK)
    assert done.returncode == 0 and file.read_bytes() != before
    assert (tmp_path / "results" / "image.exr").is_file()


def test_lightmaps_of_names_that_no_file_can_have(sample, tmp_path):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    bpy.data.objects["Floor"].name, bpy.data.objects["Ceiling"].name = "A/B", "a_b"
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "names.blend"), copy=True)
    arguments = ("--objects", "A/B, a_b,a_b", "--target", "lightmap", "--output", tmp_path / "out", "--json")
    done = gi_bake("bake", tmp_path / "names.blend", *arguments, *QUICK)
    assert done.returncode == 0, done.stderr
    outputs = json.loads(done.stdout)["outputs"]
    assert len(set(outputs)) == 4 and len(list((tmp_path / "out").iterdir())) == 4


def test_light_at_vertices_and_on_a_text_is_compared_where_it_can_be(sample, tmp_path):
    done = gi_bake("compare", sample("cornell"), "--target", "vertices", "--output", tmp_path, "--reference-samples", 4)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(os.name == "nt", reason="a pipe ends otherwise there")
def test_a_reader_that_leaves_does_not_spoil_the_bake(sample, tmp_path):
    command = " ".join(
        f"'{part}'" for part in [*GI_BAKE, "bake", sample("cornell"), "--output", tmp_path, "--json", *QUICK]
    )
    done = subprocess.run(
        ["bash", "-c", f"set -o pipefail; {command} | true"], capture_output=True, text=True, timeout=300
    )
    assert done.returncode == 0 and "Traceback" not in done.stderr
    assert (tmp_path / "image.exr").is_file()


def break_no_camera():
    bpy.data.objects.remove(bpy.context.scene.camera)


def break_no_mesh():
    for obj in [o for o in bpy.data.objects if o.type == "MESH"]:
        bpy.data.objects.remove(obj)


def break_nan():
    bpy.data.objects["Floor"].data.vertices[0].co.x = float("nan")


def break_missing_texture():
    material = bpy.data.objects["Floor"].active_material
    nodes = material.node_tree.nodes
    texture = nodes.new("ShaderNodeTexImage")
    texture.image = bpy.data.images.new("gone", 4, 4)
    texture.image.source, texture.image.filepath = "FILE", "//nowhere/gone.png"
    surface = next(n for n in nodes if n.type == "BSDF_DIFFUSE")
    material.node_tree.links.new(texture.outputs["Color"], surface.inputs["Color"])


def break_area_light():
    light = bpy.data.lights.new("Flat", "AREA")
    lamp = bpy.data.objects.new("Flat", light)
    lamp.scale = (0, 1, 1)
    bpy.context.scene.collection.objects.link(lamp)


@pytest.mark.parametrize(
    "harm, code, named",
    [
        (break_no_camera, "NO_CAMERA", ""),
        (break_no_mesh, "NOTHING_TO_BAKE", ""),
        (break_nan, "NON_FINITE", "Floor"),
        (break_missing_texture, "MISSING_IMAGE", "gone"),
        (break_area_light, "ZERO_AREA_LIGHT", "Flat"),
    ],
)
def test_a_broken_scene_is_3_and_stays_as_it_is(sample, tmp_path, harm, code, named):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    harm()
    file = tmp_path / "broken.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(file), copy=True)
    before = hashlib.sha256(file.read_bytes()).digest()
    for command in ("bake", "check"):
        done = gi_bake(command, file, "--output", tmp_path / "out", "--json")
        assert done.returncode == 3
        assert code in done.stderr and named in done.stderr
        assert code in {finding["code"] for finding in json.loads(done.stdout)["findings"]}
    assert hashlib.sha256(file.read_bytes()).digest() == before
    assert not list((tmp_path / "out").glob("*"))


def test_a_file_that_is_no_blend_is_3(tmp_path):
    file = tmp_path / "text.blend"
    file.write_text("not a blend")
    done = gi_bake("bake", file)
    assert done.returncode == 3 and "UNREADABLE_FILE" in done.stderr


def test_check_finds_nothing_wrong_with_a_good_scene(sample):
    done = gi_bake("check", sample("cornell"))
    assert done.returncode == 0 and "ready" in done.stdout


@pytest.mark.skipif(os.name == "nt", reason="Windows has no SIGINT to send to another process")
def _cpu_seconds(pid):
    fields = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


def test_an_interrupt_is_130_and_writes_nothing(sample, tmp_path):
    running = subprocess.Popen(
        [*GI_BAKE, "bake", sample("cornell"), "--output", tmp_path, "--resolution", "1024", "--set", "samples=4096"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE,
    )  # fmt: skip
    # Blender is up and the bake well under way when so much has been computed, however busy the machine is.
    while _cpu_seconds(running.pid) < 8:
        assert running.poll() is None
        time.sleep(0.1)
    running.send_signal(signal.SIGINT)
    try:
        running.communicate(timeout=60)
    finally:
        running.kill()
    assert running.returncode == 130
    assert not list(tmp_path.iterdir())
