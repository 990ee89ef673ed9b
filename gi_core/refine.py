# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Progressive refinement: an estimate in passes, each of which leaves it valid, until it is good enough.

It ends at a number of samples, or before that at a noise or after a time. Each pass is an estimate of its own, so their
differences tell the noise of their mean without any reference.
"""

import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from . import tiles
from .sampling import Samples

# Samples of the largest pass where time or noise decide about the end: after each the clock is looked at.
_PASS = 16

# Fewer samples are not worth a pass of their own.
_LEAST = 2

# Samples to which the near field is fitted at the most. Fitted to more it becomes so small that single lights are
# noisy: on `cornell` 256 samples have 1.5 times the error.
_PLANNED = 64

# As in `metrics.relmse`: light darker than a tenth counts as such.
_DARK = 0.01


@dataclass(frozen=True)
class Goal:
    """When to stop.

    samples: at the most. noise: relMSE of the estimate, 0 for none. seconds: 0 for no limit; one pass there always is.
    """

    samples: int
    noise: float = 0.0
    seconds: float = 0.0

    @property
    def open_end(self) -> bool:
        return self.noise > 0 or self.seconds > 0

    def passes(self) -> Iterator[Samples]:
        """A quarter, a quarter and a half of the samples; with an open end ever more until passes are long enough."""
        planned = min(self.samples, _PLANNED)
        first, count = 0, max(_LEAST, (planned if self.open_end else self.samples) // 4)
        while first < self.samples:
            if first:
                count = min(first, _PASS) if self.open_end else first
            # The rest of what would leave less than a pass goes along.
            left = self.samples - first
            count = left if left < 2 * count and not self.open_end else min(count, left)
            yield Samples(count, first, planned)
            first += count


@dataclass(frozen=True)
class Estimate:
    """values: (n, k, 3) float32 mean over all samples. samples: how many. variance: (n, 3) float32 of the mean, its
    parts added up, None after a single pass."""

    values: np.ndarray
    samples: int
    variance: np.ndarray | None

    @property
    def noise(self) -> float:
        """relMSE that the mean has left, NaN after a single pass."""
        if self.variance is None:
            return float("nan")
        # E/π is what errors are measured on.
        light = added_up(self.values) ** 2 + np.float32(_DARK * np.pi**2)
        return float(np.mean(self.variance / light, dtype=np.float64))


def refined(
    one_pass: Callable[[Samples], Iterator[float]], goal: Goal, seen: Callable[[np.ndarray], None] | None = None
) -> Iterator[float]:
    """The mean of passes until the goal is reached. A generator of progress; returns the Estimate.

    one_pass: a generator of progress that returns (n, k, 3) irradiance, k parts of one light. seen: is shown
        the mean after each pass.
    """
    begin, total, squares, done, passes = time.perf_counter(), 0, 0, 0, 0
    for samples in goal.passes():
        share = samples.first / goal.samples, (samples.first + samples.count) / goal.samples
        values = yield from tiles.within(*share, one_pass(samples))
        count = np.float32(samples.count)
        total = values * count + total
        light = added_up(values)
        squares = light * light * count + squares
        done, passes = done + samples.count, passes + 1
        if seen:
            seen(total / np.float32(done))
        late = goal.seconds and time.perf_counter() - begin >= goal.seconds
        if late or (goal.noise and _estimate(total, squares, done, passes).noise <= goal.noise):
            break
    return _estimate(total, squares, done, passes)


def added_up(values: np.ndarray) -> np.ndarray:
    """The light of all parts: (n, k, 3) -> (n, 3). Over so short an axis numpy's own sum is several times slower."""
    return sum(values[:, k] for k in range(1, values.shape[1])) + values[:, 0]


def _estimate(total: np.ndarray, squares: np.ndarray, samples: int, passes: int) -> Estimate:
    return Estimate(total / np.float32(samples), samples, _variance(added_up(total), squares, samples, passes))


def _variance(total: np.ndarray, squares: np.ndarray, samples: int, passes: int) -> np.ndarray | None:
    """Of the mean, by the spread of the passes' means about it, each weighed by its samples."""
    if passes < 2:
        return None
    return np.maximum(squares - total * (total / np.float32(samples)), 0) / np.float32((passes - 1) * samples)
