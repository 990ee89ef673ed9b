# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The near field: light from surfaces so close that single virtual lights would make bright specks.

The transfer G = cosθ_p cosθ_x / (π d²) of a light is clamped to 1/A, and what the clamp takes, the share 1 − 1/(A G) of
the light that comes from within √(A/π), is found by short rays instead (Kollig & Keller 2006, "Illumination in the
Presence of Weak Singularities"). Both parts are bounded and their sum is exact, whatever A is.
"""

from dataclasses import dataclass

import numpy as np

from .gathering import Bound
from .sampling import Samples, cosine_hemisphere, r2_sequence, rotated
from .surfels import Surfels, along_rays
from .trace import Tracer
from .vectors import dot, pick
from .vpls import Vpls

# A over the surface that one sample stands for where lights are dense, at the lower quartile. The more, the less noise
# from lights and the more from short rays; measured on the samples, noise at equal time is least about here.
_QUARTILE, _REACH = 0.25, 8.0

# Short rays for each sample of virtual lights.
_RAYS = 0.75


@dataclass(frozen=True)
class NearField:
    """area: A [m²]. rays: the short rays from each point."""

    area: float
    rays: Samples

    @staticmethod
    def of(lights: Vpls, samples: Samples) -> "NearField":
        """The near field that fits so many samples of a cloud of lights."""
        area = float(np.quantile(lights.area, _QUARTILE)) * len(lights) / samples.in_all * _REACH
        return NearField(area, samples.part(_RAYS))

    @property
    def clamp(self) -> Bound:
        """The bound of lights' transfer; what it takes, short rays find."""
        return Bound("geometry", self.area)

    @property
    def radius(self) -> float:
        """Beyond this distance nothing is clamped [m]."""
        return float(np.sqrt(self.area / np.pi))


def short_rays(tracer: Tracer, here: Surfels, field: NearField, seed: int) -> tuple[np.ndarray, Surfels, np.ndarray]:
    """What surrounds points within the near field.

    Returns for the rays that meet what the clamp takes light from: the point's row (m,), the surfels that are met, and
    the share that the clamp takes of their light (m,). Rays are cosine-distributed, `field.rays.count` from each point:
    the irradiance of a point is the sum of π · radiance · share over its rays, divided by their number.
    """
    rays = field.rays.count
    row = np.repeat(np.arange(len(here)), rays)
    u = rotated(r2_sequence(rays, field.rays.first), here.place, seed * 1024 + 1022).reshape(-1, 2)
    direction = cosine_hemisphere(pick(here.normal, row), u)
    front = np.flatnonzero(dot(direction, pick(here.face, row)) > 0)
    row, direction = row[front], pick(direction, front)
    # A place of its own for each ray, so that what it meets draws samples of its own.
    place = (here.place[row] << 16) + field.rays.first + front % rays
    met, hit = along_rays(tracer, pick(here.origin, row), direction, place, field.radius, reflecting=True)
    row, direction = row[hit], pick(direction, hit)
    d = met.position - pick(here.position, row)
    cosines = dot(pick(here.normal, row), direction) * np.maximum(-dot(met.face, direction), 0)
    share = np.maximum(0, 1 - np.pi * dot(d, d) / (field.area * np.maximum(cosines, 1e-20)))
    share *= here.shadowing(row, direction)
    near = np.flatnonzero(share)
    return row[near], met[near], share[near]


def summed(row: np.ndarray, values: np.ndarray, n: int) -> np.ndarray:
    """Values (m, 3) added up by row (m,): (n, 3) float32."""
    return np.stack([np.bincount(row, values[:, c], n) for c in range(3)], -1).astype(np.float32)
