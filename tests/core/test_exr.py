# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""EXR files: exact round trips, the names in the file, and nothing left behind by a failure. Blender opens them in
tests/addon/test_write_layers.py."""

from pathlib import Path

import numpy as np
import OpenEXR
import pytest
from gi_bake.gi_core import exr


def noise(*shape):
    return np.random.default_rng(0).normal(size=shape).astype(np.float32)


def test_layers_come_back_bit_for_bit(tmp_path):
    layers = {
        "Combined": noise(5, 7, 4),
        "Diffuse Indirect": noise(5, 7, 3) * 1e-6,
        "Position": noise(5, 7, 3) * 1e6,
        "Depth": noise(5, 7, 1),
        "Weight": noise(5, 7),
    }
    exr.write_layers(tmp_path / "a.exr", layers, view_layer="My.Layer", metadata={"gi_bake.method": "RSM"})
    back = exr.read_layers(tmp_path / "a.exr")
    assert set(back) == set(layers)
    for name, pixels in layers.items():
        assert back[name].dtype == np.float32
        assert np.array_equal(back[name], np.atleast_3d(pixels))


def test_channels_have_blenders_names_and_the_top_row_comes_first(tmp_path):
    pixels = noise(4, 3, 3)
    layers = {"Diffuse Direct": pixels, "Normal": pixels, "Depth": pixels[..., 0]}
    exr.write_layers(tmp_path / "a.exr", layers, metadata={"gi_bake.seed": "3"})
    with OpenEXR.File(str(tmp_path / "a.exr"), separate_channels=True) as file:
        (part,) = file.parts
        assert set(part.channels) == {
            *(f"ViewLayer.Diffuse Direct.{c}" for c in "RGB"),
            *(f"ViewLayer.Normal.{c}" for c in "XYZ"),
            "ViewLayer.Depth.Z",
        }
        assert np.array_equal(part.channels["ViewLayer.Diffuse Direct.G"].pixels, pixels[::-1, :, 1])
        assert part.header["gi_bake.seed"] == "3"


def test_short_names_of_one_part_and_parts_of_their_own_read_alike(tmp_path):
    """The layouts of Blender 4.5 and 5, built with OpenEXR alone."""
    pixels = noise(4, 3)
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    old = {f"ViewLayer.DiffInd.{c}": pixels + i for i, c in enumerate("RGB")} | {"ViewLayer.Depth.Z": pixels}
    OpenEXR.File(header, old).write(str(tmp_path / "old.exr"))
    parts = {
        "ViewLayer.Diffuse Indirect": {f"ViewLayer.Diffuse Indirect.{c}": pixels + i for i, c in enumerate("RGB")},
        "ViewLayer.Depth": {"ViewLayer.Depth.Z": pixels},
    }
    OpenEXR.File([OpenEXR.Part(dict(header), channels, name) for name, channels in parts.items()]).write(
        str(tmp_path / "new.exr")
    )
    for path in (tmp_path / "old.exr", tmp_path / "new.exr"):
        layers = exr.read_layers(path)
        assert set(layers) == {"Diffuse Indirect", "Depth"}
        assert np.array_equal(layers["Diffuse Indirect"][..., 2], pixels[::-1] + 2)
        assert np.array_equal(layers["Depth"], pixels[::-1, :, None])


def test_one_of_several_view_layers(tmp_path):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    channels = {"A.Depth.Z": np.zeros((2, 2), np.float32), "B.Depth.Z": np.ones((2, 2), np.float32)}
    OpenEXR.File(header, channels).write(str(tmp_path / "a.exr"))
    assert exr.read_layers(tmp_path / "a.exr", "B")["Depth"].min() == 1
    with pytest.raises(ValueError, match=r"'A', 'B'.*one to be named"):
        exr.read_layers(tmp_path / "a.exr")
    with pytest.raises(ValueError, match="'C'"):
        exr.read_layers(tmp_path / "a.exr", "C")


def test_plain_image(tmp_path):
    pixels = noise(6, 5, 4)
    exr.write_image(tmp_path / "a.exr", pixels)
    assert np.array_equal(exr.read_layers(tmp_path / "a.exr")["Combined"], pixels)
    with OpenEXR.File(str(tmp_path / "a.exr")) as file:
        assert np.array_equal(file.parts[0].channels["RGBA"].pixels, pixels[::-1])


def test_wrong_input_says_what_is_wrong(tmp_path):
    with pytest.raises(ValueError, match="one size"):
        exr.write_layers(tmp_path / "a.exr", {"A": np.zeros((2, 2)), "B": np.zeros((2, 3))})
    with pytest.raises(ValueError, match="'Normal' cannot have 4 channels"):
        exr.write_layers(tmp_path / "a.exr", {"Normal": np.zeros((2, 2, 4))})
    with pytest.raises(ValueError, match="3 or 4 channels"):
        exr.write_image(tmp_path / "a.exr", np.zeros((2, 2)))
    with pytest.raises(OSError, match=r"missing.a\.exr: cannot be written"):
        exr.write_image(tmp_path / "missing" / "a.exr", np.zeros((2, 2, 3)))
    (tmp_path / "text.exr").write_text("no EXR")
    with pytest.raises(OSError, match=r"text\.exr: cannot be read"):
        exr.read_layers(tmp_path / "text.exr")


def test_a_failed_write_leaves_the_old_file_and_no_other(tmp_path, monkeypatch):
    exr.write_image(tmp_path / "a.exr", np.ones((2, 2, 3)))
    before = (tmp_path / "a.exr").read_bytes()

    def full_disk(file, name):
        Path(name).write_bytes(b"half")
        raise RuntimeError("No space left on device")

    monkeypatch.setattr(OpenEXR.File, "write", full_disk)
    with pytest.raises(OSError, match="No space left"):
        exr.write_image(tmp_path / "a.exr", np.zeros((2, 2, 3)))
    assert (tmp_path / "a.exr").read_bytes() == before
    assert [p.name for p in tmp_path.iterdir()] == ["a.exr"]
