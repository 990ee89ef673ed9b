# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space global illumination: a camera's picture lights itself, after Unity HDRP's pipeline.

    view = still(tracer, camera, settings)                            several passes over a picture
    later = still(tracer, camera, settings, history=view.history)     the next picture of an animation
    irradiance, coverage = seen([view], surfels)                      what the camera found, at any points

`still` and `seen` are generators of progress; `tiles.finish` runs one to its value.
"""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from .. import tiles
from ..sampling import Samples
from ..scene import Camera
from ..surfels import Surfels
from ..trace import Tracer
from .pipeline import restored, still
from .settings import SsgiSettings
from .view import History, View, seen

__all__ = ["History", "View", "indirect", "restored", "seen", "still", "views"]


def views(
    tracer: Tracer,
    cameras: Sequence[Camera],
    settings: SsgiSettings,
    history: History | None = None,
    shown: Callable[[np.ndarray], None] | None = None,
) -> Iterator[float]:
    """What cameras see, lit: a generator of progress; returns a list of Views.

    history: of the first camera's earlier picture. shown: see `still`.
    """
    found = []
    for k, camera in enumerate(cameras):
        work = still(tracer, camera, settings, history=None if k else history, shown=shown)
        found.append((yield from tiles.within(k / len(cameras), (k + 1) / len(cameras), work)))
    return found


def indirect(
    tracer: Tracer, surfels: Surfels, emitted: list[View], settings: SsgiSettings, samples: Samples
) -> Iterator[float]:
    """Irradiance from reflected light, as the views have it. A generator of progress; returns (n, 3) float32 [W/m²]."""
    irradiance, _ = yield from seen(emitted, surfels, tracer.device)
    return irradiance
