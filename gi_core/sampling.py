# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sample points and the shapes they are mapped to. Everything is a function of its arguments: no hidden random
state."""

from dataclasses import dataclass

import numpy as np

# R2: the two-dimensional generalisation of the golden ratio (Roberts 2018); g is the real root of x³ = x + 1.
_PLASTIC = 1.32471795724474602596
_R2 = np.array([1 / _PLASTIC, 1 / _PLASTIC**2])


def hash01(index, seed: int = 0) -> np.ndarray:
    """Uniform numbers in [0, 1) that depend on nothing but the index and the seed: (n,) integers -> (n,) float32.

    PCG's output permutation as a hash (Jarzynski & Olano 2020, "Hash Functions for GPU Rendering", pcg).
    """
    with np.errstate(over="ignore"):
        x = np.asarray(index).astype(np.uint32) + np.uint32(seed * 0x9E3779B9 & 0xFFFFFFFF)
        x = x * np.uint32(747796405) + np.uint32(2891336453)
        x = ((x >> ((x >> np.uint32(28)) + np.uint32(4))) ^ x) * np.uint32(277803737)
        x = (x >> np.uint32(22)) ^ x
        # A second round: neighbouring indices still correlate after one.
        x = x * np.uint32(747796405) + np.uint32(2891336453)
        x = ((x >> ((x >> np.uint32(28)) + np.uint32(4))) ^ x) * np.uint32(277803737)
        x = (x >> np.uint32(22)) ^ x
    return (x >> np.uint32(8)).astype(np.float32) * np.float32(2**-24)


def signed(seed: int) -> int:
    """A seed's lowest 32 bits as the signed number that shaders take: `hash01` depends on no others."""
    return (seed + 2**31) % 2**32 - 2**31


@dataclass(frozen=True)
class Samples:
    """A point's samples that one pass of a bake takes: `count` of them, from the `first` on.

    planned: how many there will be in all, by which the near field is sized; 0 for just these. Whatever is planned, the
    mean over passes, each weighed by its count, is the estimate.
    """

    count: int
    first: int = 0
    planned: int = 0

    @property
    def in_all(self) -> int:
        return self.planned or self.count

    def part(self, share: float) -> "Samples":
        """The samples of something that takes a share of them, at least one."""
        return Samples(max(1, round(self.count * share)), round(self.first * share), round(self.planned * share))

    def shift(self) -> float:
        """Where these lie in the gaps between the evenly spaced samples of earlier passes, 0…1: van der Corput's
        sequence."""
        place, turn, half = self.first // self.count, 0.0, 0.5
        while place:
            turn, place, half = turn + half * (place & 1), place >> 1, half / 2
        return turn


def r2_sequence(n: int, first: int = 0) -> np.ndarray:
    """n points of the R2 low-discrepancy sequence in [0, 1)², from the `first` on: (n, 2) float32."""
    return ((0.5 + np.arange(first, first + n)[:, None] * _R2) % 1.0).astype(np.float32)


def rotated(points: np.ndarray, index: np.ndarray, seed: int) -> np.ndarray:
    """One point set, shifted on the torus for each index (Cranley & Patterson 1976): (s, 2), (n,) -> (n, s, 2)
    float32."""
    shift = np.stack([hash01(index, 2 * seed), hash01(index, 2 * seed + 1)], -1)
    out = points[None] + shift[:, None]
    out -= out >= 1
    return out


def disk(u: np.ndarray) -> np.ndarray:
    """Unit square to unit disk, area preserving (Shirley & Chiu 1997): (..., 2) -> (..., 2) float32."""
    a, b = 2 * u[..., 0] - 1, 2 * u[..., 1] - 1
    wide = np.abs(a) > np.abs(b)
    r = np.where(wide, a, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        phi = np.where(wide, np.pi / 4 * b / a, np.pi / 2 - np.pi / 4 * a / b)
    phi = np.where(r == 0, 0, phi)
    return np.stack([r * np.cos(phi), r * np.sin(phi)], -1).astype(np.float32)


def frame(normal: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Two unit tangents that complete unit normals to right-handed frames (Duff et al. 2017): (..., 3) -> 2 × (...,
    3)."""
    x, y, z = normal[..., 0], normal[..., 1], normal[..., 2]
    sign = np.where(z >= 0, 1, -1).astype(normal.dtype)
    a = -1 / (sign + z)
    b = x * y * a
    return np.stack([1 + sign * x * x * a, sign * b, -sign * x], -1), np.stack([b, sign + y * y * a, -y], -1)


def cosine_hemisphere(normal: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Directions with density cosθ/π about unit normals: (..., 3), (..., 2) -> (..., 3) float32."""
    d = disk(u)
    tangent, bitangent = frame(normal)
    z = np.sqrt(np.maximum(0, 1 - np.sum(d * d, -1, keepdims=True)))
    return d[..., :1] * tangent + d[..., 1:] * bitangent + z * normal


def cone(axis: np.ndarray, one_minus_cos: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Directions spread evenly over a cone of half angle acos(1 − one_minus_cos): (..., 3), (...,), (..., 2) -> (...,
    3).

    The cone is given by 1 − cos since that stays exact for narrow ones.
    """
    d = disk(u)
    r2 = np.sum(d * d, -1)
    h = r2 * one_minus_cos
    # Radius on the unit sphere at height 1 − h is √(h(2 − h)).
    scale = np.sqrt(one_minus_cos * (2 - h))
    tangent, bitangent = frame(axis)
    return (
        (scale * d[..., 0])[..., None] * tangent
        + (scale * d[..., 1])[..., None] * bitangent
        + (1 - h)[..., None] * axis
    )


def systematic(weights: np.ndarray, n: int, offset: float = 0.5) -> np.ndarray:
    """n indices drawn in proportion to weights, evenly spaced on their CDF: (m,) -> (n,) int64, ascending.

    Where the order of the weights is coherent in space, so is the stratification.
    Raises ValueError when no weight is positive.
    """
    cdf = np.cumsum(weights, dtype=np.float64)
    if not cdf.size or not cdf[-1] > 0:
        raise ValueError("no weight is positive: there is nothing to draw from")
    return np.minimum(np.searchsorted(cdf, (np.arange(n) + offset) / n * cdf[-1], "right"), np.flatnonzero(weights)[-1])


def morton(cells: np.ndarray) -> np.ndarray:
    """Place along the three-dimensional Z-order curve: (n, 3) integers below 2¹⁰ -> (n,) uint32 below 2³⁰."""
    v = cells.astype(np.uint32)
    for shift, mask in ((16, 0x030000FF), (8, 0x0300F00F), (4, 0x030C30C3), (2, 0x09249249)):
        v = (v | (v << np.uint32(shift))) & np.uint32(mask)
    return v[:, 0] | (v[:, 1] << np.uint32(1)) | (v[:, 2] << np.uint32(2))
