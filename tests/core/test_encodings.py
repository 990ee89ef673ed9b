# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What is written in 8 bits comes back by the sentence that goes with it."""

import re
import struct
import zlib

import numpy as np
import OpenEXR
import pytest
from gi_bake.gi_core import encodings, exr, png

LIGHT = np.random.default_rng(2).uniform(0, 1, (16, 16, 3)).astype(np.float32) ** 3 * 40


def decoded(values, sentence):
    """What the sentence says of a file's values."""
    rgb, alpha = values[..., :3] / 255, values[..., 3:] / 255
    factor = float(sentence.split()[-1])
    if "sRGB" in sentence:
        return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4) / factor
    return (rgb * alpha if "rgb * alpha" in sentence else rgb / alpha) * factor


@pytest.mark.parametrize("encoding", ["rgbm", "rgbd"])
@pytest.mark.parametrize("exposure", [1.0, 0.1, 7.0])
def test_the_full_range_comes_back(encoding, exposure):
    values, sentence = encodings.encoded(LIGHT, encoding, exposure, None)
    assert values.dtype == np.uint8 and values.shape == (16, 16, 4)
    back = decoded(values, sentence)
    peak = LIGHT.max(-1, keepdims=True)
    # Of the brightest channel of a texel, a step of 8 bits; of the dark ones in rgbd what alpha cannot resolve.
    floor = 40 / 255 if encoding == "rgbm" else 40 / 16
    assert (np.abs(back - LIGHT) <= np.maximum(peak, floor) * 1.5 / 255 + 1e-6).all()


def test_srgb_is_light_up_to_white():
    values, sentence = encodings.encoded(LIGHT, "srgb", 0.1, np.ones((16, 16), bool))
    assert np.allclose(decoded(values, sentence), np.minimum(LIGHT, 10), atol=0.06)
    black, _ = encodings.encoded(LIGHT * 0, "rgbm", 1.0, None)
    assert not black[..., :3].any()


def test_the_file_says_how_it_is_decoded(tmp_path):
    values, sentence = encodings.encoded(LIGHT, "rgbm", 1.0, None)
    png.write(tmp_path / "a.png", values, {"Decoding": sentence}, linear=True)
    data, at, chunks = (tmp_path / "a.png").read_bytes(), 8, {}
    while at < len(data):
        [size], kind = struct.unpack(">I", data[at : at + 4]), data[at + 4 : at + 8]
        body = data[at + 8 : at + 8 + size]
        assert struct.unpack(">I", data[at + 8 + size : at + 12 + size])[0] == zlib.crc32(kind + body)
        chunks[kind] = body
        at += 12 + size
    assert chunks[b"iTXt"] == b"Decoding\0\0\0\0\0" + sentence.encode() and b"sRGB" not in chunks
    assert re.fullmatch(r"linear = rgb \* alpha \* [\d.]+", sentence)


def test_half_floats_are_half_as_exact(tmp_path):
    pixels = LIGHT.copy()
    pixels[0, 0] = 1e6
    exr.write_image(tmp_path / "half.exr", pixels, {"gi_bake": "light"}, half=True)
    with OpenEXR.File(str(tmp_path / "half.exr"), separate_channels=True) as file:
        assert file.parts[0].channels["R"].pixels.dtype == np.float16 and file.header()["gi_bake"] == "light"
    back = exr.read_layers(tmp_path / "half.exr")["Combined"]
    assert np.allclose(back[1:], pixels[1:], rtol=1e-3, atol=1e-6) and (back[0, 0] == 65504).all()
