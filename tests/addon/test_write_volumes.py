# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume in Blender: the file's grids against the arrays, and a monkey that is lit where it goes."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.write import volumes
from gi_bake.gi_core import sh
from gi_bake.gi_core.lpv import Level, LpvSettings, Volume
from gi_bake.gi_core.lpv.grid import Grid
from gi_bake.gi_core.lpv.lookup import coefficients

openvdb = pytest.importorskip("openvdb")


def level(low, cell, shape, seed, bands=9):
    grid = Grid(np.array(low, float), cell, shape)
    random = np.random.default_rng(seed).normal(0, 0.2, (grid.size, bands, 3)).astype(np.float32)
    random[:, 0] += 3
    return Level(grid, random)


VOLUME = Volume((level((-1, -1, 0), 0.25, (8, 8, 8), 1), level((-3, -3, -1), 0.5, (12, 12, 10), 2)))


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_empty=True)
    return bpy.context.scene


@pytest.mark.parametrize("half", [False, True])
def test_the_file_holds_the_grids(tmp_path, half):
    path = volumes.save_volume(tmp_path / "a.vdb", VOLUME, half)
    grids = {g.name: g for g in openvdb.readAllGridMetadata(str(path))}
    assert len(grids) == 20 and {"gi_irradiance", "gi_sh_0", "gi_sh_8", "gi_irradiance_1", "gi_sh_8_1"} <= set(grids)
    for name, k, source in (("gi_sh_3", 3, VOLUME.levels[1]), ("gi_sh_0_1", 0, VOLUME.levels[0])):
        grid = openvdb.read(str(path), name)
        back = np.zeros((*source.grid.shape, 3), np.float32)
        grid.copyToArray(back, ijk=(1, 1, 1))
        assert np.allclose(back.reshape(-1, 3), source.irradiance[:, k], rtol=2e-3 if half else 0, atol=1e-3 * half)
        assert np.allclose(grid.transform.indexToWorld((1, 2, 3)), source.grid.centres(np.array([0, 1, 2])))
    mean = openvdb.read(str(path), "gi_irradiance").getConstAccessor().getValue((1, 1, 1))
    assert np.allclose(mean, VOLUME.levels[1].irradiance[0, 0] * sh.Y0, rtol=2e-3)


def test_half_floats_take_less_room(tmp_path):
    full = volumes.save_volume(tmp_path / "full.vdb", VOLUME, False).stat().st_size
    assert volumes.save_volume(tmp_path / "half.vdb", VOLUME, True).stat().st_size < 0.8 * full


def expected(points, normals, volume=VOLUME):
    found = coefficients(None, volume.levels, LpvSettings(blend=2.0, propagation="flat"), points)
    return np.maximum(sh.evaluate(found, normals), 0)


def evaluated(obj):
    """World positions, world normals and the attribute of an object as it is evaluated: 3 × (n, 3)."""
    bpy.context.view_layer.update()
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    n = len(mesh.vertices)
    positions, normals, values = (np.empty((n, k), np.float32) for k in (3, 3, 4))
    mesh.vertices.foreach_get("co", positions.ravel())
    mesh.vertex_normals.foreach_get("vector", normals.ravel())
    mesh.attributes["gi_irradiance"].data.foreach_get("color", values.ravel())
    matrix = np.array(obj.matrix_world)
    normals = normals @ np.linalg.inv(matrix[:3, :3])
    world = positions @ matrix[:3, :3].T + matrix[:3, 3]
    return world.astype(np.float32), normals / np.linalg.norm(normals, axis=-1, keepdims=True), values[:, :3]


@pytest.mark.parametrize("volume", [VOLUME, Volume((level((-3, -3, -1), 0.5, (12, 12, 10), 3, bands=4),))])
def test_a_monkey_is_lit_where_it_is(scene, tmp_path, volume):
    volumes.store_volume(volumes.save_volume(tmp_path / "a.vdb", volume, False), volume, scene)
    bpy.ops.mesh.primitive_monkey_add(size=0.8)
    monkey = bpy.context.object
    volumes.light(monkey, scene)
    means = []
    for place, turn, scale in (((0, 0, 1), 0, 1), ((1.1, 0.5, 1.5), 1, 1), ((-1.5, -1, 2), 2, (1, 0.5, 1.3))):
        monkey.location, monkey.rotation_euler, monkey.scale = place, (0.3 * turn, 0, turn), np.broadcast_to(scale, 3)
        points, normals, values = evaluated(monkey)
        assert np.allclose(values, expected(points, normals, volume), rtol=1e-3, atol=1e-3), place
        means.append(values.mean(0))
    assert np.ptp(means, 0).max() > 0.005


def test_a_new_bake_replaces_the_old_one(scene, tmp_path):
    first = volumes.store_volume(volumes.save_volume(tmp_path / "a.vdb", VOLUME), VOLUME, scene)
    bpy.ops.mesh.primitive_monkey_add(size=0.8, location=(0, 0, 1))
    monkey = bpy.context.object
    volumes.light(monkey, scene)
    before = evaluated(monkey)[2].mean()
    brighter = Volume(tuple(replace(v, irradiance=2 * v.irradiance) for v in VOLUME.levels))
    again = volumes.store_volume(volumes.save_volume(tmp_path / "b.vdb", brighter), brighter, scene)
    assert again == first and len(bpy.data.volumes) == 1 and len(bpy.data.node_groups) == 1
    assert np.isclose(evaluated(monkey)[2].mean(), 2 * before, rtol=1e-2)


def test_without_openvdb_it_says_so(monkeypatch, tmp_path):
    monkeypatch.setattr(volumes, "available", lambda: False)
    with pytest.raises(volumes.NoOpenVDB, match="openvdb"):
        volumes.save_volume(tmp_path / "a.vdb", VOLUME)
