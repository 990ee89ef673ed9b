# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Grids of cubic cells, and cascades of them."""

from dataclasses import dataclass

import numpy as np

from ..settings import SettingError
from .settings import LpvSettings

# Of the coarsest grid that light ends up on, cells along the longest side.
_COARSEST = 4

# Cascades at the most, and the share of points that the finest holds where their number is not given.
_MOST, _NEARLY_ALL = 6, 0.95


@dataclass(frozen=True)
class Grid:
    """A box of cubic cells.

    low: (3,) float64, the lowest corner [m]. cell: side of a cell [m]. shape: cells along x, y, z.
    """

    low: np.ndarray
    cell: float
    shape: tuple[int, int, int]

    @property
    def size(self) -> int:
        return int(np.prod(self.shape))

    @property
    def high(self) -> np.ndarray:
        return self.low + self.cell * np.array(self.shape)

    def local(self, position: np.ndarray) -> np.ndarray:
        """Points in units of cells from the lowest corner: (..., 3) -> (..., 3) float32."""
        return ((position - self.low) / self.cell).astype(np.float32)

    def centres(self, cells: np.ndarray) -> np.ndarray:
        """Middles of cells: (..., 3) integers -> (..., 3) float32 [m]."""
        return (self.low + (cells + 0.5) * self.cell).astype(np.float32)

    def every(self) -> np.ndarray:
        """The middles of all cells, in C order: (size, 3) float32 [m]."""
        return self.centres(np.stack(np.unravel_index(np.arange(self.size), self.shape), -1))

    def inside(self, cells: np.ndarray) -> np.ndarray:
        """(..., 3) integers -> (...) bool."""
        within = (cells >= 0) & (cells < np.array(self.shape, np.int32))
        return within[..., 0] & within[..., 1] & within[..., 2]

    def flat(self, cells: np.ndarray) -> np.ndarray:
        """The place of a cell in C order: (..., 3) integers within the grid -> (...)."""
        _, ny, nz = self.shape
        return (cells[..., 0] * ny + cells[..., 1]) * nz + cells[..., 2]

    def coarser(self, ratio: int) -> "Grid":
        """The grid over the same space with cells so many times as large; it may reach a little further."""
        return Grid(self.low, self.cell * ratio, tuple(-(-n // ratio) for n in self.shape))


def fitted(low: np.ndarray, high: np.ndarray, cells: int) -> Grid:
    """The grid around a box, with one empty cell on each side.

    The box's walls then lie between cells, whose middles are half a cell before or behind them, never in them.
    """
    low, high = np.asarray(low, np.float64), np.asarray(high, np.float64)
    extent = np.maximum(high - low, 1e-6)
    cell = float(extent.max()) / (cells - 2)
    shape = np.ceil(extent / cell - 1e-6).astype(int) + 2
    return Grid((low + high) / 2 - shape * cell / 2, cell, tuple(int(n) for n in shape))


def cascades(outer: Grid, cells: int, count: int, ratio: int, center: np.ndarray) -> list[Grid]:
    """Grids one in another, finest first; the last one is outer.

    Each has cells ratio times smaller than the next, no more than `cells` along a side, is snapped to whole cells of
    the next, stays within it and lies as near around center (3,) [m] as that allows.
    """
    grids = [outer]
    for _ in range(1, count):
        coarse = grids[0]
        room = np.array(coarse.shape)
        shape = np.minimum(room, max(1, cells // ratio))
        first = np.round((center - coarse.low) / coarse.cell - shape / 2).astype(int)
        first = np.clip(first, 0, room - shape)
        grids.insert(
            0, Grid(coarse.low + first * coarse.cell, coarse.cell / ratio, tuple(int(n) for n in shape * ratio))
        )
    return grids


def levels(grids: list[Grid], ratio: int) -> list[Grid]:
    """The cascades and, beyond the largest, ever coarser grids over the same space: where light is once it is far."""
    every = list(grids)
    while max(every[-1].shape) > _COARSEST:
        every.append(every[-1].coarser(ratio))
    return every


def placed(
    bounds: np.ndarray, camera: np.ndarray | None, receivers: np.ndarray | None, settings: LpvSettings
) -> list[Grid]:
    """The cascades of a scene, finest first.

    bounds: (2, 3) its corners; camera: (3,) where it stands; receivers: (n, 3) points to light [m]; None without.
    Raises SettingError where the settings' box is none.
    """
    low, high = box(settings.box) if settings.box else bounds
    outer = fitted(low, high, settings.cells)
    center = (outer.low + outer.high) / 2
    if settings.center == "camera" and camera is not None:
        center = camera
    elif settings.center == "receivers" and receivers is not None and len(receivers):
        center = np.median(receivers, 0)
    if settings.cascades:
        return cascades(outer, settings.cells, settings.cascades, settings.cascade_ratio, center)
    grids = [outer]
    while receivers is not None and len(receivers) and len(grids) < _MOST:
        more = cascades(outer, settings.cells, len(grids) + 1, settings.cascade_ratio, center)
        finest = more[0]
        if finest.inside(np.floor(finest.local(receivers)).astype(np.int32)).mean() < _NEARLY_ALL:
            break
        grids = more
    return grids


def box(text: str) -> np.ndarray:
    """Corners from text, six numbers: (2, 3) float64, lowest first. Raises SettingError for anything else."""
    try:
        corners = np.array([float(word) for word in text.replace(",", " ").split()]).reshape(2, 3)
    except ValueError:
        raise SettingError(f"setting 'box' is '{text}'; it takes six numbers, the corners of a box") from None
    if not np.all(np.isfinite(corners)) or np.any(corners[0] == corners[1]):
        raise SettingError(f"setting 'box' is '{text}'; its corners span no box")
    return np.sort(corners, 0)


def memory(settings: LpvSettings, shape: tuple[float, float, float] = (1, 1, 1)) -> int:
    """Bytes that a volume takes at the most. shape: extents of the box that it holds, in any unit."""
    outer = fitted(np.zeros(3), np.asarray(shape), settings.cells)
    grids = cascades(outer, settings.cells, settings.cascades or _MOST, settings.cascade_ratio, outer.low)
    # Nine coefficients, or four, of three colours.
    return sum(g.size for g in grids) * (9 if settings.propagation == "hierarchical" else 4) * 3 * 4
