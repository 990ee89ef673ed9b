# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Propagation as published: from neighbour to neighbour, on each cascade by itself."""

from collections.abc import Iterator

import numpy as np

from .. import sh, tiles
from ..geometry import Geometry
from ..kernels.lpv_propagate import step
from ..vpls import Vpls
from .geometry_volume import blockers, geometry_volume
from .grid import Grid
from .injection import dense
from .settings import LpvSettings
from .volume import Level

# Layers of cells worked on at once by a thread.
_LAYERS = 16

# Steps after which light that goes in circles is left alone.
_ENDLESS = 256


def propagated(geometry: Geometry, vpls: Vpls, grids: list[Grid], settings: LpvSettings) -> Iterator[float]:
    """The light of virtual lights on each of the cascades. A generator of progress; returns a list of Levels."""
    found = []
    surfaces = None
    if settings.geometry_volume:
        # Surfaces that send nothing back need no colour.
        surfaces = yield from blockers(geometry, grids[0].cell, colored=settings.secondary_bounce > 0)
    for grid in grids:
        start = dense(vpls, grid, settings.injection_bias, settings.injection == "literal")
        blocked, albedo = None, None
        if surfaces:
            blocked, albedo = yield from geometry_volume(
                surfaces, grid, settings.geometry_bias, settings.occlusion_amplifier
            )
            albedo = None if albedo is None else albedo * np.float32(settings.secondary_bounce)
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
        front = yield from _stepped(front, *((blocked, albedo) if k else (None, None)))
        if settings.damping != 1:
            front *= np.float32(settings.damping)
        total += front
        if not settings.iterations and front[0].sum() <= settings.front_share * injected:
            break
    return total


def _stepped(front: np.ndarray, blocked, albedo) -> Iterator[float]:
    """One step, layer by layer. A generator of progress; returns the next front."""
    out, n = np.empty_like(front), front.shape[1]

    def tile(part: slice):
        around = slice(max(0, part.start - 1), min(n, part.stop + 1))
        walls = (None if a is None else a[:, around] for a in (blocked, albedo))
        first = part.start - around.start
        out[:, part] = step(front[:, around], *walls)[:, first : first + part.stop - part.start]

    yield from tiles.run(tile, tiles.slices(n, _LAYERS))
    return out
