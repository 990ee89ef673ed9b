# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""One pass of the joint bilateral filter: a 5 × 5 B-spline with holes (à trous; Dammertz et al. 2010), stopped at edges
of the surface.

A tap counts by how far it lies off the centre's tangent plane and how its normal differs, and not at all behind a wall;
irradiance itself does not stop the filter, so that noise does not either.
"""

import numpy as np

_SPLINE = np.array([1, 4, 6, 4, 1], np.float32) / 16
# Normals: dot¹⁶ is ½ at 17°.
_NORMAL_SQUARINGS = 4
# Pixels that an invocation of the shader works out.
_BLOCK = 6


def bilateral(value, position, normal, footprint, step: int, walls=None, rows: slice = slice(None)) -> np.ndarray:
    """Values averaged along the surface.

    value: (h, w, c) float32; position, normal: (h, w, 3) float32; footprint: (h, w) float32, size of a pixel on its
    surface [m], 0 where there is none; step: pixels between taps; walls: (h, w, 2) float32, how many walls stand
    between a pixel and the beginning of its row and of its column: a tap counts only where none stands on the way to
    it, along the row and then along the column. rows: which are wanted.
    Returns (rows, w, c) float32, zero where there is no surface.
    """
    margin = 2 * step
    first, last, _ = rows.indices(len(value))
    reached = slice(max(first - margin, 0), last + margin)
    if first > 0 or last < len(value):
        walls = walls if walls is None else walls[reached]
        part = bilateral(value[reached], position[reached], normal[reached], footprint[reached], step, walls)
        return part[first - reached.start :][: last - first]
    h, w, c = value.shape
    pad = ((margin, margin), (margin, margin))
    weight_padded = np.pad((footprint > 0).astype(np.float32), pad)
    # What is filtered, and what stops it, in planes of their own: whole rows go through the arithmetic units at once.
    values = [np.pad(value[..., k], pad) for k in range(c)]
    positions = [np.pad(position[..., k], pad) for k in range(3)]
    normals = [np.pad(normal[..., k], pad) for k in range(3)]
    in_row, in_column = (None, None) if walls is None else (np.pad(walls[..., k], pad) for k in (0, 1))
    inverse = np.where(footprint > 0, 1 / np.maximum(footprint * step, 1e-20), 0).astype(np.float32)

    total, out = np.zeros((h, w), np.float32), [np.zeros((h, w), np.float32) for _ in range(c)]
    for j in range(5):
        for i in range(5):
            at = (slice(j * step, j * step + h), slice(i * step, i * step + w))
            dot = sum(normal[..., k] * normals[k][at] for k in range(3))
            plane = sum(normal[..., k] * (positions[k][at] - position[..., k]) for k in range(3)) * inverse
            # Squared twice below: beyond this float32 ends, and the weight is nothing long before.
            plane = np.minimum(np.abs(plane), np.float32(1e4))
            weight = np.maximum(dot, 0)
            for _ in range(_NORMAL_SQUARINGS):
                weight *= weight
            weight *= weight_padded[at] * (_SPLINE[j] * _SPLINE[i]) / (1 + plane * plane) ** 2
            if walls is not None:
                beside = (slice(margin, margin + h), at[1])
                weight *= (in_row[beside] == walls[..., 0]) & (in_column[at] == in_column[beside])
            total += weight
            for k in range(c):
                out[k] += weight * values[k][at]
    return np.stack(out, -1) / np.maximum(total, 1e-20)[..., None] * (footprint > 0)[..., None]


def bilateral_on_gpu(gpu, value, position, normal, footprint, step: int, walls=None, rows: slice = slice(None)):
    h, w, c = value.shape
    channels = next(n for n in (4, 3, 2, 1) if c % n == 0)
    result = gpu.empty(value.shape, channels)
    facing = gpu.empty((h, w, 4), 4)
    gpu.dispatch("facing", h * w, {"normal": (normal, 3), "footprint": (footprint, 1)}, {"facing": facing})
    inputs = {"value": (value, channels), "position": (position, 3), "facing": (facing, 4)}
    bands = -(-h // (_BLOCK * step)) * step
    gpu.dispatch(
        "bilateral", bands * w, inputs if walls is None else {**inputs, "walls": (walls, 2)}, {"result": result},
        integers={"width": w, "height": h, "step_": step},
        defines={"COLORS": c // channels, "WALLS": int(walls is not None)},
        steps=25 * _BLOCK,
    )  # fmt: skip
    return result
