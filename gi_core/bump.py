# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a surface hides of the light of its own relief, where a map turns its normal away from the mesh's.

A mapped normal n looks at light that the relief it stands for would shade, and at grazing light its cosine ends sharply
where the mesh's normal N does not see it. As Cycles does it, light from ω counts by the shadowing of microfacets,

    G = 2 / (1 + √(1 + α² tan²θ))   with   α² = min(tan²δ / 8, 1),   θ between N and ω, δ between N and n,

and nothing counts from behind the mesh's normal, or where n itself points behind it
(Conty Estevez, Lecocq & Stein 2019, "A Microfacet-Based Shadowing Function to Solve the Bump Terminator Problem").
"""

import numpy as np

from .vectors import dot

# Directions of the table of means, and its entries over N·n.
_DIRECTIONS, _STEPS = 4096, 64


def shadowing(smooth: np.ndarray, normal: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """G for unit vectors (n, 3) each: (n,) float32, 0…1.

    smooth: the mesh's normal. normal: the mapped one. direction: to the light.
    """
    of_normal, of_light = dot(smooth, normal), dot(smooth, direction)
    return np.where(np.minimum(of_normal, of_light) > 0, _shadowing(of_normal, of_light), 0).astype(np.float32)


def _shadowing(of_normal: np.ndarray, of_light: np.ndarray) -> np.ndarray:
    """G by cosines to the mesh's normal."""
    width = np.minimum(_tangent2(of_normal) / 8, 1)
    return 2 / (1 + np.sqrt(1 + width * _tangent2(of_light)))


def _tangent2(cosine: np.ndarray) -> np.ndarray:
    square = np.clip(cosine * cosine, 1e-12, 1)
    return (1 - square) / square


def mean_shadowing(smooth: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """The mean of G for light that comes alike from everywhere above the surface, where its directions are not known:
    (n, 3) twice -> (n,) float32."""
    place = np.clip(dot(smooth, normal), 0, 1) * (_STEPS - 1)
    return np.interp(place, np.arange(_STEPS), _MEANS).astype(np.float32)


def _means() -> np.ndarray:
    cosine = np.linspace(0, 1, _STEPS)[:, None]
    k = np.arange(_DIRECTIONS) + 0.5
    z, phi = k / _DIRECTIONS, k * np.pi * (3 - np.sqrt(5))  # evenly over the hemisphere
    x = np.sqrt(1 - z * z) * np.cos(phi)
    arriving = np.maximum(cosine * z + np.sqrt(1 - cosine**2) * x, 0)
    means = (arriving * _shadowing(cosine, z)).sum(1) / arriving.sum(1)
    means[0] = 0
    return means


_MEANS = _means()
