# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core.atlas import Place
from gi_bake.gi_core.scene import Mesh
from gi_bake.gi_core.seams import Seams, disagreement, seams, stitched

ALL = np.ones((32, 32), bool)


def roof(tilt=0.0):
    """Two squares that share the edge x = 0, with vertices of their own there, and UVs that lie apart."""
    left = np.float32([[-1, 0, 0], [0, 0, 0], [0, 1, 0], [-1, 1, 0]])
    right = np.float32([[0, 0, 0], [1, 0, -tilt], [1, 1, -tilt], [0, 1, 0]])
    faces = np.array([[0, 1, 2], [0, 2, 3]])
    vertices, triangles = np.concatenate([left, right]), np.concatenate([faces, faces + 4]).astype(np.int32)
    corners = vertices[triangles]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    uv = np.concatenate([[[2, 2], [14, 2], [14, 14], [2, 14]], [[18, 18], [30, 18], [30, 30], [18, 30]]])[triangles]
    normals = np.repeat(normal[:, None], 3, 1).astype(np.float32)
    return Mesh("roof", vertices, triangles, normals, np.zeros(4, np.int32)), uv / 32, Place("roof", "", 0, 0, 32)


def test_a_smooth_cut_is_a_seam_and_an_edge_is_none():
    found = seams(*roof())
    assert len(found) == 24
    sides = sorted([found.first, found.second], key=lambda side: side[0, 0])
    assert np.allclose(sides[0][:, 0], 14) and np.allclose(sides[1][:, 0], 18)
    # The same height on either side, from end to end.
    assert np.allclose(sides[0][:, 1] - 2, sides[1][:, 1] - 18)
    assert np.allclose(np.sort(sides[0][:, 1]), 2 + (np.arange(24) + 0.5) / 2)
    assert len(seams(*roof(tilt=1.0))) == 0
    mesh, _, place = roof()
    # Where the map is whole there is nothing to close.
    uv = (mesh.vertices[mesh.triangles][..., :2] + 1) / 4
    assert len(seams(mesh, uv, place)) == 0


def test_stitching_makes_the_sides_agree_and_changes_little_else():
    found = seams(*roof())
    random = np.random.default_rng(3)
    image = random.uniform(0.9, 1.1, (32, 32, 3)).astype(np.float32)
    image[:, 16:] += 0.5
    before = disagreement(image, found)
    # Half on one side, one and a half times as much on the other.
    assert before == pytest.approx(0.4, abs=0.05)
    done = stitched(image, found, ALL, ~ALL)
    assert disagreement(done, found) <= 0.01
    touched = np.zeros((32, 32), bool)
    touched[2:14, 13:15] = touched[1:15, 13:15] = touched[17:31, 17:19] = True
    assert np.array_equal(done[~touched], image[~touched])
    # What the seam has in all stays: neither side is right.
    assert done[touched].mean() == pytest.approx(image[touched].mean(), rel=0.01)


def test_texels_beyond_the_seam_give_way_to_those_that_know_their_light():
    """Light that is one slope over both squares, found at texels' middles and grown one texel beyond."""
    found = seams(*roof())
    image, known = np.zeros((32, 32, 1), np.float32), np.zeros((32, 32), bool)
    column = np.arange(32)
    slope = np.where(column < 16, column - 14, column - 18) + 0.5
    slope[14:18] = [-0.5, -0.5, 0.5, 0.5]
    image[..., 0] = 1 + 0.06 * slope
    known[2:14, 2:14] = known[18:30, 18:30] = True
    assert disagreement(image, found) == pytest.approx(0.06, rel=0.05)
    alike, apart = (stitched(image, found, ALL, of) for of in (~ALL, known))
    assert disagreement(alike, found) <= 0.01 and disagreement(apart, found) <= 0.01
    moved = [np.abs(done - image)[known].max() for done in (alike, apart)]
    assert moved[0] > 0.01 and moved[1] < 0.25 * moved[0]


def test_what_is_lit_stays_lit():
    """Even where light changes from texel to texel so much that sides agree best with some below nothing."""
    found = seams(*roof())
    image = np.exp(np.random.default_rng(3).normal(0, 2, (32, 32, 3))).astype(np.float32)
    done = stitched(image, found, ALL, ~ALL)
    assert disagreement(done, found) < 0.25 * disagreement(image, found)
    assert (done >= image / 8).all()


def test_pairs_that_would_look_beyond_the_islands_are_left_out():
    found, image = seams(*roof()), np.zeros((32, 32, 1), np.float32)
    image[:, 16:] = 1
    filled = ALL.copy()
    filled[:, 14] = False
    assert np.array_equal(stitched(image, found, filled, filled), image)
    assert disagreement(image, Seams.concatenate([])) == 0


def test_layers_without_light_stay_dark_beside_others():
    image = np.zeros((16, 16, 2), np.float32)
    found = Seams(np.float32([[3, 8], [3, 10]]), np.float32([[12, 8], [12, 10]]))
    filled = np.ones((16, 16), bool)
    assert not stitched(image, found, filled, filled).any()
    image[:, :8, 1] = 1
    one = stitched(image, found, filled, filled)
    assert not one[..., 0].any() and disagreement(one, found) < 0.1 < disagreement(image, found)
