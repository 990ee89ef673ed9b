# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake of lightmaps leaves: directional images, files in the encodings asked for, objects kept apart."""

import re
from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon import preflight
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import lightmap_reference
from gi_bake.addon.job import Job
from gi_bake.addon.read import read_scene
from gi_bake.addon.write import hookup, lightmap_uvs
from gi_bake.addon.write.placement import placement
from gi_bake.addon.write.results import export, lightmaps, store
from gi_bake.gi_core import exr, sh, surfels, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.rsm.settings import RsmSettings


@pytest.fixture
def cornell(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    return bpy.context.scene


def baked(scene, *objects, resolution=24, **settings):
    settings = RsmSettings(samples=8, map_resolution=64, **settings)
    job = Job(target="lightmap", objects=objects, resolution=resolution, settings=settings)
    return tiles.finish(bake(scene, bpy.context.view_layer, job))


def test_directional_lightmaps_are_the_lightmap_at_the_surfaces_normal(cornell, tmp_path):
    result = baked(cornell, "Floor", "Tall box", directional=True, denoise="none", stitch=False)
    geometry = Geometry(read_scene(cornell, bpy.context.view_layer))
    assert list(result.light) == ["Floor", "Tall box"]
    for page in result.pages:
        points, _ = surfels.from_texels(geometry, page.name, "", (24, 24))
        row, column = np.divmod(points.place, 24)
        light = result.light[page.name]
        plain = lightmaps(result)[page.name][row, column, :3]
        # Where a texel lies inside of something it was made up for each by itself.
        open_ = light.centred[row, column]
        found = sh.evaluate(light.directional[row, column], points.normal)
        assert open_.mean() > 0.5 and np.allclose(found[open_], plain[open_], rtol=1e-3, atol=1e-4)
    # Light comes from above: of normals that lean away from the floor's there is less.
    up, side = (sh.evaluate(result.light["Floor"].directional, np.float32(n)) for n in ((0, 0, 1), (1, 0, 0)))
    assert side.mean() < up.mean()
    paths = export(result, tmp_path, "ViewLayer")
    names = {p.name for p in paths}
    assert {f"Floor SH {k}.exr" for k in range(4)} <= names and len(names) == 12
    c0 = exr.read_layers(tmp_path / "Floor SH 0.exr")["Combined"]
    filled = result.light["Floor"].filled
    assert np.allclose(c0[filled], result.light["Floor"].directional[filled][:, 0], atol=1e-6)
    assert "Floor SH 3" in store(result, cornell)


def test_files_are_written_as_the_settings_say(cornell, tmp_path):
    result = baked(cornell, "Floor", encoding="rgbm", exr="half")
    export(result, tmp_path, "ViewLayer")
    assert b"linear = rgb * alpha *" in (tmp_path / "Floor Lightmap.png").read_bytes()
    whole = lightmaps(result)["Floor"]
    half = exr.read_layers(tmp_path / "Floor Lightmap.exr")["Combined"]
    assert np.allclose(half, whole, rtol=1e-3, atol=1e-6) and not np.array_equal(half, whole)


class Options:
    """Stands for `Object.gi_bake`, by object."""

    def __init__(self, monkeypatch, **told):
        from gi_bake.addon import by_method, layout, object_options
        from gi_bake.addon.read import objects
        from gi_bake.addon.write import lightmap_uvs

        def options(obj):
            return object_options.ObjectOptions(**told.get(obj.name.replace(" ", "_"), {}))

        for module in (by_method, layout, objects, lightmap_uvs):
            monkeypatch.setattr(module, "object_options", options)


def test_objects_that_only_cast_or_only_receive(cornell, monkeypatch):
    everything = baked(cornell, denoise="none").light
    Options(monkeypatch, Tall_box={"use": False})
    light = baked(cornell, denoise="none").light
    assert set(light) == set(everything) - {"Tall box"}
    assert np.allclose(light["Floor"].direct, everything["Floor"].direct)
    Options(monkeypatch, Tall_box={"casts": False})
    light = baked(cornell, denoise="none").light
    assert set(light) == set(everything) and light["Tall box"].direct.any()
    # No shadow of it on the floor, and none where it stands.
    assert light["Floor"].direct.sum() > 1.05 * everything["Floor"].direct.sum()
    Options(monkeypatch, Tall_box={"use": False, "casts": False})
    without = baked(cornell, denoise="none").light
    assert "Tall box" not in without and np.allclose(without["Floor"].direct, light["Floor"].direct)


def test_objects_have_a_resolution_and_a_group_of_their_own(cornell, monkeypatch):
    Options(
        monkeypatch, Floor={"lightmap_factor": 2.0}, Ceiling={"lightmap_group": "above"},
        Tall_box={"lightmap_group": "above"},
    )  # fmt: skip
    result = baked(cornell, "Floor", "Ceiling", "Tall box")
    assert {page.name: page.width for page in result.pages} == {"Floor": 48, "above": 24}
    assert [p.name for p in result.pages[1].places] == ["Ceiling", "Tall box"]


def test_objects_have_a_technique_of_their_own(cornell, monkeypatch):
    """On one lightmap, some lit by a volume and one by a reflective shadow map."""
    view_layer, names = bpy.context.view_layer, ("Floor", "Tall box", "Short box")
    settings = LpvSettings(samples=8, light_samples=2, cells=16, cascades=1, map_resolution=64, atlas="all", margin=2)

    def run(**more):
        job = Job("lpv", "lightmap", names, 64, settings=replace(settings, **more))
        return tiles.finish(bake(cornell, view_layer, job))

    plain = run()
    Options(monkeypatch, Tall_box={"method": "rsm"})
    asked, inspecting = [], preflight.inspecting
    monkeypatch.setattr(preflight, "inspecting", lambda *a, **k: asked.append(a) or inspecting(*a, **k))
    mixed = run()
    assert len(asked) == 1  # both parts are of the file as it was at the start
    assert mixed.pages == plain.pages and set(mixed.hashes) == set(names)
    [page] = mixed.pages
    before, after = plain.light[page.name], mixed.light[page.name]
    assert np.array_equal(before.valid, after.valid) and np.array_equal(before.filled, after.filled)
    for place in page.places:
        square = np.zeros_like(before.valid)
        square[place.y : place.y + place.side, place.x : place.x + place.side] = True
        # The surrounding objects' borders may reach into the square, but not onto the object.
        own = before.valid & square
        same = np.isclose(before.indirect[own], after.indirect[own], rtol=1e-3, atol=1e-5).all(-1)
        if place.name == "Tall box":
            lit = before.indirect[own].max(-1) > 1e-3
            assert same[lit].mean() < 0.1 and mixed.hashes[place.name] != plain.hashes[place.name]
            # Another technique, but the same light.
            assert after.indirect[own].mean() == pytest.approx(before.indirect[own].mean(), rel=0.25)
        else:
            assert same.mean() > 0.99 and mixed.hashes[place.name] == plain.hashes[place.name]
    # A change of technique is a change of the object, and of it alone.
    store(mixed, cornell)
    assert not run(rebake="changed").light
    Options(monkeypatch)
    again = run(rebake="changed")
    assert "gather" in again.stages and np.allclose(lightmaps(again)[page.name], lightmaps(plain)[page.name], atol=0.02)


def test_vertices_have_their_objects_technique(cornell, monkeypatch):
    Options(monkeypatch, Tall_box={"method": "lpv"})
    settings = RsmSettings(samples=16, map_resolution=64, light="indirect")
    job = Job(target="vertices", objects=("Tall box", "Short box"), settings=settings)
    result = tiles.finish(bake(cornell, bpy.context.view_layer, job))
    assert set(result.light) == {"Tall box", "Short box"} and result.job == job
    assert any(text.startswith("volume") for text in result.warnings)
    Options(monkeypatch)
    plain = tiles.finish(bake(cornell, bpy.context.view_layer, job))
    same = {name: np.allclose(light.indirect, plain.light[name].indirect) for name, light in result.light.items()}
    assert not same["Tall box"]
    assert not any(text.startswith("volume") for text in plain.warnings)


def test_only_changed_objects_are_baked_again(cornell):
    settings = {"atlas": "all", "resolution": 96}
    first = baked(cornell, **settings)
    store(first, cornell)
    same = baked(cornell, rebake="changed", **settings)
    assert not same.light and "gather" not in same.stages
    assert np.array_equal(lightmaps(same)["Scene"], lightmaps(first)["Scene"])
    bpy.data.objects["Tall box"].location.z += 0.1
    again = baked(cornell, rebake="changed", **settings)
    [page] = again.pages
    assert page == first.pages[0]
    before, after = lightmaps(first)["Scene"], lightmaps(again)["Scene"]
    changed = (before != after).any(-1)
    [place] = [place for place in page.places if place.name == "Tall box"]
    rows, columns = np.nonzero(changed)
    assert len(rows) > 50
    margin = 2
    assert rows.min() >= place.y - margin and rows.max() < place.y + place.side + margin
    assert columns.min() >= place.x - margin and columns.max() < place.x + place.side + margin
    store(again, cornell)
    assert not baked(cornell, rebake="changed", **settings).light
    # A lamp changes all, and so does a setting.
    lamp = next(o for o in cornell.objects if o.type == "LIGHT")
    lamp.data.energy *= 2
    assert {p.name for page in baked(cornell, rebake="changed", **settings).pages for p in page.places} == set(
        first.hashes
    )
    assert baked(cornell, rebake="changed", **settings).light["Scene"].valid.sum() == first.light["Scene"].valid.sum()


def test_clearing_takes_all_that_a_bake_left(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("props")))
    scene = bpy.context.scene

    def state():
        objects = {o.name: sorted(o.keys()) for o in bpy.data.objects}
        meshes = {m.name: [layer.name for layer in m.uv_layers] for m in bpy.data.meshes}
        return objects, meshes, sorted(i.name for i in bpy.data.images), sorted(g.name for g in bpy.data.node_groups)

    before = state()
    names = ("Floor", "Ball 03", "Cylinder 04")
    result = baked(scene, *names, atlas="all", resolution=64, directional=True)
    for images_too in (False, True):
        store(result, scene)
        hookup.apply(scene)
        assert state() != before and placement(scene.objects["Floor"]).image.name == "Scene Lightmap"
        if images_too:  # by the user
            bpy.data.batch_remove([image for image in bpy.data.images if image.name not in before[2]])
        assert hookup.clear(scene) == sorted(names, key=[o.name for o in scene.objects].index)
        assert state() == before


