# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Directional lightmaps: light as a function of the normal, from what it is for four of them.

Irradiance over the normal is nearly linear, E(n) = u + v·n: two bands of spherical harmonics. Four normals determine
them, the surface's own and three around it (the basis of Half-Life 2, McTaggart 2004, "Half-Life 2 source shading"), so
that what comes out is exact at the surface's own normal. Where a normal map gives that one, the three are around it,
and what relief hides of light (`bump`) is left out of theirs, of which the relief has none.
"""

import numpy as np

from . import sh
from .sampling import frame

# The four normals as tangent, bitangent and normal.
_BASIS = np.float32(
    [
        [0, 0, 1],
        [np.sqrt(2 / 3), 0, np.sqrt(1 / 3)],
        [-np.sqrt(1 / 6), np.sqrt(1 / 2), np.sqrt(1 / 3)],
        [-np.sqrt(1 / 6), -np.sqrt(1 / 2), np.sqrt(1 / 3)],
    ]
)


def named(page: str, side: int) -> str:
    """What the light of a page for one of the four normals is called."""
    return f"{page} / {side}" if side else page


def tilted(normal: np.ndarray, side: int) -> np.ndarray:
    """One of the four normals at unit normals: (n, 3) -> (n, 3) float32."""
    tangent, bitangent = frame(normal)
    x, y, z = _BASIS[side]
    return (x * tangent + y * bitangent + z * normal).astype(np.float32)


def coefficients(light: np.ndarray, normal: np.ndarray) -> np.ndarray:
    """Two bands of harmonics from light for the four normals: (4, h, w, 3), (h, w, 3) -> (h, w, 4, 3) float32."""
    inverse = np.linalg.inv(np.concatenate([np.ones((4, 1)), _BASIS], 1))
    u, x, y, z = np.einsum("ij,jhwc->ihwc", inverse, light)
    tangent, bitangent = frame(normal)
    world = [x * tangent[..., k, None] + y * bitangent[..., k, None] + z * normal[..., k, None] for k in range(3)]
    return sh.from_affine(np.stack([u, *world])).astype(np.float32)
