# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work cut into tiles: bounded memory, all cores, progress and cancelling between tiles."""

import os
import queue
import threading
from collections.abc import Callable, Iterator
from concurrent.futures import CancelledError, ThreadPoolExecutor
from functools import wraps

# How many cores are used; of the machine, as the cores are, and no setting: results do not depend on it.
_threads = [os.cpu_count()]


# Triangles, or edges, looked at in one go.
_PART = 1 << 20

# By thread: who asked it to work on a tile.
_asker = threading.local()


def use_threads(count: int) -> None:
    """From now on work is done on so many cores; 0 for all."""
    _threads[0] = count or os.cpu_count()


def slices(n: int, size: int) -> list[slice]:
    """Consecutive slices of at most `size` that cover range(n)."""
    size = max(1, size)
    return [slice(i, min(i + size, n)) for i in range(0, n, size)]


def parts(n: int) -> list[slice]:
    """Consecutive slices that cover range(n), short enough that what is made of one of a large mesh is soon gone."""
    return slices(n, _PART)


def run(function: Callable[[slice], None], parts: list[slice]) -> Iterator[float]:
    """Calls function(part) for each part on all cores, see `use_threads`; yields the share that is done, 0…1.

    The function writes its result into arrays of its own, so the order does not matter. Closing the generator waits for
    the tiles in flight and drops the rest; an error in a tile is raised here.
    """
    asker, left = _Asker(), len(parts)

    def tile(part: slice):
        try:
            function(part)
        finally:
            asker.wanted.put(None)

    with ThreadPoolExecutor(_threads[0], initializer=asker.adopts) as pool:
        futures = [pool.submit(tile, part) for part in parts]
        try:
            while left:
                # Waking up now and then, not at each tile's end, keeps a cancel prompt when one tile takes long.
                left -= asker.served(0.05)
                yield 1 - left / len(parts)
            for future in futures:
                future.result()
        finally:
            asker.gone = True
            for future in futures:
                future.cancel()
    yield 1.0


def on_asker(function: Callable[[], object]) -> object:
    """function() on the thread that all tiles around are worked on for; at once outside of tiles.

    For what only that thread reaches, as a graphics card. Raises CancelledError when that thread works no longer.
    """
    asker = getattr(_asker, "of_thread", None)
    return asker.ask(function) if asker else function()


class _Asker:
    """The thread that tiles are worked on for. wanted: what it is asked to do, None for a tile that ended.

    Queues and no futures, whose locks an interrupt may leave behind.
    """

    def __init__(self):
        self.wanted, self.gone = queue.SimpleQueue(), False

    def adopts(self) -> None:
        """The thread that calls it works for this one from now on."""
        _asker.of_thread = self

    def ask(self, function: Callable[[], object]) -> object:
        answer = queue.SimpleQueue()
        self.wanted.put((function, answer))
        while not self.gone:
            try:
                value, error = answer.get(timeout=0.05)
            except queue.Empty:
                continue
            if error:
                raise error
            return value
        raise CancelledError

    def served(self, seconds: float) -> int:
        """Waits for so long for one thing to do, and does it; how many tiles have ended."""
        try:
            asked = self.wanted.get(timeout=seconds)
        except queue.Empty:
            return 0
        if asked is None:
            return 1
        function, answer = asked
        try:
            # Which may itself work on a tile for another.
            answer.put((on_asker(function), None))
        except Exception as error:
            answer.put((None, error))
        return 0


def within(begin: float, end: float, work: Iterator[float]) -> Iterator[float]:
    """A part's progress as the whole's, which it takes from `begin` to `end`; returns the part's value."""
    return relayed(work, lambda fraction: begin + (end - begin) * fraction)


def named(stage: str, work: Iterator[float]) -> Iterator[tuple[str, float]]:
    """A stage's progress with its name before it; returns the work's value."""
    return relayed(work, lambda fraction: (stage, fraction))


def relayed(work: Iterator, told: Callable[[object], object]) -> Iterator:
    """Work whose steps are told on in other words, told(step); returns the work's value."""
    while True:
        try:
            step = next(work)
        except StopIteration as stop:
            return stop.value
        yield told(step)


def whole(steps: Callable[..., Iterator]) -> Callable:
    """A generator function as one that runs to the end and returns its value, for whoever does not wait in between."""

    @wraps(steps)
    def run(*arguments, **settings):
        return finish(steps(*arguments, **settings))

    return run


def finish(generator: Iterator) -> object:
    """Exhausts a generator and returns its value."""
    while True:
        try:
            next(generator)
        except StopIteration as stop:
            return stop.value
