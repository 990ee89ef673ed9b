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


def test_a_tile_asks_the_thread_that_works_for_it():
    here, found = threading.get_ident(), []

    def ask(part):
        found.append((threading.get_ident(), tiles.on_asker(threading.get_ident)))

    def work(part):
        ask(part)
        tiles.finish(tiles.run(ask, tiles.slices(2, 1)))

    assert tiles.on_asker(threading.get_ident) == here
    tiles.finish(tiles.run(work, tiles.slices(4, 1)))
    assert len(found) == 12
    assert all(asked == here and at != here for at, asked in found)


def test_an_error_of_what_a_tile_asks_for_is_the_tiles():
    def fail():
        raise ValueError("asked")

    caught = []

    def work(part):
        try:
            tiles.on_asker(fail)
        except ValueError as error:
            caught.append(error)
            raise

    with pytest.raises(ValueError, match="asked"):
        tiles.finish(tiles.run(work, tiles.slices(1, 1)))
    assert len(caught) == 1


def test_closing_lets_tiles_go_that_wait_for_an_answer():
    ended, waits = [], threading.Event()

    def work(part):
        waits.set()
        try:
            while True:
                tiles.on_asker(lambda: None)
        finally:
            ended.append(part)

    running = tiles.run(work, tiles.slices(1, 1))
    next(running)
    assert waits.wait(5)
    running.close()
    assert len(ended) == 1
