# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmap UVs made where they are missing, and many objects on one image."""

import bpy
import numpy as np
import pytest
from gi_bake.addon import layout, preflight
from gi_bake.addon.bake import bake, missing_uvs, receiving
from gi_bake.addon.job import Job
from gi_bake.addon.read import read_scene
from gi_bake.addon.write import lightmap_uvs
from gi_bake.addon.write.results import store
from gi_bake.gi_core import texels, tiles
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.rsm.settings import RsmSettings

NAME = lightmap_uvs.NAME


@pytest.fixture
def props(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("props")))
    return bpy.context.scene


def laid_out(scene, **job):
    """The job's pages with the UVs that it makes, and the geometry."""
    job = Job(target="lightmap", **job)
    view_layer = bpy.context.view_layer
    with lightmap_uvs.lent(missing_uvs(scene, view_layer, job)):
        core = read_scene(scene, view_layer)
    geometry = Geometry(core)
    return geometry, layout.pages(geometry, scene, receiving(core, job), job.uv, job.resolution, job.settings)


def islands(mesh, uvs):
    """A number for each triangle, the same where triangles meet at a corner on the UV map: (t,)."""
    keys = np.concatenate([mesh.triangles.reshape(-1, 1), np.round(uvs.reshape(-1, 2) * 1e5)], 1)
    _, corner = np.unique(keys, axis=0, return_inverse=True)
    corner = corner.reshape(-1, 3)
    label = np.arange(corner.max() + 1)
    while True:
        least = label[corner].min(1)
        new = label.copy()
        for k in range(3):
            np.minimum.at(new, corner[:, k], least)
        if np.array_equal(new, label):
            return least
        label = new


def test_sixty_objects_share_an_image_without_overlap_and_with_padding(props):
    settings = RsmSettings(atlas="all")
    geometry, [page] = laid_out(props, resolution=1024, settings=settings)
    # Sixty props, the room and its shelves.
    assert len(page.places) == 67
    parts, owner, base = [], [], 0
    for place in page.places:
        mesh, _ = geometry.mesh_of(place.name)
        uvs = mesh.uvs[place.uv]
        found = islands(mesh, uvs)
        parts.append(place.on(uvs, page.width, page.height))
        owner.append(found + base)
        base += found.max() + 1
    parts, owner = np.concatenate(parts), np.concatenate(owner)
    assert parts.min() >= 0 and parts.max() <= 1
    # The maps are free of overlaps; subdividing smooths them, and folds a ten-thousandth of Suzanne's eyes over.
    made = missing_uvs(props, bpy.context.view_layer, Job(target="lightmap", resolution=1024, settings=settings))
    for mesh, uvs in made.items():
        mesh.calc_loop_triangles()
        corners = np.array([triangle.loops[:] for triangle in mesh.loop_triangles])
        assert texels.overlap(uvs[corners], 1024) == 0
    assert texels.overlap(parts, 1024) < 1e-4
    covered = texels.covered_texels(parts, (1024, 1024))
    image = np.full(1024 * 1024, -1)
    image[covered.place] = owner[covered.triangle]
    image = image.reshape(1024, 1024)
    # Each island has the room that it grows into: two stay twice that apart, less what their borders take of texels.
    gap = 2 * settings.margin - 1
    close = 0
    for dy in range(gap + 1):
        for dx in range(-gap, gap + 1):
            a = image[dy:, max(dx, 0) : 1024 + min(dx, 0)]
            b = image[: 1024 - dy, max(-dx, 0) : 1024 - max(dx, 0)]
            close += np.count_nonzero((a >= 0) & (b >= 0) & (a != b))
    assert close == 0
    # The image is used well.
    assert (image >= 0).mean() > 0.4


def test_texels_are_as_dense_on_all_objects(props):
    geometry, [page] = laid_out(props, resolution=1024, settings=RsmSettings(atlas="all"))
    densities = []
    for place in page.places:
        mesh, triangles = geometry.mesh_of(place.name)
        uvs = mesh.uvs[place.uv].astype(np.float64) * place.side
        a, b = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
        area = np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2
        densities.append(np.sqrt(area / geometry.areas[triangles].sum()))
    assert np.max(densities) < 1.05 * np.min(densities)


