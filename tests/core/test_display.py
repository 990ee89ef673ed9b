# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures: the sRGB curve at known points, and PNG files that another reader reads back."""

import numpy as np
import pytest
from gi_bake.gi_core import display, png


def test_srgb_at_known_points():
    """Middle grey, the end points, and the seam of the two pieces (IEC 61966-2-1)."""
    linear = np.array([-1, 0, 0.0031308, 0.18, 0.2140411, 1, 7])
    assert display.srgb(linear) == pytest.approx([0, 0, 0.04045, 0.4613561, 0.5, 1, 1], abs=1e-6)


def test_picture_exposes_clips_and_masks():
    pixels = np.array([[[0.18, 0, 9], [1, 1, 1]]], np.float32) / 4
    mask = np.array([[True, False]])
    assert display.picture(pixels, 4).tolist() == [[[118, 0, 255], [255, 255, 255]]]
    assert display.picture(pixels, 4, mask)[..., 3].tolist() == [[255, 0]]


def test_difference_is_white_where_equal_red_where_too_bright():
    reference = np.full((1, 3, 3), 0.5, np.float32)
    test = reference + np.array([0, 1, -1], np.float32)[None, :, None]
    equal, bright, dark = display.difference(test, reference, 1.0)[0].astype(int)
    assert equal.tolist() == [255, 255, 255]
    assert bright[0] > 2 * bright[2]
    assert dark[2] > 2 * dark[0]


@pytest.mark.parametrize("channels", [3, 4])
def test_png_reads_back(tmp_path, channels):
    """Through OpenImageIO, which comes with Blender."""
    oiio = pytest.importorskip("OpenImageIO")
    pixels = np.random.default_rng(0).integers(0, 256, (13, 17, channels), np.uint8)
    png.write(tmp_path / "a.png", pixels)
    file = oiio.ImageInput.open(str(tmp_path / "a.png"))
    # Unassociated alpha, or colours come back multiplied by it.
    spec = oiio.ImageSpec()
    spec["oiio:UnassociatedAlpha"] = 1
    file.close()
    file = oiio.ImageInput.open(str(tmp_path / "a.png"), spec)
    assert np.array_equal(file.read_image("uint8")[::-1], pixels)
    file.close()
    assert [p.name for p in tmp_path.iterdir()] == ["a.png"]


def test_png_refuses_floats():
    with pytest.raises(ValueError, match="uint8"):
        png.encode(np.zeros((2, 2, 3)))
