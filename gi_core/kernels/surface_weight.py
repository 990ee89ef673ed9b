# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far two points count as one surface: by depth, normal and plane (HDRP, BilateralFilter.hlsl).

    depth    max(0, 1 − |Δz|)              z over the far plane
    normal   max(0, 1 − (1 − closeness))   closeness = dot⁴
    plane    |dq|² < 0.0001 ? 1 : max(0, 1 − 2 e/|dq|)²,   e = max(|dq·n₀|, |dq·n₁|), dq from one to the other

With √√dot for the closeness, as `literal` has it, that is ·965 at 30° and ·707 still at 76°. The source's own
is ·563 at 30°. Its 0.0001 m² is an absolute length; here it is (0.01 · scale)².
"""

import numpy as np

from ..vectors import dot

_NEAR = np.float32(0.01)


def surface_weight(depth, position, normal, tap_depth, tap_position, tap_normal, scale, literal: bool = False):
    """The product of the three weights for each pair.

    depth, tap_depth: (...) float32, over the far plane. position, normal, tap_position, tap_normal: (..., 3) float32.
    scale: [m] that the source's metre stands for. literal: closeness √√dot. Returns (...) float32, 0…1.
    """
    cosine = np.maximum(dot(normal, tap_normal), 0)
    closeness = np.sqrt(np.sqrt(cosine)) if literal else cosine**2 * cosine**2
    dq = tap_position - position
    plane = plane_weight(dq, np.maximum(np.abs(dot(dq, normal)), np.abs(dot(dq, tap_normal))), scale)
    return np.maximum(0, 1 - np.abs(depth - tap_depth)) * np.minimum(closeness, 1) * plane


def surface_weight_on_gpu(
    gpu, depth, position, normal, tap_depth, tap_position, tap_normal, scale, literal: bool = False
):
    weight = gpu.empty(depth.shape, 1)
    inputs = {"depth": (depth, 1), "position": (position, 3), "normal": (normal, 3), "tap_depth": (tap_depth, 1),
              "tap_position": (tap_position, 3), "tap_normal": (tap_normal, 3),
              "scale": (np.full(depth.shape, scale) if np.isscalar(scale) else scale, 1)}  # fmt: skip
    gpu.dispatch(
        "surface_pairs", weight.items, inputs, {"weight": weight}, integers={"literal": literal},
        with_sources=("surface_weight",),
    )  # fmt: skip
    return weight


def plane_weight(dq, off, scale):
    """How far points lie in a plane: offsets dq (..., 3) float32, of which `off` (...) is out of it -> (...), 0…1."""
    d2 = dot(dq, dq)
    with np.errstate(divide="ignore", invalid="ignore"):
        plane = np.maximum(0, 1 - 2 * off / np.sqrt(d2)) ** 2
    return np.where(d2 < (_NEAR * scale) ** 2, np.float32(1), plane)