def test_a_bake_leaves_the_file_alone_and_storing_it_adds_a_map_beside_the_artists(props):
    def maps():
        return {
            m.name: ([layer.name for layer in m.uv_layers], m.uv_layers.active_index, len(m.attributes))
            for m in bpy.data.meshes
        }

    ball, floor = (next(o for o in props.objects if o.name.startswith(kind)) for kind in ("Ball", "Floor"))
    artists = floor.data.uv_layers.new(name="Bricks")
    artists.uv.foreach_set("vector", np.tile(np.float32([0, 0, 4, 0, 4, 4, 0, 4]), len(floor.data.polygons)))
    tiled = lightmap_uvs.read(floor.data, "Bricks")
    before, scenes, meshes = maps(), len(bpy.data.scenes), len(bpy.data.meshes)
    names = (ball.name, floor.name)
    settings = RsmSettings(samples=2, map_resolution=32)
    job = Job(target="lightmap", objects=names, resolution=32, settings=settings)
    result = tiles.finish(bake(props, bpy.context.view_layer, job))
    assert maps() == before and (len(bpy.data.scenes), len(bpy.data.meshes)) == (scenes, meshes)
    assert list(result.light) == list(names) and all(light.valid.mean() > 0.05 for light in result.light.values())
    store(result, props)
    assert [layer.name for layer in floor.data.uv_layers] == ["Bricks", NAME]
    assert floor.data.uv_layers.active.name == "Bricks" and floor.data.uv_layers["Bricks"].active_render
    assert np.array_equal(lightmap_uvs.read(floor.data, "Bricks"), tiled)
    # They are there now, and are not made once more.
    assert missing_uvs(props, bpy.context.view_layer, job) == {}
    assert lightmap_uvs.make(props, bpy.context.view_layer, names) == []


def test_maps_are_made_where_there_is_none_to_bake_on(props):
    view_layer = bpy.context.view_layer
    objects = [o for o in props.objects if o.type == "MESH"]
    made = lightmap_uvs.make(props, view_layer, [o.name for o in objects[:3]])
    assert set(made) >= {o.name for o in objects[:3]}
    assert NAME in objects[0].data.uv_layers
    # What cannot be unwrapped is refused with a reason, what modifiers copy is found.
    bare = objects[3]
    bpy.context.view_layer.objects.active = bare
    bpy.ops.object.mode_set(mode="EDIT")
    job = Job(target="lightmap", objects=(bare.name,))
    with lightmap_uvs.lent(missing_uvs(props, view_layer, job)):
        [finding] = preflight.check(props, view_layer, target="lightmap", objects=job.objects)
    assert (finding.code, finding.object) == ("NO_UV_MAP", bare.name) and "edit mode" in finding.message
    bpy.ops.object.mode_set(mode="OBJECT")
    bare.modifiers.new("copies", "ARRAY")
    with lightmap_uvs.lent(missing_uvs(props, view_layer, job)):
        [finding] = preflight.check(props, view_layer, target="lightmap", objects=job.objects)
    assert finding.code == "UV_OVERLAP" and "100.0%" in finding.message


def test_objects_are_grouped_as_asked(props):
    _, pages = laid_out(props, resolution=512, settings=RsmSettings(atlas="collection"))
    assert len(pages) == len({o.users_collection[0] for o in props.objects if o.type == "MESH"})
    _, pages = laid_out(props, objects=("Floor", "Ball 03"), resolution=64)
    assert [page.name for page in pages] == ["Floor", "Ball 03"]
    _, [page] = laid_out(props, objects=("Floor", "Ball 03"), settings=RsmSettings(atlas="all", density=50))
    # Two metres of floor at 50 texels, and what is left.
    [floor] = [place for place in page.places if place.name == "Floor"]
    assert 100 <= floor.side <= 110 and page.width == 256
