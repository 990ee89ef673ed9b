# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import threading

import pytest
from gi_bake.gi_core import tiles


def test_every_part_is_done_once_and_progress_rises():
    done = []
    shares = list(tiles.run(done.append, tiles.slices(10, 3)))
    assert sorted((s.start, s.stop) for s in done) == [(0, 3), (3, 6), (6, 9), (9, 10)]
    assert shares == sorted(shares) and shares[-1] == 1.0
    assert list(tiles.run(done.append, [])) == [1.0]


def test_an_error_in_a_tile_is_raised():
    def fail(part):
        raise ValueError("tile")

    with pytest.raises(ValueError, match="tile"):
        list(tiles.run(fail, tiles.slices(4, 1)))


def test_closing_drops_what_has_not_begun():
    begun, go = [], threading.Event()

    def work(part):
        begun.append(part)
        go.wait(5)

    running = tiles.run(work, tiles.slices(1000, 1))
    next(running)
    go.set()
    running.close()
    assert len(begun) < 1000
