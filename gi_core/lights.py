# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lamps send out, as Cycles has them: towards a point (direct light) and out into the scene (maps, virtual
lights).

Measured against Cycles in tests/addon/test_direct_cycles.py.
"""

from dataclasses import dataclass

import numpy as np

from .sampling import cone, disk, frame
from .scene import Light
from .vectors import dot, length, normalize

# A spread of exactly π is a plain Lambertian light in Cycles.
_FULL_SPREAD = np.pi - 1e-4


@dataclass(frozen=True)
class Arrival:
    """Light at receivers from one sampled point of a lamp each.

    direction: (..., 3) float32, unit, from the receiver to the light.
    distance: (...) float32 to the sampled point [m]; infinite for suns.
    irradiance: (..., 3) float32 on a surface perpendicular to `direction`; times the receiver's cosine its mean over
        the samples is the lamp's [W/m²].
    """

    direction: np.ndarray
    distance: np.ndarray
    irradiance: np.ndarray


def axes(light: Light) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """World vectors: half extents of an area light along X and Y [m], and the unit direction in which a lamp shines."""
    x, y = light.matrix[:3, 0] * light.size[0] / 2, light.matrix[:3, 1] * light.size[1] / 2
    return x, y, -normalize(light.matrix[:3, 2])


def area(light: Light) -> float:
    """An area light's surface [m²]."""
    x, y, _ = axes(light)
    square = 4 * np.linalg.norm(np.cross(x, y))
    return float(square * np.pi / 4 if light.shape == "ELLIPSE" else square)


def radiance(light: Light) -> np.ndarray:
    """Radiance of an area light of full spread: (3,) [W/(m²·sr)]."""
    return light.power / (np.pi * area(light))


def points_on(light: Light, u: np.ndarray) -> np.ndarray:
    """Points spread evenly over an area light: (..., 2) -> (..., 3) float32."""
    x, y, _ = axes(light)
    local = disk(u) if light.shape == "ELLIPSE" else 2 * u - 1
    return (light.matrix[:3, 3] + local[..., :1] * x + local[..., 1:] * y).astype(np.float32)


def spread_gain(light: Light, cosine: np.ndarray) -> np.ndarray:
    """Radiance at an angle to an area light's axis over that of full spread: cosines (...) -> (...).

    Cycles' softbox grid (D10594): falls linearly in the tangent to 0 at half the spread a; (tan a − tan x)/(tan a − a)
    keeps the light's power.
    """
    if light.spread >= _FULL_SPREAD:
        return np.ones_like(cosine)
    half = max(light.spread, np.radians(1)) / 2
    cosine = np.clip(cosine, 1e-6, 1)
    tangent = np.sqrt(1 - cosine * cosine) / cosine
    return np.maximum(np.tan(half) - tangent, 0) / (np.tan(half) - half)


def spot_gain(light: Light, direction: np.ndarray) -> np.ndarray:
    """Intensity of a spot light in a direction over that of a point light: (..., 3) unit, away from the lamp -> (...).

    Smooth step over the blended rim of the cone, in the lamp's own space: scale along X and Y makes the cone elliptic.
    """
    if light.kind != "SPOT":
        return np.ones(direction.shape[:-1], np.float32)
    # Axes of unit length keep a uniform scale from counting, as in Cycles; what counts is the scale along Z over the
    # others.
    scale = np.linalg.norm(light.matrix[:3, :3], axis=0)
    x, y, z = (dot(direction, axis) for axis in (light.matrix[:3, :3] / scale**2).T.astype(direction.dtype))
    cos_half = np.cos(light.spot_angle / 2)
    t = np.clip((-z / np.sqrt(x * x + y * y + z * z) - cos_half) / max((1 - cos_half) * light.spot_blend, 1e-4), 0, 1)
    return (t * t * (3 - 2 * t)).astype(np.float32)


def towards(light: Light, position: np.ndarray, u: np.ndarray) -> Arrival:
    """Light that arrives at points from one sample of a lamp each: (..., 3) points, (..., 2) in [0, 1)² -> Arrival.

    Points may stand for several samples each: (n, 1, 3) with (n, s, 2).
    """
    if light.kind == "SUN":
        direction = cone(-axes(light)[2], 1 - np.cos(light.angle / 2), u)
        # Even over the sun's disk of radiance P/(π sin²): its power is irradiance on a perpendicular surface, cosine
        # included.
        gain = np.full(direction.shape[:-1], 2 / (1 + np.cos(light.angle / 2)))
        return _arrival(direction, np.full(gain.shape, np.inf), gain, light.power)

    if light.kind == "AREA":
        to_light = points_on(light, u) - position
        distance = length(to_light)
        direction = normalize(to_light)
        cosine = np.maximum(-dot(direction, np.float32(axes(light)[2])), 0)
        gain = cosine * spread_gain(light, cosine) * area(light) / np.maximum(distance, 1e-9) ** 2
        return _arrival(direction, distance, gain, radiance(light))

    intensity = light.power / (4 * np.pi)
    # From here on single precision will do, at half the time: what is small is not found as a difference.
    to_center = np.float32(light.matrix[:3, 3] - position)
    center_distance = length(to_center)
    axis = normalize(to_center)
    if light.radius <= 0 or light.soft_falloff:
        # A disk that faces the receiver, or a point.
        if light.radius > 0:
            local = disk(u) * light.radius
            x, y = frame(axis)
            to_center = _by_coordinate(
                lambda k: to_center[..., k] + local[..., 0] * x[..., k] + local[..., 1] * y[..., k]
            )
        distance = length(to_center)
        direction = normalize(to_center)
        cosine = dot(direction, axis)
        gain = cosine / np.maximum(distance, 1e-9) ** 2
    else:
        # The part of a sphere that the receiver sees: a cone of even radiance. Inside the sphere it is all around.
        sine2 = np.minimum((light.radius / np.maximum(center_distance, 1e-9)) ** 2, 1)
        inside = center_distance <= light.radius
        # 1 − cos from sin² without cancellation; small spheres need it.
        one_minus_cos = np.where(inside, 2.0, sine2 / (1 + np.sqrt(1 - sine2)))
        direction = cone(axis, one_minus_cos, u)
        off = direction - axis
        cosine = 1 - dot(off, off) / 2
        root = np.sqrt(np.maximum(light.radius**2 - center_distance**2 * (1 - cosine) * (1 + cosine), 0))
        distance = center_distance * cosine + np.where(inside, root, -root)
        gain = 2 * np.pi * one_minus_cos / (np.pi * light.radius**2)
    return _arrival(direction, distance, gain * spot_gain(light, -direction), intensity)


def _arrival(direction, distance, gain, color) -> Arrival:
    gain, color = np.float32(np.maximum(gain, 0)), np.float32(color)
    irradiance = _by_coordinate(lambda k: gain * color[k])
    return Arrival(direction.astype(np.float32), distance.astype(np.float32), irradiance)


def _by_coordinate(of) -> np.ndarray:
    """Vectors (..., 3) by what a coordinate of all is: numpy takes twice as long over rows of three."""
    return np.stack([of(k) for k in range(3)], -1)
