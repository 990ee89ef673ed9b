# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where a bake's time goes, and how far it is."""

import time
from collections.abc import Iterator
from contextlib import contextmanager


class Stages:
    """Seconds by stage."""

    def __init__(self):
        self.seconds: dict[str, float] = {}

    @contextmanager
    def time(self, name: str):
        """Adds what happens inside to a stage."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin

    def announced(self, work: Iterator[tuple[str, float]], done: float = 0.0) -> Iterator[tuple[float, str]]:
        """Work that yields (stage, fraction of the stage) before it goes on with that stage, as (done, stage); returns
        its value."""
        stage = ""
        while True:
            begin = time.perf_counter()
            try:
                following, _ = next(work)
            except StopIteration as stop:
                self._add(stage, begin)
                return stop.value
            self._add(stage, begin)
            stage = following
            yield done, stage

    def _add(self, stage: str, begin: float) -> None:
        if stage:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - begin

    def follow(
        self, work: Iterator[tuple[str, float]], begin: float, share: float, stages: dict[str, float]
    ) -> Iterator[tuple[float, str]]:
        """Work that yields (stage, fraction of the stage), as (fraction of all, stage); returns its value.

        begin, share: where the work begins and what it takes of all. stages: what each takes of the work.
        """
        done, latest, furthest, since = 0.0, "", 0.0, time.perf_counter()
        try:
            while True:
                stage, fraction = next(work)
                now = time.perf_counter()
                self.seconds[stage] = self.seconds.get(stage, 0.0) + now - since
                if stage != latest:
                    done, latest = done + stages.get(latest, 0.0), stage
                # A stage may be several pieces of work, each from 0 to 1.
                furthest = max(furthest, min(1.0, done + stages.get(stage, 0.0) * fraction))
                yield begin + share * furthest, stage
                # What whoever follows does in between is none of the stage's time.
                since = time.perf_counter()
        except StopIteration as stop:
            self.seconds[latest] = self.seconds.get(latest, 0.0) + time.perf_counter() - since
            return stop.value
