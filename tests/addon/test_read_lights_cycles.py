# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the reader makes of lights against what Cycles does with them, in tiny renders."""

import bpy
import numpy as np
import pytest
from gi_bake.tests.shader_trees import Tree, brightness, lamp, material, overhead_camera, read, square


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


@pytest.fixture
def white_square():
    tree = material("white")
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=(1.0, 1.0, 1.0))), size=0.1)
    overhead_camera(0.1, 0.1)


def lamp_nodes(light):
    tree = Tree(light.data)
    color = tree.node("ShaderNodeBlackbody", Temperature=4000.0)
    tree.surface(tree.node("ShaderNodeEmission", Color=color, Strength=3.0), "ShaderNodeOutputLight")


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "SUN"])
@pytest.mark.parametrize(
    "attributes",
    [
        {"color": (0.2, 0.5, 0.8)},
        {"exposure": -1.5},
        {"use_temperature": True, "temperature": 3000, "color": (0.5, 1, 1)},
        {"normalize": False},
        {"normalize": False, "size": 0.3},
        {"normalize": False, "scale": (2, 0.5, 3)},
        {"normalize": False, "scale": (-2, 2, 1)},
        {"nodes": True},
    ],
    ids=str,
)
def test_what_is_folded_into_the_power_of_a_light(tmp_path, white_square, kind, attributes):
    sizes = {"POINT": "shadow_soft_size", "SPOT": "shadow_soft_size", "AREA": "size", "SUN": "angle"}
    attributes = {sizes[kind] if key == "size" else key: value for key, value in attributes.items()}
    nodes = attributes.pop("nodes", False)
    plain = lamp(kind, **{sizes[kind]: attributes.get(sizes[kind], 0.2)}, scale=attributes.get("scale", (1, 1, 1)))
    expected = brightness(tmp_path)
    plain.hide_render = True
    light = lamp(kind, **{sizes[kind]: 0.2, **attributes})
    if nodes:
        lamp_nodes(light)
    ratio = brightness(tmp_path) / expected
    plain.hide_render = False
    first, second = read().lights
    # A Blackbody node is read through colour matching functions that are not quite those of Cycles.
    assert second.power / first.power == pytest.approx(ratio, rel=0.03 if nodes else 1e-3)


@pytest.mark.parametrize("shape", ["SQUARE", "RECTANGLE", "DISK", "ELLIPSE"])
def test_area_of_lights(tmp_path, white_square, shape):
    """A light's radiance is P/(πA): without Normalize it is in the file and the area is in P."""
    light = lamp("AREA", shape=shape, size=0.3, size_y=0.1, normalize=False, scale=(0.5, 1.5, 1))
    shown = brightness(tmp_path)
    [found] = read().lights
    assert found.size == pytest.approx({"SQUARE": (0.3, 0.3), "DISK": (0.3, 0.3)}.get(shape, (0.3, 0.1)))
    assert found.shape == ("ELLIPSE" if shape in {"DISK", "ELLIPSE"} else "RECTANGLE")
    assert found.power / np.pi / 3**2 / np.pi == pytest.approx(shown, rel=0.01)  # intensity P/π, seen from far away
    light.data.normalize = True
    assert read().lights[0].power == pytest.approx([10, 10, 10])


def test_lights_without_size(tmp_path, white_square):
    for kind, size in (("POINT", "shadow_soft_size"), ("SPOT", "shadow_soft_size"), ("SUN", "angle")):
        light = lamp(kind, **{size: 0.0})
        expected = brightness(tmp_path)
        power = read().lights[0].power
        light.data.normalize = False
        ratio = brightness(tmp_path) / expected
        assert read().lights[0].power / power == pytest.approx(ratio, rel=1e-3)
        bpy.data.objects.remove(light)


def test_lights_that_light_nothing_are_left_out(tmp_path, white_square):
    lamp("POINT").visible_diffuse = False
    lamp("POINT").hide_render = True
    tree = Tree(lamp("POINT").data)
    tree.tree.nodes.new("ShaderNodeOutputLight")
    assert not brightness(tmp_path).any()
    lamp("AREA").data.cycles.is_portal = True  # not rendered: Cycles 5.2 may crash on one without a world
    assert read().lights == ()


def test_fields_of_lights():
    spot = lamp("SPOT", "spot", spot_size=1.1, spot_blend=0.3, shadow_soft_size=0.25, use_soft_falloff=False)
    spot.data.use_shadow = False
    lamp("SUN", "sun", angle=0.4)
    lamp("AREA", "area", spread=0.7)
    spot, sun, area = read().lights
    assert (spot.kind, spot.soft_falloff, spot.shadow) == ("SPOT", False, False)
    assert (spot.spot_angle, spot.spot_blend, spot.radius) == pytest.approx((1.1, 0.3, 0.25))
    assert sun.angle == pytest.approx(0.4) and area.spread == pytest.approx(0.7)
    assert np.allclose(sun.matrix, bpy.data.objects["sun"].matrix_world)
