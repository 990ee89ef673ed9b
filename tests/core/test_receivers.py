# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import numpy as np
import pytest
from gi_bake.gi_core import receivers
from gi_bake.gi_core.atlas import Page, Place
from gi_bake.gi_core.receivers import Receiver, cut
from gi_bake.gi_core.surfels import Surfels
from gi_bake.gi_core.tiles import finish
from gi_bake.tests import shapes


def grid(name, width, height):
    """A receiver with a point at each place, on a plane."""

    def points(rows):
        place = np.arange(rows.start * width, rows.stop * width)
        position = np.stack([place % width, place // width, 0 * place], -1).astype(np.float32)
        up = np.broadcast_to(np.float32([0, 0, 1]), position.shape)
        return Surfels(position, up, up, 0 * position, 0 * position, place), place % 2 == 0

    return Receiver(name, width, height, points)


@pytest.mark.parametrize("points, margin, unit", [(10_000, 0, 1), (700, 0, 1), (100, 2, 1), (100, 4, 4), (1, 3, 2)])
def test_tiles_cover_each_row_once_with_their_margins(points, margin, unit):
    every = [grid("a", 20, 20), grid("b", 20, 7), grid("c", 8, 100), grid("d", 8, 3)]
    kept = {r.name: [] for r in every}
    for tile in cut(every, points, margin, unit):
        assert len({band.receiver.width for band in tile.bands}) == 1
        for band in tile.bands:
            kept[band.receiver.name] += range(band.kept.start, band.kept.stop)
            assert band.kept.start % unit == 0
            assert band.rows.start == max(0, band.kept.start - margin) or band.rows.start == band.kept.start == 0
            assert band.rows.stop >= min(band.receiver.height, band.kept.stop + min(margin, band.kept.start * margin))
    assert all(kept[r.name] == list(range(r.height)) for r in every)


def test_small_receivers_share_a_tile_and_their_points_know_their_places():
    [tile] = cut([grid("a", 4, 5), grid("b", 4, 3)], 1000, 0)
    assert tile.shape == (8, 4)
    points, place, centred = finish(tile.points())
    assert place.tolist() == list(range(32)) and points.place.tolist() == [*range(20), *range(12)]
    assert np.array_equal(centred, points.place % 2 == 0)
    assert [(r.name, (rows.start, rows.stop)) for r, rows, _ in tile.kept()] == [("a", (0, 5)), ("b", (5, 8))]


def test_bands_of_a_lightmap_are_the_rows_of_the_whole():
    tracer = shapes.tracer([shapes.plate(0, 1)])
    receiver = receivers.of_page(tracer.geometry, Page("plate", 32, 32, (Place("plate", "", 0, 0, 32),)))
    whole, _ = receiver.points(slice(0, 32))
    parts = [receiver.points(slice(k, k + 8))[0] for k in range(0, 32, 8)]
    assert np.array_equal(np.concatenate([p.place for p in parts]), whole.place)
    assert np.array_equal(np.concatenate([p.position for p in parts]), whole.position)


def test_guides_lie_on_the_objects_as_many_on_each():
    low, high = shapes.plate(0, 1), shapes.plate(1, 3, name="high")
    tracer = shapes.tracer([low, high])
    guides = receivers.guides(tracer, ["plate", "high"], None, 1000)
    assert len(guides) == 1000 and np.isclose((guides.position[:, 2] > 0.5).mean(), 0.5, atol=0.01)
    only = receivers.guides(tracer, ["high"], None, 100)
    assert (only.position[:, 2] > 0.5).all()
