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

# Products that are smaller, as a share of their sum, have no sign.
_ROUNDING = np.float32(2**-23)


def closest(origins: np.ndarray, directions: np.ndarray, far: np.ndarray, bvh) -> np.ndarray:
    """The nearest hits: (n, 3), (n, 3) float32 unit directions, (n,), Bvh -> (n, 4) float32.

    Of each the triangle, −1 for a miss, the weights of its second and third corner, and the distance, `far` for a miss.
    """
    distance, u, v = _met(origins, directions, far, bvh)
    first = np.argmin(distance, -1)[:, None]
    distance, u, v = (np.take_along_axis(a, first, -1)[:, 0] for a in (distance, u, v))
    hit = np.isfinite(distance)
    triangle, distance = np.where(hit, bvh.triangle[first[:, 0]], -1), np.where(hit, distance, far)
    return np.stack([triangle, np.where(hit, u, 0), np.where(hit, v, 0), distance], -1).astype(np.float32)


def closest_on_gpu(gpu, origins, directions, far, bvh):
    hits = gpu.empty((len(origins), 4), 4)
    trace(gpu, "rays_closest", len(origins), _rays(origins, directions, far), {"hit": hits}, bvh, is_any=False)
    return hits


def occluded(origins: np.ndarray, directions: np.ndarray, far: np.ndarray, bvh) -> np.ndarray:
    """Whether rays meet anything: as for `closest` -> (n,) bool."""
    return np.isfinite(_met(origins, directions, far, bvh)[0]).any(-1)


def occluded_on_gpu(gpu, origins, directions, far, bvh):
    blocked = gpu.empty((len(origins),), 1, bool)
    trace(gpu, "rays_occluded", len(origins), _rays(origins, directions, far), {"blocked": blocked}, bvh, is_any=True)
    return blocked


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


def trace(gpu, source: str, n: int, inputs: dict, outputs: dict, bvh, is_any: bool, integers: dict | None = None):
    """Runs a kernel that calls `traced` of rays.glsl once for each item. is_any: any hit is as good as the nearest."""
    boxes = {"box_low": (bvh.low, 4), "box_high": (bvh.high, 4)}
    corners = {"corner_a": (bvh.a, 3), "corner_b": (bvh.b, 3), "corner_c": (bvh.c, 3)}
    if not is_any:
        corners["which"] = (bvh.triangle, 1)
    gpu.dispatch(
        source, n, {**inputs, **boxes, **corners}, outputs, integers=integers,
        defines={"ANY": int(is_any)}, with_sources=("triangle", "rays"), steps=_STEPS,
    )  # fmt: skip


# Boxes and triangles that a ray looks at, roughly.
_STEPS = 64


def _rays(origins, directions, far) -> dict:
    return {"origin": (origins, 3), "direction": (directions, 3), "far": (far, 1)}
