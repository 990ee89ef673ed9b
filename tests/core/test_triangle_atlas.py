# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The atlas of triangles: what is sampled comes back, and nothing of another triangle."""

import numpy as np
import pytest
from gi_bake.gi_core.scene import Texture
from gi_bake.gi_core.texels import covered_texels
from gi_bake.gi_core.texture import sample
from gi_bake.gi_core.triangle_atlas import triangle_atlas


def soup(count, seed=0):
    """Triangles of every shape and size, some without an area."""
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(count, 3, 3)) * np.exp(rng.normal(size=(count, 1, 3)) * 1.5)
    corners[::17] = corners[::17, :1]
    return corners.astype(np.float32)


def sampled(atlas, values):
    """A linear function of corner `values` (t, 3, 3) at texel centres, as a renderer rasterises it; NaN elsewhere."""
    texels = covered_texels(atlas.sampled, (atlas.width, atlas.height))
    image = np.full((atlas.height * atlas.width, 3), np.nan)
    rows = texels.place[texels.centred]
    assert len(np.unique(rows)) == len(rows)
    image[rows] = np.einsum("nk,nkc->nc", texels.weights, values[texels.triangle])[texels.centred]
    return image.reshape(atlas.height, atlas.width, 3)


@pytest.mark.parametrize("texels", [1, 1 << 14, 1 << 18])
def test_a_linear_function_comes_back(texels):
    """Each triangle has a function of its own: what comes from another shows."""
    corners = soup(500)
    values = np.random.default_rng(1).random((500, 3, 3))
    atlas = triangle_atlas(corners, np.ones(500, bool), texels)
    image = sampled(atlas, values)
    atlas.complete(image)
    assert np.isfinite(image).all()
    weights = np.random.default_rng(2).dirichlet((0.5, 0.5, 0.5), (20, 500))
    for some in (*weights, np.broadcast_to(np.eye(3)[0], (500, 3)), np.broadcast_to((0, 0.5, 0.5), (500, 3))):
        uv = np.einsum("nk,nkc->nc", some, atlas.uvs)
        found = sample(Texture("", image.astype(np.float32), "EXTEND"), uv)
        error = np.abs(found - np.einsum("nk,nkc->nc", some, values))
        assert error.max() < 0.02 and error.mean() < 4e-3


def test_the_image_is_as_large_as_asked():
    corners = soup(500)
    for texels in (1 << 16, 1 << 20):
        atlas = triangle_atlas(corners, np.ones(500, bool), texels)
        assert texels / 5 < atlas.width * atlas.height < 3 * texels
    large = triangle_atlas(soup(20000), np.ones(20000, bool), 1)
    assert large.width * large.height < 12 * 20000


def test_detail_that_samples_do_not_show():
    """Nothing of a smooth function, all of noise, and of an edge as many texels as it crosses."""
    corners = np.float32([[(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1, 1, 0), (0, 1, 0), (1, 0, 0)]])
    atlas = triangle_atlas(corners, np.ones(2, bool), 1 << 16)
    x, y = np.meshgrid(np.arange(atlas.width) / atlas.width, np.arange(atlas.height) / atlas.height)
    rough = [atlas.roughness(np.dstack(3 * [values])) for values in (
        np.sin(6 * x) * y, np.random.default_rng(0).random(x.shape), (x % 0.25 > 0.1), (y % 0.25 > 0.1))]  # fmt: skip
    assert rough[0] == 0 and rough[1] > 0.8
    assert rough[2:] == pytest.approx([8 / atlas.width, 8 / atlas.height], rel=0.2)
    assert triangle_atlas(corners, np.ones(2, bool), 1).roughness(np.zeros((4, 4, 3))) == 0


def test_triangles_left_out_take_no_room():
    corners, kept = soup(100), np.arange(100) < 2
    atlas = triangle_atlas(corners, kept, 1)
    assert atlas.width * atlas.height <= 64
    assert (atlas.uvs[~kept] < 0).all() and (atlas.uvs[kept] >= 0).all() and (atlas.uvs[kept] <= 1).all()


def test_nothing_to_lay_out():
    atlas = triangle_atlas(np.zeros((0, 3, 3), np.float32), np.zeros(0, bool), 100)
    assert atlas.uvs.shape == (0, 3, 2) and atlas.width * atlas.height > 0
