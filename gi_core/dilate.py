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


def spread_in(image: np.ndarray, known: np.ndarray, wanted: np.ndarray, levels: int = 6) -> np.ndarray:
    """Gives wanted texels values out of known ones around them, smoothly; those further than 2^levels keep theirs.

    image: (h, w, c). known, wanted: (h, w) bool. Means of known texels over ever larger squares, of which each texel
    takes the smallest that has any (pull-push, Gortler et al. 1996, "The lumigraph").
    """
    if not wanted.any():
        return image
    h, w = known.shape
    shape = [-(-n // (1 << levels)) << levels for n in (h, w)]
    weight = np.zeros((*shape, 1), np.float32)
    weight[:h, :w, 0] = known
    value = np.zeros((*shape, image.shape[-1]), np.float32)
    value[:h, :w] = image * weight[:h, :w]
    pyramid = [(value, weight)]
    for _ in range(levels):
        pyramid.append(tuple(a.reshape(len(a) // 2, 2, a.shape[1] // 2, 2, -1).mean((1, 3)) for a in pyramid[-1]))
    coarse = None
    for value, weight in reversed(pyramid):
        here = np.divide(value, weight, out=np.zeros_like(value), where=weight > 0)
        has = weight[..., 0] > 0
        if coarse is not None:
            wide, known_wide = (_doubled(a) for a in coarse)
            here, has = np.where(has[..., None], here, wide), has | known_wide
        coarse = here, has
    filled, has = coarse[0][:h, :w], coarse[1][:h, :w]
    return np.where((wanted & has)[..., None], filled, image)


def _doubled(a: np.ndarray) -> np.ndarray:
    return np.repeat(np.repeat(a, 2, 0), 2, 1)
