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


def spread_in(image: np.ndarray, known: np.ndarray, wanted: np.ndarray) -> np.ndarray:
    """Gives wanted texels values out of known ones around them, smoothly, however far these are.

    image: (h, w, c). known, wanted: (h, w) bool. Means of known texels over ever larger squares, of which each texel
    takes the smallest that has any (pull-push, Gortler et al. 1996, "The lumigraph").
    """
    if not wanted.any() or not known.any():
        return image
    weight = known[..., None].astype(np.float32)
    pyramid = [(image * weight, weight)]
    while len(weight) > 1 or weight.shape[1] > 1:
        value, weight = (_halved(a) for a in pyramid[-1])
        pyramid.append((value, weight))
    filled = np.zeros((1, 1, image.shape[-1]), np.float32)
    for value, weight in reversed(pyramid):
        wide = np.repeat(np.repeat(filled, 2, 0), 2, 1)[: len(weight), : weight.shape[1]]
        filled = np.divide(value, weight, out=wide, where=weight > 0)
    return np.where(wanted[..., None], filled, image)


def _halved(a: np.ndarray) -> np.ndarray:
    """Means over squares of four, of which the last hang over the edge: (h, w, c) -> (⌈h/2⌉, ⌈w/2⌉, c)."""
    h, w, c = a.shape
    even = np.pad(a, ((0, h % 2), (0, w % 2), (0, 0)))
    return even.reshape((h + 1) // 2, 2, (w + 1) // 2, 2, c).mean((1, 3))
