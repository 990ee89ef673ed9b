# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core import scene as s
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.texture import sample
from gi_bake.tests import shapes


def test_a_mirrored_and_stretched_instance_keeps_its_front():
    mesh = shapes.quad((0, 0, 0), (1, 0, 0), (1, 1, 1), (0, 1, 1))
    for scale in ((1, 1, 1), (-1, 1, 1), (2, -3, 0.5), (-1, -1, -1)):
        matrix = np.diag([*scale, 1.0])
        scene = s.Scene((mesh,), (s.Instance("q", 0, matrix, (0,)),), (shapes.matte(),))
        geometry = Geometry(scene)
        weights = np.full((1, 3), 1 / 3, np.float32)
        face, shading = geometry.face_normal(np.array([0])), geometry.shading_normal(np.array([0]), weights)
        expected = np.linalg.inv(matrix[:3, :3]).T @ (0, -1, 1)
        assert np.allclose(face, expected / np.linalg.norm(expected), atol=1e-6)
        assert np.allclose(shading, face, atol=1e-6)


def test_instances_share_a_mesh_and_keep_their_own_materials():
    mesh = shapes.plate(0, 1)
    mesh = s.Mesh(mesh.name, mesh.vertices, mesh.triangles, mesh.normals, np.array([0, 1], np.int32), mesh.uvs, "UVMap")
    moved = np.eye(4)
    moved[0, 3] = 5
    instances = (s.Instance("a", 0, np.eye(4), (0, 1)), s.Instance("b", 0, moved, (2,)))
    geometry = Geometry(s.Scene((mesh,), instances, tuple(shapes.matte(a) for a in (0.1, 0.2, 0.3))))
    center = np.full((4, 3), 1 / 3, np.float32)
    # The last triangle's slot 1 is one that object b lacks: its last slot counts.
    assert np.allclose(geometry.color("albedo", np.arange(4), center)[:, 0], [0.1, 0.2, 0.3, 0.3])
    assert np.allclose(
        geometry.position(np.array([2]), center[:1])[0, 0] - geometry.position(np.array([0]), center[:1])[0, 0], 5
    )
    assert geometry.find("b") == 1
    with pytest.raises(KeyError, match="nobody"):
        geometry.find("nobody")
    assert np.isclose(geometry.area, 8)


def test_textures_are_looked_up_on_the_uv_map_that_is_named():
    mesh = shapes.plate(0, 1)
    other = {"Other": 0.5 * mesh.uvs["UVMap"], **mesh.uvs}
    mesh = s.Mesh(mesh.name, mesh.vertices, mesh.triangles, mesh.normals, mesh.slots, other, "UVMap")
    ramp = s.Texture(
        "ramp", np.broadcast_to(((np.arange(64) + 0.5) / 64)[None, :, None], (1, 64, 3)).astype(np.float32), "EXTEND"
    )
    for uv, factor in (("", 1), ("UVMap", 1), ("Other", 0.5), ("absent", 0)):
        material = s.Material("m", s.ColorSource(np.float32([1, 0.5, 0]), ramp, uv))
        geometry = Geometry(s.Scene((mesh,), (s.Instance("p", 0, np.eye(4), (0,)),), (material,)))
        color = geometry.color("albedo", np.array([0]), np.float32([[0.25, 0.5, 0.25]]))
        u = 0.75 * factor
        assert np.allclose(color, np.float32([[1, 0.5, 0]]) * max(u, 0.5 / 64), atol=1e-5)


@pytest.mark.parametrize("extension", ["REPEAT", "EXTEND", "CLIP", "MIRROR"])
def test_texture_lookup_outside(extension):
    pixels = np.zeros((2, 4, 3), np.float32)
    pixels[..., 0] = [[0, 1, 2, 3], [4, 5, 6, 7]]
    texture = s.Texture("t", pixels, extension, "CLOSEST")
    expected = {"REPEAT": 1, "EXTEND": 3, "CLIP": 0, "MIRROR": 2}[extension]
    assert sample(texture, np.float32([[1.4, 0.25]]))[0, 0] == expected
    smooth = s.Texture("t", pixels, extension, "LINEAR")
    assert np.allclose(sample(smooth, np.float32([[0.5, 0.5]]))[0, 0], 3.5)
