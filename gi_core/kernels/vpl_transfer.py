# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance at points from virtual point lights: Dachsbacher & Stamminger 2005, eq. 1, for one pair per sample.

With unit directions the paper's two unnormalised dot products over the fourth power are cosθ_p cosθ_x / d². A
Lambertian light of flux Φ has intensity Φ/π·cosθ_p; the paper leaves that 1/π to the flux, here it stands in the
kernel, and nowhere else.

At d = 0 that is infinite, though a light stands for a surface of some area A, whose disk has the radius r = √(A/π) and
sends no more than 1/A. Four bounds follow from it, all exact as A goes to 0:

    disc        cosθ_p cosθ_x / (π d² + A)         as from the middle of such a disk, facing it
    distance    cosθ_p cosθ_x / max(π d², A)       d is not below r
    geometry    min(cosθ_p cosθ_x / (π d²), 1/A)   the transfer is not above the disk's
    offset      the light is moved back by r along its negative normal (the paper's)

A moved light is seen from all that was before it at a distance of r or more, under cosines that fit its new place. It
would also shine on its own surface and up to r behind it; here pairs that do not face each other stay dark.
"""

import numpy as np

from ..vectors import dot

# Keeps the denominator from vanishing in single precision; for lights closer than a nanometre.
_TINY = np.float32(1e-18)


def transfer(position, normal, light_position, light_normal, area, bound: str = "disc") -> np.ndarray:
    """Irradiance over flux for each pair.

    position, normal: (..., 3) float32 receivers; light_position, light_normal: (..., 3); area: (...) A [m²], zero for
        no bound; what numpy broadcasts to one shape. bound: "disc", "distance", "geometry" or "offset".
    Returns (...) float32 [1/m²].
    """
    d = light_position - position
    cos_x = np.maximum(dot(normal, d), 0)
    cos_p = np.maximum(-dot(light_normal, d), 0)
    if bound == "offset":
        facing = (cos_x > 0) & (cos_p > 0)
        d = d - np.sqrt(area / np.float32(np.pi))[..., None] * light_normal
        cos_x = np.where(facing, np.maximum(dot(normal, d), 0), 0)
        cos_p = -dot(light_normal, d)
    d2 = dot(d, d)
    disk = np.float32(np.pi) * d2
    if bound == "disc":
        disk = disk + area
    elif bound == "distance":
        disk = np.maximum(disk, area)
    pairs = cos_x * cos_p / (np.maximum(d2, _TINY) * np.maximum(disk, _TINY))
    return np.minimum(pairs, 1 / np.maximum(area, _TINY)) if bound == "geometry" else pairs
