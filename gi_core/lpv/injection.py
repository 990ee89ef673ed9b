# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From virtual point lights to the light that starts in each cell."""

from dataclasses import dataclass

import numpy as np

from ..device import NUMPY, Device
from ..kernels.lpv_inject import coefficients, summed
from ..sampling import systematic
from ..vpls import Vpls
from .grid import Grid

# Points of a cell from which rays to other cells start.
STARTS = 4

# Lights of equal brightness that those points are taken from.
_DRAWN = 1 << 16


@dataclass(frozen=True)
class Sources:
    """The cells that light starts from, each once for every side that surfaces in it look to: ±x, ±y, ±z.

    Two faces of a wall, or two walls of a corridor, so stay apart however coarse the cell is.

    coefficients: (n, 4, 3) float32 intensity [W/sr].
    centre: (n, 3) float32, mean position of the lights in them by flux [m].
    starts: (n, STARTS, 3) float32, just off the surface of some of those lights, often bright ones [m].
    side: of a cell [m].
    """

    coefficients: np.ndarray
    centre: np.ndarray
    starts: np.ndarray
    side: float

    def __len__(self) -> int:
        return len(self.centre)


def cells_of(vpls: Vpls, grid: Grid, bias: float) -> np.ndarray:
    """The cell of each light once it is moved along its normal by `bias` cells: (n, 3) int32."""
    # By a hair less: half a cell from a wall that lies in the middle of coarser ones, rounding would choose.
    return np.floor(grid.local(vpls.position) + np.float32(0.999 * bias) * vpls.normal).astype(np.int32)


def lobes(vpls: Vpls, grid: Grid, cell: np.ndarray, literal: bool, device: Device = NUMPY) -> np.ndarray:
    """What each light puts into its cell, on the device: (n, 4, 3) float32 [W/sr]."""
    towards = grid.centres(cell) - vpls.position if literal else None
    return device.run(coefficients, vpls.flux, vpls.normal, towards)


def dense(vpls: Vpls, grid: Grid, bias: float, literal: bool, device: Device = NUMPY) -> np.ndarray:
    """The grid of what starts in each cell: (x, y, z, 4, 3) float32 [W/sr]."""
    cell = cells_of(vpls, grid, bias)
    inside = grid.inside(cell)
    if not inside.all():
        vpls, cell = vpls[inside], cell[inside]
    intensity = lobes(vpls, grid, cell, literal, device)
    return device.numpy(device.run(summed, grid.flat(cell), intensity, grid.size)).reshape(*grid.shape, 4, 3)


def sources(vpls: Vpls, grid: Grid, bias: float, literal: bool, margin: float) -> Sources:
    """The cells of the grid, and of as much as `margin` cells around it, that hold lights."""
    m = int(np.ceil(margin))
    around = Grid(grid.low - m * grid.cell, grid.cell, tuple(n + 2 * m for n in grid.shape))
    cell = cells_of(vpls, around, bias)
    inside = around.inside(cell)
    if not inside.all():
        vpls, cell = vpls[inside], cell[inside]
    place = around.flat(cell) * 6 + _side(vpls.normal)
    weight = vpls.flux.mean(-1) + np.float32(1e-30)
    moments = np.column_stack([weight, weight[:, None] * (vpls.position - around.low)])
    moments = summed(place, moments.astype(np.float32), 6 * around.size)
    held = np.flatnonzero(moments[:, 0] > 0)
    intensity = summed(place, lobes(vpls, around, cell, literal), 6 * around.size)[held]
    centre = (moments[held, 1:] / moments[held, :1] + around.low).astype(np.float32)
    return Sources(intensity, centre, _starts(vpls, place, 6 * around.size)[held], grid.cell)


def _side(normal: np.ndarray) -> np.ndarray:
    """Which of ±x, ±y, ±z a normal is nearest to: (n, 3) -> (n,) in 0…5."""
    axis = np.abs(normal).argmax(-1)
    return 2 * axis + (np.take_along_axis(normal, axis[:, None], -1)[:, 0] < 0)


def _starts(vpls: Vpls, place: np.ndarray, size: int) -> np.ndarray:
    """For each place the origins of some of its lights: (size, STARTS, 3) float32."""
    starts = np.zeros((size, STARTS, 3), np.float32)
    if not len(vpls):
        return starts
    starts[place] = vpls.origin[:, None]
    bright = np.flatnonzero(vpls.flux.any(-1))
    if not len(bright):
        return starts
    drawn = bright[systematic(vpls.flux[bright].mean(-1), min(_DRAWN, 2 * len(bright)))]
    n = len(drawn)
    for k in range(STARTS):
        # The last one written stays: another order each time.
        turn = drawn[(np.arange(n, dtype=np.int64) * (2654435761 + 2 * k) + k * n // STARTS) % n]
        starts[place[turn], k] = vpls.origin[turn]
    return starts
