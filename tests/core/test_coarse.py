# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light at coarse texels, between which a lightmap's texels take theirs."""

import numpy as np
import pytest
from gi_bake.gi_core import images
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
    layers["Coverage"] = np.ones((len(points), 1), np.float32)
    shape = (coarse.height, coarse.width)
    layers = {name: images.spread(values, points.place, shape) for name, values in layers.items()}
    fine = of_page(geometry, page)
    here, _ = fine.points(slice(0, fine.height))
    return here, *finish(Coarse(step, {page.name: layers}).at(NUMPY, fine, here))


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
