# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The volume that light is looked up in."""

from dataclasses import dataclass

import numpy as np

from .grid import Grid


@dataclass(frozen=True)
class Level:
    """One cascade.

    irradiance: (size, k, 3) float32, cells in C order: coefficients of E(n) over a receiver's normal n, in the order of
        `sh`, with two or three bands [W/m²].
    """

    grid: Grid
    irradiance: np.ndarray


@dataclass(frozen=True)
class Volume:
    """Cascades, finest first; each holds all of the light, near and far."""

    levels: tuple[Level, ...]

    @property
    def nbytes(self) -> int:
        return sum(level.irradiance.nbytes for level in self.levels)

    @property
    def summary(self) -> str:
        """What a log says of it."""
        if not self.levels:
            return "volume: there is no light in it"
        finest, count = self.levels[0].grid, len(self.levels)
        return (
            f"volume: {count} cascade{'s' * (count > 1)}, {sum(level.grid.size for level in self.levels)} cells, the "
            f"finest of {finest.cell:.3g} m, {self.nbytes / 2**20:.1f} MB"
        )
