# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The techniques by name, and what a bake asks of each."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from . import rsm, ssgi
from .rsm.settings import RsmSettings
from .settings import Settings
from .ssgi.settings import SsgiSettings


@dataclass(frozen=True)
class Technique:
    """How a technique finds reflected light; the functions are generators of progress.

    settings: the class of its settings.
    emit: (tracer, guides, settings), guides being surfels spread over all that gets light; returns what to gather from.
    indirect: (tracer, surfels, emitted, settings, samples); returns (n, 3) irradiance [W/m²].
    in_passes: whether under given settings it takes samples, so that passes of some of them add up.
    filters: whether it takes its noise out itself, where the bilateral filter is asked for.
    """

    settings: type[Settings]
    emit: Callable[..., Iterator[float]]
    indirect: Callable[..., Iterator[float]]
    in_passes: Callable[[Settings], bool]
    filters: bool = False


METHODS = {
    "rsm": Technique(RsmSettings, rsm.emit, rsm.indirect, lambda settings: settings.pattern != "all"),
    "ssgi": Technique(SsgiSettings, ssgi.emit, ssgi.indirect, lambda settings: False, filters=True),
}
