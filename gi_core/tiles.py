# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Long work cut into tiles: bounded memory, all cores, progress and cancelling between tiles."""

import os
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait

# How many cores are used; of the machine, as the cores are, and no setting: results do not depend on it.
_threads = [os.cpu_count()]


def use_threads(count: int) -> None:
    """From now on work is done on so many cores; 0 for all."""
    _threads[0] = count or os.cpu_count()


def slices(n: int, size: int) -> list[slice]:
    """Consecutive slices of at most `size` that cover range(n)."""
    size = max(1, size)
    return [slice(i, min(i + size, n)) for i in range(0, n, size)]


def run(function: Callable[[slice], None], parts: list[slice]) -> Iterator[float]:
    """Calls function(part) for each part on all cores, see `use_threads`; yields the share that is done, 0…1.

    The function writes its result into arrays of its own, so the order does not matter. Closing the generator waits for
    the tiles in flight and drops the rest; an error in a tile is raised here.
    """
    with ThreadPoolExecutor(_threads[0]) as pool:
        futures = [pool.submit(function, part) for part in parts]
        try:
            # Waking up now and then, not at each tile's end, keeps a cancel prompt when one tile takes long.
            while waiting := [f for f in futures if not f.done()]:
                wait(waiting[:1], timeout=0.05)
                yield 1 - len(waiting) / len(parts)
            for future in futures:
                future.result()
        finally:
            for future in futures:
                future.cancel()
    yield 1.0


def within(begin: float, end: float, work: Iterator[float]) -> Iterator[float]:
    """A part's progress as the whole's, which it takes from `begin` to `end`; returns the part's value."""
    while True:
        try:
            yield begin + (end - begin) * next(work)
        except StopIteration as stop:
            return stop.value


def named(stage: str, work: Iterator[float]) -> Iterator[tuple[str, float]]:
    """A stage's progress with its name before it; returns the work's value."""
    while True:
        try:
            yield stage, next(work)
        except StopIteration as stop:
            return stop.value


def finish(generator: Iterator) -> object:
    """Exhausts a generator and returns its value."""
    while True:
        try:
            next(generator)
        except StopIteration as stop:
            return stop.value
