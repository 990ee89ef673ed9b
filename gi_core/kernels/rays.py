# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays against triangles.

A ray passes an edge on the side that the sign of their Plücker product says; it meets a triangle where the signs of all
three edges agree. Two triangles that share an edge find the same product for it, so nothing slips through between them
(Davidovič, Engelhardt, Georgiev, Slusallek & Dachsbacher 2012, "3D Rasterization: A Bridge between Rasterization and
Ray Casting"; Embree's robust rays do the same).

Here every ray looks at every triangle; on a graphics card it goes down the hierarchy of boxes to the same answer.
"""

import numpy as np

from ..vectors import dot
from .veil import solid

# What is farther than a surface that lets light through by no more than this factor, and than this share of where the
# ray starts, is that surface.
_SAME, _NEAR = np.float32(1.000015), np.float32(1e-6)

# Products that are smaller, as a share of their sum, have no sign.
_ROUNDING = np.float32(2**-23)


def closest(origins: np.ndarray, directions: np.ndarray, far: np.ndarray, bvh, until=None) -> np.ndarray:
    """Where rays end: (n, 3), (n, 3) float32 unit directions, (n,), Bvh -> (n, 4) float32.

    Of each the triangle, −1 for none, the weights of its second and third corner, and the distance, `far` for none. A
    ray ends at the nearest triangle; where there are some that let light through, at the nearest behind which no more
    of it is left than until, (n,).
    """
    return _followed(origins, directions, far, bvh, until)[0]


def closest_on_gpu(gpu, origins, directions, far, bvh, until=None):
    hits = gpu.empty((len(origins), 4), 4)
    rays = _rays(origins, directions, far)
    if bvh.veil is not None:
        rays["until"] = until, 1
    trace(gpu, "rays_closest", len(origins), rays, {"hit": hits}, bvh=bvh, is_any=False)
    return hits


def through(origins: np.ndarray, directions: np.ndarray, far: np.ndarray, bvh) -> np.ndarray:
    """The share of light that comes through all that rays meet: as for `closest` -> (n,) float32, 0…1."""
    return _followed(origins, directions, far, bvh, np.zeros(len(origins), np.float32))[1]


def through_on_gpu(gpu, origins, directions, far, bvh):
    share = gpu.empty((len(origins),), 1)
    trace(gpu, "rays_through", len(origins), _rays(origins, directions, far), {"share": share}, bvh=bvh, is_any=True)
    return share


def _followed(origins, directions, far, bvh, until) -> tuple[np.ndarray, np.ndarray]:
    """Where rays end, as for `closest`, and what comes through until there, (n,) float32."""
    n = len(origins)
    distance, u, v = _met(origins, directions, far, bvh)
    found, left, beyond = np.zeros((n, 4), np.float32), np.ones(n, np.float32), np.full(n, -1, np.float32)
    nearby, alive = near_of(origins), np.arange(n)
    # A ray ends at those, so that none has been passed.
    ends = np.ones(len(bvh.a), bool) if bvh.veil is None else bvh.veil.second[:, 2] < 0
    while len(alive):
        # What is as far is the same surface: an edge belongs to two triangles.
        behind = np.where(ends | (distance[alive] > beyond[alive, None]), distance[alive], np.inf)
        k = np.argmin(behind, -1)
        met = np.isfinite(behind[np.arange(len(alive)), k])
        found[alive[~met]] = far[alive[~met], None] * np.float32([0, 0, 0, 1]) - np.float32([1, 0, 0, 0])
        alive, k = alive[met], k[met]
        beyond[alive] = past(distance[alive, k], nearby[alive])
        found[alive] = np.stack([bvh.triangle[k], u[alive, k], v[alive, k], distance[alive, k]], -1)
        left[alive] *= 0 if bvh.veil is None else 1 - solid(bvh.veil, k, u[alive, k], v[alive, k])
        alive = alive[left[alive] > (0 if until is None else until[alive])]
    return found, left


def near_of(origins: np.ndarray) -> np.ndarray:
    """How far what rounding does to a ray reaches, by where it starts: (n, 3) -> (n,) float32 [m]."""
    return _NEAR * np.abs(origins).max(-1, initial=0)


def past(distance: np.ndarray, nearby: np.ndarray) -> np.ndarray:
    """How far a ray is when it has gone through a surface: (n,), (n,) -> (n,) float32 [m]."""
    return distance * _SAME + nearby


def _met(origins, directions, far, bvh):
    """Where each ray meets each triangle: distance, infinite for none, and weights u and v, (n, t) each."""
    corners = (corner[None] - origins[:, None] for corner in (bvh.a, bvh.b, bvh.c))
    distance, u, v = met(*corners, directions[:, None])
    with np.errstate(invalid="ignore"):
        return np.where((distance >= 0) & (distance <= far[:, None]), distance, np.inf), u, v


def met(a: np.ndarray, b: np.ndarray, c: np.ndarray, d: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where rays along d meet triangles, whose corners are seen from the rays' start: (..., 3) each.

    Returns the distance (...), below zero or NaN for none, and weights u and v of the second and the third corner.
    """
    u = dot(np.cross(c - a, c + a), d)
    v = dot(np.cross(a - b, a + b), d)
    w = dot(np.cross(b - c, b + c), d)
    total = u + v + w
    slack = _ROUNDING * np.abs(total)
    inside = (np.minimum(np.minimum(u, v), w) >= -slack) | (np.maximum(np.maximum(u, v), w) <= slack)
    normal = np.cross(b - a, c - a)
    slant = dot(normal, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = dot(normal, a) / slant
        return np.where(inside & (slant != 0), distance, np.float32(-1)), u / total, v / total


def trace(
    gpu, source: str, n: int, inputs: dict, outputs: dict, integers: dict | None = None, floats: dict | None = None,
    defines: dict | None = None, *, bvh, is_any: bool, rays: int = 1,
):  # fmt: skip
    """Runs a kernel that calls functions of rays.glsl, see `GpuDevice.dispatch`. is_any: what comes through is asked
    for, and not where. rays: that an item traces, or looks at."""
    boxes = {"box_low": (bvh.low, 4), "box_high": (bvh.high, 4)}
    corners = {"corner_a": (bvh.a, 3), "corner_b": (bvh.b, 3), "corner_c": (bvh.c, 3)}
    if not is_any:
        corners["which"] = (bvh.triangle, 1)
    sources = ("triangle", "rays")
    if bvh.veil is not None:
        corners |= {f"veil_{name}": (getattr(bvh.veil, name), c) for name, c in bvh.veil.CHANNELS.items()}
        sources = "triangle", "veil", "rays"
    gpu.dispatch(
        source, n, {**inputs, **boxes, **corners}, outputs, integers, floats,
        {**(defines or {}), "ANY": int(is_any), "VEIL": int(bvh.veil is not None)}, sources, rays * _STEPS,
    )  # fmt: skip


# Boxes and triangles that a ray looks at, roughly.
_STEPS = 64


def _rays(origins, directions, far) -> dict:
    return {"origin": (origins, 3), "direction": (directions, 3), "far": (far, 1)}
