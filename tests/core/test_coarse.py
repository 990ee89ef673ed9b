# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at coarse texels, between which a lightmap's texels take theirs."""

from dataclasses import replace

import numpy as np
import pytest
from gi_bake.gi_core import borders, images
from gi_bake.gi_core.atlas import Page, Place
from gi_bake.gi_core.coarse import Coarse
from gi_bake.gi_core.device import NUMPY
from gi_bake.gi_core.receivers import of_page
from gi_bake.gi_core.tiles import finish
from gi_bake.tests import shapes


def seen(geometry, page, step, light):
    """What the page's texels take of light at coarse ones: surfels, light (n, 3), whether they are sure of it (n,)."""
    coarse = of_page(geometry, page.coarser(step))
    points, _ = coarse.points(slice(0, coarse.height))
    layers = {"Indirect": light(points), "Position": points.position, "Normal": points.normal}
    layers |= {"Coverage": np.ones((len(points), 1)), "Centred": np.ones((len(points), 1))}
    layers["Inside"] = np.zeros((len(points), 1))
    shape = (coarse.height, coarse.width)
    layers = {name: images.spread(values, points.place, shape) for name, values in layers.items()}
    fine = of_page(geometry, page)
    here, _ = fine.points(slice(0, fine.height))
    light, sure, deep = finish(Coarse(step, {page.name: layers}).at(NUMPY, fine, here))
    assert not deep.any()
    return here, light, sure


@pytest.mark.parametrize("step", [2, 3, 4])
def test_between_coarse_texels_light_is_linear(step):
    geometry = shapes.tracer([shapes.plate(0, 1)]).geometry
    page = Page("plate", 40, 40, (Place("plate", "", 0, 0, 40),))
    here, light, sure = seen(geometry, page, step, lambda points: points.position)
    inside = ((here.place % 40 >= step) & (here.place % 40 < 40 - step)) & (
        (here.place // 40 >= step) & (here.place // 40 < 40 - step)
    )
    assert sure.all() and inside.sum() > 500
    np.testing.assert_allclose(light[inside], here.position[inside], atol=1e-5)


@pytest.mark.parametrize("step", [2, 4])
def test_no_light_crosses_to_another_surface(step):
    """Plates share an image with nothing between them, and with borders in the middle of coarse texels."""
    plates = [shapes.plate(z, 1, name=name) for z, name in ((0, "plate"), (5, "high"), (9, "speck"))]
    geometry = shapes.tracer(plates).geometry
    places = Place("speck", "", 21, 0, 1), Place("plate", "", 0, 0, 21), Place("high", "", 22, 0, 19)
    page = Page("page", 41, 21, places)
    here, light, sure = seen(geometry, page, step, lambda points: 1 + points.position[:, [2] * 3])
    assert np.abs(light - 1 - here.position[:, [2] * 3])[sure].max() < 0.01
    assert here.place[~sure].tolist() == [21], "its coarse texel is another's"


@pytest.mark.parametrize("step", [2, 4])
def test_the_foot_of_a_box_does_not_darken_the_floor_beside_it(step):
    """A solid box stands in a floor of even light; its border lies in the middle of coarse texels."""
    room = shapes.box(0.47, name="box")
    solid = replace(room, triangles=room.triangles[:, ::-1].copy(), normals=-room.normals[:, ::-1])
    tracer = shapes.tracer([shapes.plate(0, 1), solid])
    page = Page("plate", 64, 64, (Place("plate", "", 0, 0, 64),))
    coarse, fine = of_page(tracer.geometry, page.coarser(step)), of_page(tracer.geometry, page)
    points, centred = coarse.points(slice(0, coarse.height))
    beneath = (np.abs(points.position[:, :2]) < 0.47).all(1)
    layers = {
        "Indirect": np.where(beneath, 0, 1)[:, None] * np.ones(3), "Position": points.position,
        "Normal": points.normal, "Coverage": np.ones((len(points), 1)), "Centred": centred[:, None],
        "Inside": borders.inside(tracer, points)[:, None],
    }  # fmt: skip
    shape = (coarse.height, coarse.width)
    layers = {name: images.spread(values.astype(np.float32), points.place, shape) for name, values in layers.items()}
    here, _ = fine.points(slice(0, fine.height))
    light, sure, inside = finish(Coarse(step, {"plate": layers}).at(NUMPY, fine, here))
    beside = (np.abs(here.position[:, :2]) > 0.47).any(1)
    assert np.abs(light[beside & sure] - 1).max() < 1e-5 and sure[beside].mean() > 0.98
    # What lies beneath stays dark.
    deep = (np.abs(here.position[:, :2]) < 0.4).all(1)
    assert sure[deep].all() and not light[deep].any()
    assert inside[deep].mean() > 0.9 and not inside[beside].any()
    # Did nothing tell where coarse texels lie, some would take half of the darkness beneath.
    layers |= {"Inside": layers["Inside"] * 0, "Centred": np.ones_like(layers["Centred"])}
    dark, *_ = finish(Coarse(step, {"plate": layers}).at(NUMPY, fine, here))
    assert dark[beside].min() < 0.8