def test_light_at_corners_keeps_hard_edges(cornell):
    settings = RsmSettings(samples=8, map_resolution=64, domain="corner")
    job = Job(target="vertices", objects=("Tall box",), settings=settings)
    result = tiles.finish(bake(cornell, bpy.context.view_layer, job))
    assert store(result, cornell) == ["Tall box"]
    mesh = bpy.data.objects["Tall box"].data
    attribute = mesh.attributes["gi_irradiance_corner"]
    assert (attribute.data_type, attribute.domain) == ("FLOAT_COLOR", "CORNER")
    values = np.empty((len(mesh.loops), 4), np.float32)
    attribute.data.foreach_get("color", values.ravel())
    faces = [values[p.loop_start : p.loop_start + p.loop_total, :3].mean() for p in mesh.polygons]
    top = max(mesh.polygons, key=lambda p: p.normal.z).index
    # The lamp is above: at the same vertices the top is bright and the sides are not.
    assert faces[top] > 1.5 * np.median(faces)
    light = result.light["Tall box"]
    assert len(light.direct) == 3 * len(mesh.loop_triangles)
    whole = np.pi * (light.direct + light.indirect)
    [triangle] = [t for t in mesh.loop_triangles if t.index == 0]
    corner = triangle.loops[1]
    of_corner = [3 * t.index + k for t in mesh.loop_triangles for k in range(3) if t.loops[k] == corner]
    assert np.allclose(values[corner, :3], whole[of_corner].mean(0), rtol=1e-4)


