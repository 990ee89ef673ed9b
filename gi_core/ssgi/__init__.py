# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Screen-space global illumination: a camera's picture lights itself, after Unity HDRP's pipeline.

    view = still(tracer, camera, settings)                 several passes over one picture
    irradiance, coverage = seen([view], surfels)   what the camera found, at any points

`still` is a generator of progress; `tiles.finish` runs one to its value. For animations see `motion.py`.
"""

from .pipeline import History, still
from .view import View, seen

__all__ = ["History", "View", "seen", "still"]
