# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Grow the islands of a lightmap into the empty texels around them, so that filtering finds no black there."""

import numpy as np


def dilate(image: np.ndarray, valid: np.ndarray, margin: int) -> tuple[np.ndarray, np.ndarray]:
    """Give each empty texel within `margin` [texels] of a valid one the value of the nearest.

    image: (h, w, c). valid: (h, w) bool. Returns the new (h, w, c) and the (h, w) bool of the texels that now hold a
    value; valid texels keep theirs, the others are as they came. Distances are Euclidean, between centres.
    """
    if margin < 0:
        raise ValueError(f"a margin is 0 or more texels, not {margin}")
    height, width = valid.shape
    column = np.broadcast_to(np.arange(width), valid.shape)
    # The nearest valid texel of the own row, per texel; "none" is so far away that it never comes within the margin.
    none = 4 * (width + height + margin)
    left = np.maximum.accumulate(np.where(valid, column, -none), axis=1)
    right = np.minimum.accumulate(np.where(valid, column, none)[:, ::-1], axis=1)[:, ::-1]
    in_row = np.where(column - left <= right - column, left, right)
    # The nearest of all is the nearest of one of the rows within the margin.
    best = np.full(valid.shape, margin * margin + 1)
    source_row, source_column = np.zeros_like(best), np.zeros_like(best)
    for dy in sorted(range(-margin, margin + 1), key=abs):
        here, there = slice(max(0, -dy), height - max(0, dy)), slice(max(0, dy), height - max(0, -dy))
        if here.start >= here.stop:
            continue
        distance = (in_row[there] - column[here]) ** 2 + dy * dy
        nearer = distance < best[here]
        best[here] = np.where(nearer, distance, best[here])
        source_row[here] = np.where(nearer, np.arange(height)[there, None], source_row[here])
        source_column[here] = np.where(nearer, in_row[there], source_column[here])
    filled = best <= margin * margin
    grown = image.copy()
    grown[filled] = image[source_row[filled], source_column[filled]]
    return grown, filled
