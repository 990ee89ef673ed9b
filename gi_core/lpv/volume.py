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
