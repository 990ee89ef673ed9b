# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Result images: exact, kept by the file, swapped in for earlier results and never for the user's own."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.write import images
from gi_bake.gi_core import exr

rng = np.random.default_rng(0)


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def pixels_of(image):
    pixels = np.empty((image.size[1], image.size[0], 4), np.float32)
    image.pixels.foreach_get(pixels.ravel())
    return pixels


def light(channels):
    """Values as light has them: far above 1, tiny, and coloured where alpha says empty."""
    pixels = (1000 * rng.random((9, 13, channels))).astype(np.float32)
    pixels[0, 0, :3] = (-2, 1e-7, 3e5)
    if channels == 4:
        pixels[..., 3] = rng.random((9, 13)) < 0.5
    return pixels


@pytest.mark.parametrize("channels", [3, 4])
@pytest.mark.parametrize("is_data", [False, True])
def test_values_are_exact_also_after_saving_and_loading_the_file(tmp_path, channels, is_data):
    expected = light(channels)
    image = images.write_images({"GI Floor": expected}, is_data)["GI Floor"]
    assert image.name == "GI Floor"
    assert image.is_float
    assert image.colorspace_settings.is_data == is_data
    assert np.array_equal(pixels_of(image)[..., :channels], expected)
    image.use_fake_user = True
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "a.blend"))
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "a.blend"))
    image = bpy.data.images["GI Floor"]
    assert np.array_equal(pixels_of(image)[..., :channels], expected)
    assert image.colorspace_settings.is_data == is_data


def test_light_is_no_different_to_a_render_in_colour_management():
    """A material that looks an image of light up gets the values themselves: the space is the scene-linear one."""
    image = images.write_images({"GI": light(3)})["GI"]
    reference = bpy.data.images.new("render", 4, 4, float_buffer=True)
    assert image.colorspace_settings.name == reference.colorspace_settings.name == "Linear Rec.709"


def test_an_earlier_result_is_replaced_where_it_is_used():
    first = images.write_images({"GI": light(3)})["GI"]
    material = bpy.data.materials.new("M")
    if not material.node_tree:
        material.use_nodes = True
    node = material.node_tree.nodes.new("ShaderNodeTexImage")
    node.image = first
    first.use_fake_user = True
    expected = light(3)[:5]
    second = images.write_images({"GI": expected})["GI"]
    assert [i.name for i in bpy.data.images] == ["GI"]
    assert node.image == second
    assert second.use_fake_user
    assert np.array_equal(pixels_of(second)[..., :3], expected)


def test_an_image_of_the_users_is_left_alone():
    own = bpy.data.images.new("GI", 3, 3)
    for _ in range(2):
        result = images.write_images({"GI": light(3)})["GI"]
        assert result.name == "GI.001"
    assert {i.name for i in bpy.data.images} == {"GI", "GI.001"}
    assert tuple(own.size) == (3, 3)


def test_nothing_is_swapped_in_when_one_image_fails(monkeypatch):
    before = images.write_images({"A": light(3)})["A"]
    make = images._new_image

    def runs_out_of_memory(pixels, is_data):
        if pixels.shape[2] == 4:
            raise MemoryError
        return make(pixels, is_data)

    monkeypatch.setattr(images, "_new_image", runs_out_of_memory)
    with pytest.raises(MemoryError):
        images.write_images({"A": light(3), "B": light(4)})
    assert list(bpy.data.images) == [before]


def test_wrong_shape_names_the_image():
    with pytest.raises(ValueError, match="image 'Wall'"):
        images.write_images({"Wall": np.zeros((4, 4))})


def test_files_to_keep_and_to_look_at(tmp_path):
    expected = light(3)
    paths = images.save_image(tmp_path, "Wall/left", expected)
    assert [p.name for p in paths] == ["Wall_left.exr", "Wall_left.png"]
    assert np.array_equal(exr.read_layers(paths[0])["Combined"], expected)
    assert tuple(bpy.data.images.load(str(paths[1])).size) == (13, 9)


def test_the_picture_to_look_at_is_srgb_at_the_exposure_asked_for(tmp_path):
    _, path = images.save_image(tmp_path, "grey", np.full((2, 2, 3), 0.09, np.float32), exposure=2.0)
    picture = bpy.data.images.load(str(path))
    # 18 % grey is 0.4614 in sRGB; Blender hands out the bytes of the file over 255.
    assert pixels_of(picture)[0, 0, :3] == pytest.approx(0.4614, abs=1 / 255)


def test_the_picture_of_a_lightmap_is_transparent_on_empty_texels(tmp_path):
    pixels = np.zeros((4, 100, 4), np.float32)
    pixels[:, :2] = (0.5, 0.5, 0.5, 1)
    picture = bpy.data.images.load(str(images.save_png(tmp_path, "map", pixels)))
    # The few texels that hold light set the exposure: they are white.
    assert np.array_equal(pixels_of(picture)[:, :2], np.ones((4, 2, 4)))
    assert (pixels_of(picture)[:, 2:, 3] == 0).all()
