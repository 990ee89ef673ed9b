# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The lobe of a rough mirror: GGX microfacets (Trowbridge & Reitz 1975, Walter et al. 2007), each of which
reflects all light: what a surface reflects of it, by the angle to the half vector, is a factor to what is here.

    f = D(h) G₂(v, l) / (4 cosθ_v cosθ_l)      G₂ = 1 / (1 + Λ(v) + Λ(l)): Smith, heights correlated (Heitz 2014)

Directions are drawn by the facets that the viewer sees (Heitz 2018), in the form of Dupuy & Benyoub 2023: a facet's
normal is the half vector of the viewer and a point of a spherical cap. A direction is then worth G₂/G₁, no more than 1.

All directions are unit and local: z is along the surface's normal. view, light, half: (n, 3) float32, away from the
surface; alpha: (n,) float32, above 0.
"""

import numpy as np

from ..vectors import dot, normalize


def facets(view, alpha, u) -> np.ndarray:
    """Normals of microfacets, as often as they are seen: (n, 3), (n,), (n, 2) in [0, 1)² -> (n, 3) float32."""
    flat = np.stack([alpha, alpha, np.ones_like(alpha)], -1)
    stretched = normalize(view * flat)
    height = (1 - u[:, 1]) * (1 + stretched[:, 2]) - stretched[:, 2]
    across = np.sqrt(np.clip(1 - height * height, 0, 1))
    angle = 2 * np.pi * u[:, 0]
    cap = np.stack([across * np.cos(angle), across * np.sin(angle), height], -1)
    return normalize((cap + stretched) * flat).astype(np.float32)


def mirrored(view, half) -> np.ndarray:
    """What a facet reflects to the viewer comes from here: (n, 3) float32; below the surface it is lost."""
    return 2 * dot(view, half)[:, None] * half - view


def worth(view, light, alpha) -> np.ndarray:
    """f cosθ_l over the density of a direction drawn by `facets` and `mirrored`: (n,) float32, 0…1."""
    seen = 1 + _hidden(view, alpha)
    return np.where(light[:, 2] > 0, seen / (seen + _hidden(light, alpha)), 0).astype(np.float32)


def brdf(view, light, alpha) -> np.ndarray:
    """The BRDF f: (n,) float32 [1/sr]; zero for directions below the surface."""
    half = normalize(view + light)
    # Not through cosθ_h alone, which rounds away all that a narrow lobe is made of.
    wide = (half[:, 0] ** 2 + half[:, 1] ** 2) / alpha**2 + half[:, 2] ** 2
    density = 1 / (np.pi * alpha**2 * wide**2)
    masked = 1 / (1 + _hidden(view, alpha) + _hidden(light, alpha))
    cosines = 4 * view[:, 2] * np.maximum(light[:, 2], 1e-6)
    return np.where(light[:, 2] > 0, density * masked / cosines, 0).astype(np.float32)


def _hidden(direction, alpha) -> np.ndarray:
    """Smith's Λ: facets that face a direction and are hidden from it over those that are not; (n,)."""
    tangent2 = 1 / np.maximum(direction[:, 2] ** 2, 1e-12) - 1
    return (np.sqrt(1 + alpha**2 * np.maximum(tangent2, 0)) - 1) / 2
