# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Propagation as published: from neighbour to neighbour, on each cascade by itself."""

from collections.abc import Iterator

import numpy as np

from .. import sh
from ..device import NUMPY, Device
from ..geometry import Geometry
from ..kernels.added import added
from ..kernels.lpv_propagate import layer_sums, step
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


def propagated(
    geometry: Geometry, vpls: Vpls, grids: list[Grid], settings: LpvSettings, device: Device = NUMPY
) -> Iterator[float]:
    """The light of virtual lights on each of the cascades. A generator of progress; returns a list of Levels."""
    found = []
    surfaces = None
    if settings.geometry_volume:
        # Surfaces that send nothing back need no colour.
        surfaces = yield from blockers(geometry, grids[0].cell, colored=settings.secondary_bounce > 0)
    for grid in grids:
        start = dense(vpls, grid, settings.injection_bias, settings.injection == "literal", device)
        blocked, albedo = None, None
        if surfaces:
            blocked, albedo = yield from geometry_volume(
                surfaces, grid, settings.geometry_bias, settings.occlusion_amplifier, device
            )
            albedo = None if albedo is None else albedo * np.float32(settings.secondary_bounce)
        total = yield from spread(sh.affine(start), settings, blocked, albedo, device)
        # Calibrated against a point light: E = 4 I(−n)/s².
        total = total * np.float32(4 / grid.cell**2)
        total[1:] *= -1
        found.append(Level(grid, sh.from_affine(total).reshape(grid.size, 4, 3)))
    return found


def spread(
    front: np.ndarray, settings: LpvSettings, blocked=None, albedo=None, device: Device = NUMPY
) -> Iterator[float]:
    """All light that passes each cell. A generator of progress; returns (4, x, y, z, 3) float32 [W/sr].

    front: what starts in each cell, the same shape; blocked, albedo: see `kernels.lpv_propagate`.
    """
    injected, total = float(front[0].sum()), device.array(front, 3)
    front, walls = total, [a if a is None else device.array(a, c) for a, c in ((blocked, 1), (albedo, 3))]
    for k in range(settings.iterations or _ENDLESS):

        def tile(layers: slice, front=front, first=not k):
            # The first step leaves the surface that the light started from.
            stopped = (None, None) if first else walls
            return device.run(step, front, *stopped, settings.damping, layers)

        front = yield from device.each(tile, front.shape[1], _LAYERS, axis=1)
        total = device.run(added, total, front)
        if not settings.iterations and device.numpy(device.run(layer_sums, front)).sum() <= (
            settings.front_share * injected
        ):
            break
    return device.numpy(total)
