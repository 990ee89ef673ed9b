# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Irradiance at points from virtual point lights: Dachsbacher & Stamminger 2005, eq. 1, for one pair per sample.

With unit directions the paper's two unnormalised dot products over the fourth power are cosθ_p cosθ_x / d². A
Lambertian light of flux Φ has intensity Φ/π·cosθ_p; the paper leaves that 1/π to the flux, here it stands in the
kernel, and nowhere else. The singularity is bounded by the area A_p that a light stands for: a disk of that area at
height 0 has the denominator π d² + A_p. An area of zero leaves the transfer as it is.
"""

import numpy as np

from ..vectors import dot


def transfer(position, normal, light_position, light_normal, light_area) -> np.ndarray:
    """Irradiance over flux for each pair: cosθ_p cosθ_x / (π d² + A_p).

    position, normal: (..., 3) float32 receivers; light_position, light_normal: (..., 3); light_area: (...) [m²]; what
        numpy broadcasts to one shape.
    Returns (...) float32 [1/m²].
    """
    d = light_position - position
    d2 = dot(d, d)
    cos_x = np.maximum(dot(normal, d), 0)
    cos_p = np.maximum(-dot(light_normal, d), 0)
    return cos_x * cos_p / (np.maximum(d2, 1e-20) * (np.float32(np.pi) * d2 + light_area))
