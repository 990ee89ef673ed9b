# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from one cell to the middle of another, in a straight line.

Two bands of a cosine lobe are .25 + .5 cosθ: too weak ahead, too strong aside, negative behind. What they know is the
flux Φ and where it goes, V = 3/2 ∫ I ω dω, with |V| = Φ for one lobe and V = 0 for two that are opposite. So the lobe
is sharpened again to what has both and is never negative,

    I(ω) = max(0, V·ω)/π + (Φ − |V|)/4π,

which is Lambert's law for the light of one flat surface, and whose integral is Φ whatever V is.

At the distance r the beam has the irradiance I/r² on a surface across it. Within its own cell, though, a source is a
patch and no point: 1/√(r⁴ + q²s⁴) goes over into that. q is such that a unit square sends its form factor .554 to a
point half a side before its middle; two cells away the difference is below 1 %.
"""

import numpy as np

from .. import sh

_Q = np.float32(0.517)


def sharpened(coefficients) -> tuple[np.ndarray, np.ndarray]:
    """Two bands of intensity as V/π and (Φ − |V|)/4π: (n, 4, 3) -> (n, 3 axes, 3 colours), (n, 3) float32 [W/sr]."""
    flux = np.maximum(sh.integral(coefficients), 0)
    vector = sh.vector(coefficients) * np.float32(1.5)
    norm = np.sqrt(np.einsum("nac,nac->nc", vector, vector))
    vector = vector * np.minimum(1, flux / np.maximum(norm, 1e-30))[:, None]
    rest = flux - np.minimum(norm, flux)
    return vector / np.float32(np.pi), rest / np.float32(4 * np.pi)


def beam(vector, rest, row, direction, r2, cell: float) -> np.ndarray:
    """Irradiance across the beam from each source to its point: (p, 3) float32 [W/m²].

    vector, rest: of all sources, from `sharpened`; row: (p,) the source of each pair; direction: (p, 3) unit, from it;
    r2: (p,) squared distance [m²]; cell: side of the cells that light arrives in [m].
    """
    intensity = np.maximum(np.einsum("pac,pa->pc", vector[row], direction), 0) + rest[row]
    return intensity / np.sqrt(r2 * r2 + (_Q * np.float32(cell * cell)) ** 2)[:, None]
