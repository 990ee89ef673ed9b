# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance as an attribute of the original mesh, and the meshes that cannot take it."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.write.attributes import AttributeTargetError, write_irradiance

rng = np.random.default_rng(0)


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


@pytest.fixture
def cube():
    bpy.ops.mesh.primitive_cube_add()
    return bpy.context.object


def light(count=8):
    return (100 * rng.random((count, 3))).astype(np.float32)


def test_values_are_exact_and_reach_the_evaluated_mesh(cube):
    for expected in (light(), light()):  # the second time over the first
        write_irradiance({cube.name: expected})
        (attribute,) = [a for a in cube.data.attributes if a.name.startswith("gi_irradiance")]
        assert (attribute.data_type, attribute.domain) == ("FLOAT_COLOR", "POINT")
        evaluated = cube.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
        stored = np.empty((8, 4), np.float32)
        evaluated.attributes["gi_irradiance"].data.foreach_get("color", stored.ravel())
        assert np.array_equal(stored[:, :3], expected)
        assert (stored[:, 3] == 1).all()


def test_the_mesh_as_made_is_what_counts(cube):
    cube.modifiers.new("S", "SUBSURF")
    write_irradiance({cube.name: light()})
    with pytest.raises(
        AttributeTargetError, match=r"'Cube': light for 26 vertices does not fit its mesh of 8.*modifiers"
    ):
        write_irradiance({cube.name: light(26)})


def test_shared_mesh_names_the_objects(cube):
    bpy.context.collection.objects.link(bpy.data.objects.new("Twin", cube.data))
    with pytest.raises(AttributeTargetError, match="'Cube', 'Twin' share the mesh 'Cube'"):
        write_irradiance({cube.name: light()})


@pytest.mark.parametrize("clash", ["attribute", "uv", "group"])
def test_a_name_that_is_taken_is_refused_and_kept(cube, clash):
    if clash == "attribute":
        cube.data.attributes.new("gi_irradiance", "FLOAT", "FACE")
    elif clash == "uv":
        cube.data.uv_layers.new(name="gi_irradiance")
    else:
        cube.vertex_groups.new(name="gi_irradiance")
    before = [(a.name, a.data_type) for a in cube.data.attributes]
    with pytest.raises(AttributeTargetError, match=r"'Cube'.*'gi_irradiance': rename"):
        write_irradiance({cube.name: light()})
    assert [(a.name, a.data_type) for a in cube.data.attributes] == before


def test_all_are_checked_before_the_first_is_written(cube):
    bpy.ops.object.camera_add()
    with pytest.raises(AttributeTargetError, match="'Camera' has no mesh"):
        write_irradiance({cube.name: light(), "Camera": light()})
    assert "gi_irradiance" not in cube.data.attributes


def test_edit_mode(cube):
    bpy.ops.object.mode_set(mode="EDIT")
    with pytest.raises(AttributeTargetError, match="'Cube' is in edit mode"):
        write_irradiance({cube.name: light()})
