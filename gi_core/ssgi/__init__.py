# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space global illumination: a camera's picture lights itself, after Unity HDRP's pipeline.

    view = still(tracer, camera, settings)                 several passes over one picture
    irradiance, coverage = seen([view], surfels)   what the camera found, at any points

`still` is a generator of progress; `tiles.finish` runs one to its value. For animations see `motion.py`.
"""

from collections.abc import Iterator

from ..surfels import Surfels
from ..trace import Tracer
from .pipeline import History, still
from .settings import SsgiSettings
from .view import View, seen

__all__ = ["History", "View", "emit", "indirect", "seen", "still"]


def emit(tracer: Tracer, receivers: Surfels, settings: SsgiSettings) -> Iterator[float]:
    """What the scene's camera sees, lit: a generator of progress; returns a list of Views.

    receivers: the points that will ask, which the camera does not care for.
    """
    view, _ = yield from still(tracer, tracer.geometry.scene.camera, settings)
    return [view]


def indirect(tracer: Tracer, surfels: Surfels, views: list[View], settings: SsgiSettings) -> Iterator[float]:
    """Irradiance from reflected light. A generator of progress; returns (n, 3) float32 [W/m²]."""
    irradiance, _ = yield from seen(views, surfels)
    return irradiance
