# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an animation: what comes out is the same whether a run was stopped or not; nothing good is done again."""

import json
from dataclasses import replace

import bpy
import pytest
from gi_bake.addon import animation
from gi_bake.addon.animation import bake_frames
from gi_bake.addon.cli import CANCELLED, DONE, USAGE, main
from gi_bake.addon.job import Job
from gi_bake.gi_core import exr, metrics, tiles
from gi_bake.gi_core.ssgi.settings import SsgiSettings

SETTINGS = SsgiSettings(frames=1, samples=1, antialias=1, bounces=2, steps=32, mode="screen_space", fallback="none")
JOB = Job("ssgi", resolution=24, settings=SETTINGS)
FRAMES = range(3, 8)


@pytest.fixture
def pan(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("pan")))
    bpy.context.scene.frame_set(1)
    return bpy.context.scene, bpy.context.view_layer


def pictures(folder):
    return {p.name: p.read_bytes() for p in sorted(folder.glob("image.*.exr"))}


def baked(pan, folder, job=JOB, frames=FRAMES):
    return tiles.finish(bake_frames(*pan, job, frames, folder))


def stopped(pan, folder, frame):
    """A run that is stopped in the midst of a frame."""
    run = bake_frames(*pan, JOB, FRAMES, folder)
    for _, stage in run:
        if stage == f"frame {frame}: screen":
            break
    run.close()


@pytest.fixture
def whole(pan, tmp_path):
    paths = baked(pan, tmp_path / "whole")
    assert [p.name for p in paths] == [f"image.{f:04d}.exr" for f in FRAMES]
    assert pan[0].frame_current == 1
    return pictures(tmp_path / "whole")


def test_a_stopped_run_goes_on_where_it_was(pan, tmp_path, whole, monkeypatch):
    folder = tmp_path / "run"
    stopped(pan, folder, 6)
    assert sorted(pictures(folder)) == [f"image.{f:04d}.exr" for f in (3, 4, 5)]
    assert [p.name for p in folder.glob("history*")] == ["history.0005.npz"]
    began, work = [], animation.bake

    def noted(scene, *arguments, **more):
        began.append(scene.frame_current)
        return work(scene, *arguments, **more)

    monkeypatch.setattr(animation, "bake", noted)
    baked(pan, folder)
    assert began == [6, 7] and pictures(folder) == whole
    assert not [*folder.glob("history*"), *folder.glob(".*")]
    baked(pan, folder)
    assert began == [6, 7]


@pytest.mark.parametrize("harm", ["damaged", "missing", "another job", "history lost", "journal damaged"])
def test_what_is_not_what_it_should_be_is_done_again(pan, tmp_path, whole, harm):
    folder = tmp_path / "run"
    stopped(pan, folder, 6)
    picture, journal = folder / "image.0004.exr", folder / "frames.json"
    if harm == "damaged":
        data = bytearray(picture.read_bytes())
        data[-5] ^= 1
        picture.write_bytes(data)
    elif harm == "missing":
        picture.unlink()
    elif harm == "another job":
        said = json.loads(journal.read_text())
        journal.write_text(json.dumps(said | {"of": "something else"}))
        picture.write_bytes(b"")
    elif harm == "history lost":
        (folder / "history.0005.npz").unlink()
    else:
        journal.write_text("{")
    baked(pan, folder)
    assert pictures(folder) == whole


def test_history_is_carried_from_frame_to_frame(pan, tmp_path):
    """A later frame is nearer to a long still than the same frame alone."""
    settings = replace(SETTINGS, mode="ray_traced", bounces=1, denoise="none")
    late, alone, reference = (
        exr.read_layers(
            baked(pan, tmp_path / str(k), replace(JOB, settings=replace(settings, samples=n)), frames)[-1]
        )["Diffuse Indirect"]
        for k, (n, frames) in enumerate([(1, FRAMES), (1, FRAMES[-1:]), (256, FRAMES[-1:])])
    )
    assert metrics.relmse(late, reference) < 0.6 * metrics.relmse(alone, reference)


def test_from_the_command_line(sample, tmp_path, capsys, monkeypatch):
    arguments = ["bake", str(sample("pan")), "--method", "ssgi", "--resolution", "16", "--output", str(tmp_path)]
    arguments += ["--set", "mode=ray_traced", "--set", "samples=1", "--set", "frames=1", "--set", "antialias=1"]
    assert main([*arguments, "--frames", "2-3", "--json"]) == DONE
    answer = json.loads(capsys.readouterr().out)
    assert [p[-14:] for p in answer["outputs"]] == ["image.0002.exr", "image.0003.exr"]
    for wrong in (["3-2"], ["x"], ["1-2", "--save"], ["1-2", "--frame", "1"]):
        assert main([*arguments, "--frames", *wrong]) == USAGE

    def interrupted(*_, **__):
        raise KeyboardInterrupt
        yield

    monkeypatch.setattr(animation, "bake", interrupted)
    assert main([*arguments, "--frames", "2-5"]) == CANCELLED
    assert sorted(p.name for p in tmp_path.glob("image*")) == ["image.0002.exr", "image.0003.exr"]
