# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at vertices and corners against Cycles' bake to colour attributes, on hard edges too."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare import compare, reference
from gi_bake.addon.compare.reference_scene import reference_scene
from gi_bake.addon.job import Job
from gi_bake.addon.write.attributes import loops_of
from gi_bake.gi_core import tiles
from gi_bake.gi_core.rsm.settings import RsmSettings

# A crate and a stool that stand a millimetre deep in the floor, a table of boxes.
NAMES = ("Crate", "Stool", "Table")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """One for both domains, so that Cycles bakes once."""
    return tmp_path_factory.mktemp("reference")


def baked(sample, *names, **settings):
    bpy.ops.wm.open_mainfile(filepath=str(sample("sunlit_room")))
    settings = {"samples": 512, "map_resolution": 256, "light_samples": 8, **settings}
    job = Job(target="vertices", objects=names, settings=RsmSettings(**settings))
    return tiles.finish(bake(bpy.context.scene, bpy.context.view_layer, job))


@pytest.mark.parametrize("domain", ["point", "corner"])
def test_objects_with_hard_edges_have_cycles_light(sample, folder, domain):
    result = baked(sample, *NAMES, domain=domain)
    report = compare(result, bpy.context.scene, bpy.context.view_layer, 512, folder)
    found = report.metrics["rsm"]
    assert {name for name in found if "and" not in name} == {f"{n}, {k}" for n in NAMES for k in ("direct", "indirect")}
    for name, measured in found.items():
        assert abs(measured["bias"]) < 0.04 and measured["relmse"] < 0.01, (name, measured)


def test_a_vertex_is_what_cycles_makes_of_its_corners(sample):
    result = baked(sample, "Globe", light="indirect", samples=192)
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    obj = bpy.data.objects["Globe"]
    obj.data.attributes.new("Cycles", "FLOAT_COLOR", "POINT")
    obj.data.attributes.active_color_name = "Cycles"
    with reference_scene(scene, view_layer, 128, result.job.settings.bounces, 1) as (copy, layer):
        reference._bake(copy, layer, obj, ("INDIRECT",), target="VERTEX_COLORS")
    theirs = np.empty((len(obj.data.vertices), 4), np.float32)
    obj.data.attributes["Cycles"].data.foreach_get("color", theirs.ravel())
    ours = result.light["Globe"].indirect
    assert ours.mean() == pytest.approx(theirs[:, :3].mean(), rel=0.03)
    assert np.corrcoef(ours.mean(-1), theirs[:, :3].mean(-1))[0, 1] > 0.98


def test_the_foot_of_a_crate_in_the_floor_is_not_black(sample):
    for domain in ("point", "corner"):
        result = baked(sample, "Crate", domain=domain, samples=64)
        assert any(text.startswith("inside") for text in result.warnings)
        light = result.light["Crate"]
        obj = bpy.data.objects["Crate"]
        height = np.array([v.co.z for v in obj.data.vertices])
        if domain == "point":
            assert (light.direct + light.indirect)[height == 0].min(0).max() > 0.01
            assert not light.centred[height == 0].any() and light.centred[height > 0].all()
        else:
            vertex = light.corners.vertex
            sides = np.abs(np.array([p.normal.z for p in obj.data.polygons])) < 0.5
            side = sides[np.array([t.polygon_index for t in obj.data.loop_triangles])].repeat(3)
            foot = side & (height[vertex] == 0)
            assert not light.known[foot].any() and foot.sum() == 12
            # What is filled is no brighter than what it is filled from.
            assert 0.01 < (light.direct + light.indirect)[foot].max() <= (light.direct + light.indirect)[side].max()


def test_corners_find_their_faces_where_a_modifier_has_turned_the_diagonals():
    bpy.ops.wm.read_homefile(use_empty=True)
    mesh = bpy.data.meshes.new("kite")
    mesh.from_pydata([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)], [], [(0, 1, 2, 3)])
    obj = bpy.data.objects.new("kite", mesh)
    bpy.context.collection.objects.link(obj)
    obj.shape_key_add(name="Basis")
    key = obj.shape_key_add(name="bent", from_mix=False)
    key.data[1].co = (0.3, 0.7, 0.0)  # beyond the diagonal that the square is cut along
    key.value = 1
    bent = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).to_mesh()
    bent.calc_loop_triangles()
    mesh.calc_loop_triangles()
    triangles = np.array([t.vertices[:] for t in bent.loop_triangles])
    assert not np.array_equal(triangles, [t.vertices[:] for t in mesh.loop_triangles])
    assert loops_of(obj, triangles.ravel()).tolist() == triangles.ravel().tolist()
    with pytest.raises(ValueError, match="light for 1 triangles does not fit its mesh of 2"):
        loops_of(obj, triangles[:1].ravel())


def test_corners_of_one_surface_have_the_same_noise(sample):
    result = baked(sample, "Globe", domain="corner", samples=8, light="indirect")
    light = result.light["Globe"]
    mean = np.bincount(light.corners.point, light.indirect.mean(-1)) / np.bincount(light.corners.point)
    apart = np.abs(light.indirect.mean(-1) - mean[light.corners.point])
    # The noise itself, between vertices and the same seen with many samples, is far larger.
    many = baked(sample, "Globe", domain="corner", samples=96, light="indirect").light["Globe"].indirect.mean(-1)
    assert apart.mean() < 0.1 * np.abs(light.indirect.mean(-1) - many).mean()
