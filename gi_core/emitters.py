# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from emitting surfaces, as points on them."""

import numpy as np

from .geometry import Geometry
from .sampling import r2_sequence, systematic
from .vectors import offset
from .vpls import Vpls, coherent, equalized

# Points that stand for all emitting surfaces.
POINTS = 1 << 17


def emitters(geometry: Geometry, n: int = POINTS) -> Vpls:
    """About n points that stand for all emitting surfaces, both sides, each of the same flux; none where nothing emits.

    Triangles are drawn by area times emission, points on them evenly, and textures decide what each is worth.
    """
    scene = geometry.scene
    strength = np.array([np.mean(np.abs(m.emission.value)) for m in scene.materials], np.float32)
    if not np.any(strength) or not len(geometry.triangles):
        return Vpls.concatenate([])
    strength = strength[geometry.material(np.arange(len(geometry.triangles)))] * geometry.casts
    if not np.any(geometry.areas * strength > 0):
        return Vpls.concatenate([])
    triangle, weights, share = strewn(geometry, strength, n)
    position, normal = geometry.position(triangle, weights), geometry.face_normal(triangle)
    radiance = geometry.color("emission", triangle, weights)
    flux = np.pi * radiance * (share * geometry.alpha(triangle, weights))[:, None]
    sides = [Vpls(position, offset(position, side), side, flux, share) for side in (normal, -normal)]
    every = Vpls.concatenate(sides)
    every = every[coherent(every)]
    return equalized(every, every.flux.mean(-1), n)


def strewn(geometry: Geometry, strength: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """n points on triangles, drawn by area times strength (t,), evenly on each triangle.

    Returns triangles (n,), barycentric weights (n, 3) and the area that each point stands for (n,) [m²], float32.
    Raises ValueError where no triangle has both area and strength.
    """
    area = geometry.areas
    weight = area.astype(np.float64) * strength
    triangle = systematic(weight, n)
    # A triangle's area over the draws that it expects.
    share = weight.sum() / (n * weight[triangle]) * area[triangle]
    u = r2_sequence(n)
    root = np.sqrt(u[:, 0])
    weights = np.stack([1 - root, root * (1 - u[:, 1]), root * u[:, 1]], -1)
    return triangle, weights.astype(np.float32), share.astype(np.float32)
