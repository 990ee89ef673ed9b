# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The techniques by name, and what a bake asks of each."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from . import lpv, rsm, ssgi
from .lpv.settings import LpvSettings
from .rsm.settings import RsmSettings
from .scene import Camera
from .settings import Settings
from .ssgi.settings import SsgiSettings
from .surfels import Surfels


@dataclass(frozen=True)
class Asked:
    """Who asks for light.

    guides: surfels spread over all that gets light, None where it may be asked for anywhere. cameras: that look at it.
    history: what a technique left of the frame before, None without. shown: is given the picture of a camera so far,
        (h, w, 3) E/π, by techniques that work one out; None where nobody looks.
    """

    guides: Surfels | None
    cameras: Sequence[Camera] = ()
    history: object | None = None
    shown: Callable[[np.ndarray], None] | None = None


@dataclass(frozen=True)
class Technique:
    """How a technique finds reflected light; the functions are generators of progress.

    settings: the class of its settings.
    emit: (tracer, Asked, settings); returns what to gather from.
    indirect: (tracer, surfels, emitted, settings, samples); returns (n, 3) irradiance [W/m²].
    medium: (tracer, camera, subpixels, rows, emitted, settings); see `lpv.scattering`. None where it knows of none.
    radiance: (tracer, surfels, emitted, settings); reflected light around points as harmonics of radiance (n, k, 3),
        for glossy surfaces. None where it knows of none.
    stage: name of what `emit` does, by which most of it takes its time.
    in_passes: whether under given settings it takes samples, so that passes of some of them add up.
    noisy: whether under given settings its light has noise that the bake is to take out.
    """

    settings: type[Settings]
    emit: Callable[..., Iterator[float]]
    indirect: Callable[..., Iterator[float]]
    medium: Callable[..., Iterator[float]] | None = None
    radiance: Callable[..., np.ndarray] | None = None
    stage: str = "maps"
    in_passes: Callable[[Settings], bool] = lambda settings: False
    noisy: Callable[[Settings], bool] = lambda settings: True


METHODS = {
    "rsm": Technique(
        RsmSettings,
        lambda tracer, asked, settings: rsm.emit(tracer, asked.guides, settings),
        rsm.indirect,
        in_passes=lambda settings: settings.pattern != "all",
    ),
    "lpv": Technique(
        LpvSettings,
        lambda tracer, asked, settings: lpv.emit(tracer, asked.guides, settings),
        lambda tracer, surfels, volume, settings, samples: lpv.indirect(tracer, surfels, volume, settings),
        medium=lpv.scattered,
        radiance=lpv.radiance,
        stage="propagation",
        noisy=lambda settings: False,
    ),
    "ssgi": Technique(
        SsgiSettings,
        lambda tracer, asked, settings: ssgi.views(tracer, asked.cameras, settings, asked.history, asked.shown),
        ssgi.indirect,
        stage="screen",
        # It takes its noise out itself, but where Open Image Denoise is asked for.
        noisy=lambda settings: settings.denoise == "oidn",
    ),
}
