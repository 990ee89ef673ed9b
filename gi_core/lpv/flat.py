# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Propagation as published: from neighbour to neighbour, on each cascade by itself."""

from collections.abc import Iterator

import numpy as np

from .. import sh
from ..geometry import Geometry
from ..kernels.lpv_propagate import step
from ..vpls import Vpls
from .geometry_volume import geometry_volume
from .grid import Grid
from .injection import dense
from .settings import LpvSettings
from .volume import Level

# Steps after which light that goes in circles is left alone.
_ENDLESS = 256


def propagated(geometry: Geometry, vpls: Vpls, grids: list[Grid], settings: LpvSettings) -> Iterator[float]:
    """The light of virtual lights on each of the cascades. A generator of progress; returns a list of Levels."""
    found = []
    for grid in grids:
        start = dense(vpls, grid, settings.injection_bias, settings.injection == "literal")
        blocked, albedo = None, None
        if settings.geometry_volume:
            blocked, albedo = geometry_volume(geometry, grid, settings.geometry_bias, settings.occlusion_amplifier)
            # Surfaces that send nothing back need no colour.
            albedo = albedo * np.float32(settings.secondary_bounce) if settings.secondary_bounce else None
        total = yield from spread(sh.affine(start), settings, blocked, albedo)
        # Calibrated against a point light: E = 4 I(−n)/s².
        total *= np.float32(4 / grid.cell**2)
        total[1:] *= -1
        found.append(Level(grid, sh.from_affine(total).reshape(grid.size, 4, 3)))
    return found


def spread(front: np.ndarray, settings: LpvSettings, blocked=None, albedo=None) -> Iterator[float]:
    """All light that passes each cell. A generator of progress; returns (4, x, y, z, 3) float32 [W/sr].

    front: what starts in each cell, the same shape; blocked, albedo: see `kernels.lpv_propagate`.
    """
    total, injected = front.copy(), float(front[0].sum())
    for k in range(settings.iterations or _ENDLESS):
        # The first step leaves the surface that the light started from.
        front = step(front, blocked if k else None, albedo if k else None) * np.float32(settings.damping)
        total += front
        yield (k + 1) / (settings.iterations or _ENDLESS)
        if not settings.iterations and front[0].sum() <= settings.front_share * injected:
            break
    return total
