# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light from emitting surfaces, as points on them."""

import numpy as np

from .geometry import Geometry
from .sampling import r2_sequence, systematic
from .trace import offset
from .vectors import length
from .vpls import Vpls, coherent, equalized


def emitters(geometry: Geometry, n: int) -> Vpls:
    """About n points that stand for all emitting surfaces, both sides, each of the same flux; none where nothing emits.

    Triangles are drawn by area times emission, points on them evenly, and textures decide what each is worth.
    """
    scene = geometry.scene
    strength = np.array([np.mean(np.abs(m.emission.value)) for m in scene.materials], np.float32)
    if not np.any(strength) or not len(geometry.triangles):
        return Vpls.concatenate([])
    every = np.arange(len(geometry.triangles))
    a, b, c = np.moveaxis(geometry.vertices[geometry.triangles], 1, 0)
    area = length(np.cross(b - a, c - a)) / 2
    weight = area * strength[geometry.material(every)]
    if not np.any(weight > 0):
        return Vpls.concatenate([])

    triangle = systematic(weight, n)
    # The standing area of each draw: its triangle's area over the draws that the triangle expects.
    share = weight.sum() / (n * weight[triangle]) * area[triangle]
    u = r2_sequence(n)
    root = np.sqrt(u[:, 0])
    weights = np.stack([1 - root, root * (1 - u[:, 1]), root * u[:, 1]], -1).astype(np.float32)
    position, normal = geometry.position(triangle, weights), geometry.face_normal(triangle)
    radiance = geometry.color("emission", triangle, weights)
    flux = np.pi * radiance * share[:, None].astype(np.float32)
    sides = [Vpls(position, offset(position, side), side, flux, share.astype(np.float32)) for side in (normal, -normal)]
    every = Vpls.concatenate(sides)
    every = every[coherent(every)]
    return equalized(every, every.flux.mean(-1), n)
