# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The graphics card as a device: arrays there and back, dispatches cut and cancelled, and life without a driver."""

import json
import os
import subprocess
import sys

import bpy
import numpy as np
import pytest
from gi_bake.addon import gpu_context
from gi_bake.gi_core import filter as smoothing
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.kernels.added import added
from gi_bake.gi_core.tiles import finish


def random(*shape):
    return np.random.default_rng(7).random(shape, np.float32)


@pytest.mark.parametrize("shape, channels", [((5,), 1), ((3000,), 1), ((7, 3), 3), ((2, 3, 6), 3), ((2049, 4), 4),
                                             ((1, 2), 2), ((0, 3), 3), ((60, 70), 1)])  # fmt: skip
def test_arrays_come_back_as_they_went(gpu, shape, channels):
    values = random(*shape)
    back = gpu.numpy(gpu.array(values, channels))
    assert back.dtype == np.float32
    np.testing.assert_array_equal(back, values)


@pytest.mark.parametrize("kind", [np.int32, np.int64, bool])
def test_whole_numbers_keep_their_kind(gpu, kind):
    values = np.array([0, 1, 1 if kind is bool else 2**24], kind)
    back = gpu.numpy(gpu.array(values, 1))
    assert back.dtype == kind
    np.testing.assert_array_equal(back, values)


def test_an_array_is_not_taken_for_one_of_other_channels(gpu):
    with pytest.raises(ValueError, match="3 channels"):
        gpu.array(gpu.array(random(4, 3), 3), 1)


def test_textures_are_used_again(gpu):
    first = gpu.empty((100, 3), 3)
    texture = first.texture
    del first
    assert gpu.empty((90, 3), 3).texture is not texture  # another size
    assert gpu.empty((100, 3), 3).texture is texture


def test_arrays_wait_outside_where_others_need_the_room(gpu, monkeypatch):
    image = [gpu.array(one, 3) for one in an_image(64)[:2]]
    expected = [gpu.numpy(one) for one in image]
    for one in image:
        assert one.texture
    monkeypatch.setattr(gpu, "budget", 0)
    assert gpu.array(random(1), 1).texture  # for which all goes that was kept
    total = gpu.run(added, *image)
    gpu.peak = 0
    np.testing.assert_array_equal(gpu.numpy(total), expected[0] + expected[1])
    # What one dispatch needs is there, and nothing else.
    assert gpu.peak == gpu.bytes == 3 * 16 * 64 * 64
    other = gpu.run(added, total, gpu.array(np.ones((64, 64, 3), np.float32), 3))
    np.testing.assert_array_equal(gpu.numpy(other), expected[0] + expected[1] + 1)
    assert gpu.peak == 3 * 16 * 64 * 64
    for one, values in zip(image, expected):
        np.testing.assert_array_equal(gpu.numpy(one), values)


def an_image(side):
    position = np.dstack([*np.indices((side, side)), np.zeros((side, side))]).astype(np.float32)
    return random(side, side, 3), position, np.broadcast_to(np.float32([0, 0, 1]), position.shape)


def test_a_filter_is_the_same_however_its_dispatches_are_cut(gpu, monkeypatch):
    whole = finish(smoothing.smooth(*an_image(200), 3, None, gpu))
    monkeypatch.setattr("gi_bake.gi_core.device._DISPATCH", 1e-9)  # a work group at a time
    shares = []
    work = smoothing.smooth(*an_image(40), 3, None, gpu)
    while True:
        try:
            shares.append(next(work))
        except StopIteration as stop:
            cut = stop.value
            break
    assert len(shares) > 3 * 40 * 40 / 64
    np.testing.assert_allclose(whole, finish(smoothing.smooth(*an_image(200), 3)), rtol=1e-5)
    np.testing.assert_allclose(cut, finish(smoothing.smooth(*an_image(40), 3)), rtol=1e-5)


def test_what_was_cancelled_is_not_done_later(gpu, monkeypatch):
    monkeypatch.setattr("gi_bake.gi_core.device._DISPATCH", 1e-9)
    work = smoothing.smooth(*an_image(40), 3, None, gpu)
    next(work)
    work.close()
    done = []
    for _ in gpu._done():
        done.append(1)
    assert len(done) == 1


def test_the_processor_is_taken_where_it_is_wanted():
    assert gpu_context.device("cpu") == (NUMPY, "")


def test_a_driver_in_software_is_taken_where_it_spares_more_than_it_takes(gpu):
    if not gpu.software:
        pytest.skip("here is a card")
    small, large = (gpu_context.spared("ssgi", n * n, 64) for n in (32, 4096))
    assert gpu_context.device("auto", spares=small)[0] is NUMPY
    expected = gpu if bpy.app.version >= (5, 0) else NUMPY
    assert gpu_context.device("auto", spares=large) == (expected, "")
    assert gpu_context.device("auto", spares=gpu_context.spared("lpv", 1 << 24, 64))[0] is NUMPY


@pytest.mark.parametrize("fails", ["child", "context"])
def test_a_driver_that_fails_leaves_the_processor(monkeypatch, fails):
    def fail():
        raise SystemError("GPU functions are not available")

    monkeypatch.setattr(gpu_context, "why_not", lambda: "no driver" if fails == "child" else "")
    monkeypatch.setattr(gpu_context, "_gpu", fail)
    found, reason = gpu_context.device("gpu")
    assert found is NUMPY and ("no driver" if fails == "child" else "not available") in reason
    assert gpu_context.device("auto", spares=1e9)[0] is NUMPY


def test_without_a_driver_a_bake_says_why_and_goes_on(sample, tmp_path):
    code = "import sys; from gi_bake.addon.console import main; sys.exit(main())"
    command = [sys.executable, "-c", code, "bake", sample("cornell"), "--target", "image", "--resolution", "16"]
    command += ["--set", "samples=4", "--device", "gpu", "--json", "--output", tmp_path]
    nowhere = {"LIBGL_DRIVERS_PATH": "/nowhere", "__EGL_VENDOR_LIBRARY_DIRS": "/nowhere"}
    run = subprocess.run(command, capture_output=True, text=True, env={**os.environ, **nowhere}, check=False)
    assert run.returncode == 0, run.stderr
    answer = json.loads(run.stdout)
    assert answer["device"] == "cpu"
    assert any(line.startswith("NO_GPU") for line in answer["warnings"])