def test_sixty_objects_have_clean_edges(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("props")))
    result = baked(bpy.context.scene, atlas="all", resolution=512, light_samples=2)
    [note] = [text for text in result.warnings if text.startswith("seams")]
    after, before = (float(share) / 100 for share in re.findall(r"([\d.]+)%", note))
    assert after <= 0.01 < 0.05 < before
    [light] = result.light.values()
    total = (light.direct + light.indirect).sum(-1)
    # Of what is up in the room nothing is black, be it that a face only grazes a texel or lies in another object.
    assert np.count_nonzero(light.valid & ~light.centred) > 1000
    assert light.filled[light.valid].all() and not total[~light.filled].any()


def test_what_cycles_lights_is_not_black(sample):
    """Nor what is next to it on the map: not even where a face only grazes a texel, which Cycles leaves out, where
    things stand on each other, or where a seam is closed."""
    bpy.ops.wm.open_mainfile(filepath=str(sample("props")))
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    # A wall that shelves run into, and shapes with many seams in deep shadow.
    names = ("Back wall", "Cube 05", "Torus 46", "Suzanne 36")
    job = Job(target="lightmap", objects=names, resolution=64, settings=RsmSettings(map_resolution=128))
    result = tiles.finish(bake(scene, view_layer, job))
    uvs = {page.name: page.places[0].uv for page in result.pages}
    with lightmap_uvs.lent({bpy.data.meshes[name]: uv for name, uv in result.uvs.items()}):
        reference = lightmap_reference(scene, view_layer, uvs, 64, 16, 1, 0, ("DIRECT", "INDIRECT"))
    for name, light in result.light.items():
        around = np.pad(reference[name][..., :3].sum(-1), 1)
        lit = light.valid & np.any([around[i : i + 64, j : j + 64] > 0 for i in range(3) for j in range(3)], axis=0)
        assert lit.sum() > 1000
        assert ((light.direct + light.indirect)[lit].max(-1) > 0).all(), name
