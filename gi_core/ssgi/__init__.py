# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space global illumination: a camera's picture lights itself, after Unity HDRP's pipeline.

    view = still(tracer, camera, settings)                            several passes over a picture
    later = still(tracer, camera, settings, history=view.history)     the next picture of an animation
    irradiance, coverage = seen([view], surfels)                      what the camera found, at any points

`still` and `seen` are generators of progress; `tiles.finish` runs one to its value.
"""

from collections.abc import Iterator, Sequence

from ..scene import Camera
from ..surfels import Surfels
from ..trace import Tracer
from .pipeline import part, restored, still
from .settings import SsgiSettings
from .view import History, View, seen

__all__ = ["History", "View", "emit", "indirect", "restored", "seen", "still"]


def emit(
    tracer: Tracer,
    receivers: Surfels,
    settings: SsgiSettings,
    cameras: Sequence[Camera] = (),
    history: History | None = None,
) -> Iterator[float]:
    """What cameras see, lit: a generator of progress; returns a list of Views.

    receivers: the points that will ask, for which the cameras do not care. cameras: none means the scene's own.
    history: of the first camera's earlier picture.
    """
    cameras = cameras or [tracer.geometry.scene.camera]
    views = []
    for k, camera in enumerate(cameras):
        work = still(tracer, camera, settings, history=None if k else history)
        views.append((yield from part(k / len(cameras), (k + 1) / len(cameras), work)))
    return views


def indirect(tracer: Tracer, surfels: Surfels, views: list[View], settings: SsgiSettings) -> Iterator[float]:
    """Irradiance from reflected light. A generator of progress; returns (n, 3) float32 [W/m²]."""
    irradiance, _ = yield from seen(views, surfels)
    return irradiance
