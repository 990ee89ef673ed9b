# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The techniques by name, and what a bake asks of each."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from . import lpv, rsm
from .lpv.settings import LpvSettings
from .rsm.settings import RsmSettings
from .settings import Settings


@dataclass(frozen=True)
class Technique:
    """How a technique finds reflected light; the functions are generators of progress.

    settings: the class of its settings.
    emit: (tracer, guides, settings), guides being surfels spread over all that gets light; returns what to gather from.
    indirect: (tracer, surfels, emitted, settings, samples); returns (n, 3) irradiance [W/m²].
    in_passes: whether under given settings it takes samples, so that passes of some of them add up.
    noisy: whether under given settings its light has noise that the bake is to take out.
    """

    settings: type[Settings]
    emit: Callable[..., Iterator[float]]
    indirect: Callable[..., Iterator[float]]
    in_passes: Callable[[Settings], bool] = lambda settings: False
    noisy: Callable[[Settings], bool] = lambda settings: True


METHODS = {
    "rsm": Technique(RsmSettings, rsm.emit, rsm.indirect, in_passes=lambda settings: settings.pattern != "all"),
    "lpv": Technique(
        LpvSettings, lpv.emit,
        lambda tracer, surfels, volume, settings, samples: lpv.indirect(tracer, surfels, volume, settings),
        noisy=lambda settings: False,
    ),
}  # fmt: skip
