# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The closest-depth pyramid: each texel of a level has the nearest depth of 2 × 2 texels of the level below, so that a
ray in front of it is in front of all of them.

HDRP's depth is reversed, near is large, and its pyramid keeps the greatest; here near is small and it keeps the least.
"""

import numpy as np

# Beyond everything, and still finite when it is multiplied by a reciprocal.
NOTHING = np.float32(1e30)


def depth_pyramid(nearest: np.ndarray, levels: int) -> tuple[np.ndarray, np.ndarray]:
    """All levels one after the other, and where each lies.

    nearest: (h, w) float32, the nearest depth in each pixel; NOTHING where no surface is. levels: at the most; the last
        has one texel, or is the last one asked for.
    Returns (k,) float32 and (m, 3) int32: offset, width and height of each level. Sizes are rounded up.
    """
    level, parts, table = nearest, [nearest.ravel()], level_table(*nearest.shape, levels)
    for _ in table[1:]:
        h, w = level.shape
        even = np.pad(level, ((0, h % 2), (0, w % 2)), constant_values=NOTHING)
        level = even.reshape(even.shape[0] // 2, 2, -1, 2).min((1, 3))
        parts.append(level.ravel())
    return np.concatenate(parts).astype(np.float32), table


def level_table(h: int, w: int, levels: int) -> np.ndarray:
    """Offset, width and height of each level: (m, 3) int32."""
    table, offset = [], 0
    for _ in range(levels):
        table.append((offset, w, h))
        offset += h * w
        if h == w == 1:
            break
        h, w = -(-h // 2), -(-w // 2)
    return np.array(table, np.int32)


def depth_pyramid_on_gpu(gpu, nearest, levels: int):
    h, w = nearest.shape
    table = level_table(h, w, levels)
    size = int(table[-1, 0] + table[-1, 1] * table[-1, 2])
    pyramid = gpu.empty((size,), 1)
    gpu.dispatch(
        "depth_pyramid", size, {"nearest": (nearest, 1), "table": (table, 3)}, {"pyramid": pyramid},
        integers={"width": w, "height": h, "levels": len(table)}, steps=len(table),
    )  # fmt: skip
    return pyramid, table
