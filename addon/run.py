# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake or a comparison on its way beside a living user interface.

Its steps are taken one after the other, those that touch Blender on the main thread and the others on a thread of
their own: a step may last longer than a picture of the interface should, and cannot be cut where numpy or Embree works.
"""

import threading
import time
from collections.abc import Callable, Collection, Iterator
from concurrent.futures import Future
from contextvars import ContextVar
from typing import TypeVar

T = TypeVar("T")

# The run that a step belongs to; None where work is done in one go, as scripts do it.
current: ContextVar["Run | None"] = ContextVar("run", default=None)


def aside(function: Callable[[], T]) -> Iterator[float]:
    """`function()`, which touches nothing of Blender, out of a step on the main thread: beside a living window on a
    thread of its own. A generator of progress; returns its value."""
    beside = current.get()
    if beside is None:
        return function()
    made = Future()

    def work():
        try:
            made.set_result(function())
        except BaseException as error:
            made.set_exception(error)

    threading.Thread(target=work, name="GI Bake", daemon=True).start()
    beside.wait(made.done)
    yield 0.0
    return made.result()


class Run:
    """work: a generator of (fraction, stage). on_main: whether the step after a stage belongs on the main thread.
    holding: stages after which the work still knows parts of the file that an undo would take away.

    fraction, stage: how far it is. When it has `ended`, there is a `value`, or an `error`, or it was `cancelled`.
    """

    def __init__(
        self, work: Iterator[tuple[float, str]], on_main: Callable[[str], bool], holding: Collection[str] = ()
    ):
        self.fraction, self.stage = 0.0, ""
        self.value, self.error = None, None
        self.ended = self.cancelled = False
        self.begin = time.perf_counter()
        self._work, self._on_main, self._holding = work, on_main, holding
        self._thread: threading.Thread | None = None
        self._until: Callable[[], bool] | None = None
        self._stop = threading.Event()

    @property
    def seconds(self) -> float:
        """Since the beginning."""
        return time.perf_counter() - self.begin

    @property
    def holds_file(self) -> bool:
        """Whether it still knows parts of the file."""
        return not self.stage or self.stage in self._holding

    @property
    def seconds_left(self) -> float | None:
        """About how long it still takes; None before there is anything to tell it by."""
        known = self.fraction > 0.02 and self.seconds > 0.5
        return self.seconds * (1 - self.fraction) / self.fraction if known else None

    def wait(self, until: Callable[[], bool]) -> None:
        """Called from a step: the next one is taken when `until` says so, which is asked once in a while."""
        self._until = until

    def advance(self, seconds: float = 0.05) -> bool:
        """Goes on for about so long, or looks how the other thread is getting on; whether all has ended.

        Call it on the main thread.
        """
        until = time.perf_counter() + seconds
        while not self.ended and time.perf_counter() < until:
            if self._stop.is_set():
                self.close()
            elif self._thread:
                self._thread.join(max(0.0, min(0.005, until - time.perf_counter())))
                if self._thread.is_alive():
                    break
                self._thread = None
            elif self._until and not self._until():
                break
            elif self.stage and not self._on_main(self.stage):
                # A daemon: a Blender that quits waits for no bake.
                self._thread = threading.Thread(target=self._aside, name="GI Bake", daemon=True)
                self._thread.start()
            else:
                self._step()
        return self.ended

    def cancel(self) -> None:
        """Ends it; `advance` tells when."""
        self._stop.set()

    def close(self) -> None:
        """Ends it now. What another thread is at it finishes by itself, for nobody: it touches nothing of Blender's."""
        self._stop.set()
        if not self.ended:
            self.cancelled = self.ended = True
            if not self._thread:
                self._work.close()

    def _aside(self) -> None:
        while not (self.ended or self._stop.is_set() or self._on_main(self.stage)):
            self._step()
        if self._stop.is_set():
            # Here and not where it was cancelled, since closing waits for what is in flight.
            self._work.close()

    def _step(self) -> None:
        self._until, token = None, current.set(self)
        try:
            fraction, stage = next(self._work)
        except StopIteration as stop:
            self._end(stop.value, None)
        except Exception as error:
            self._end(None, error)
        else:
            self.fraction, self.stage = fraction, stage
        finally:
            current.reset(token)

    def _end(self, value: object, error: Exception | None) -> None:
        if not self.ended:
            self.value, self.error, self.ended = value, error, True
