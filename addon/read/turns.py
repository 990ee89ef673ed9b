# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Turns with a living window, for what goes through a scene in Python on a thread of its own.

Python runs on one thread at a time. Whoever reads would get it back at once each time that the window, which draws its
panels in Python, has had it for a moment; so the reader rests after a while, as long as the window may need.
"""

import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")

# Seconds of work between two rests, at least, and how long a rest is beside what was worked.
_WORK, _REST = 0.01, 0.5

# Whether whoever reads on this thread is to stop; None where no window waits.
_stopped: ContextVar[Callable[[], bool] | None] = ContextVar("stopped", default=None)


class Stopped(Exception):
    """Nobody waits for it any longer."""


@contextmanager
def taken(stopped: Callable[[], bool]) -> Iterator[None]:
    """Takes turns with a window inside, until `stopped` says that nobody waits for it."""
    token = _stopped.set(stopped)
    try:
        yield
    finally:
        _stopped.reset(token)


def in_turns(things: Iterable[T]) -> Iterator[T]:
    """Things one after the other, with a rest now and then where turns are `taken`. Raises Stopped there."""
    stopped = _stopped.get()
    if stopped is None:
        yield from things
        return
    begin = time.perf_counter()
    for thing in things:
        yield thing
        if stopped():
            raise Stopped
        if (worked := time.perf_counter() - begin) > _WORK:
            time.sleep(worked * _REST)
            begin = time.perf_counter()
