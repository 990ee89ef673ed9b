# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Islands of a lightmap: texels that hang together, each with its bounding box."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Islands:
    """label: (h, w) int64, the number of each texel's island, −1 for none.
    rows, columns: (k, 2) int64, each island's first and its last plus one."""

    label: np.ndarray
    rows: np.ndarray
    columns: np.ndarray

    def __len__(self) -> int:
        return len(self.rows)


def islands(valid: np.ndarray) -> Islands:
    """Islands of (h, w) bool; texels that touch at a corner hang together.

    Trees of texels are hooked under the lower of two neighbours' roots and flattened until nothing changes (Shiloach &
    Vishkin 1982).
    """
    height, width = valid.shape
    index = np.arange(height * width).reshape(height, width)
    pairs = []
    for dy, dx in ((0, 1), (1, 0), (1, 1), (1, -1)):
        a = (slice(0, height - dy), slice(max(0, -dx), width - max(0, dx)))
        b = (slice(dy, height), slice(max(0, dx), width - max(0, -dx)))
        both = valid[a] & valid[b]
        pairs.append(np.stack([index[a][both], index[b][both]]))
    a, b = np.concatenate(pairs, 1)
    root = np.arange(height * width)
    while len(a):
        first, second = root[a], root[b]
        apart = first != second
        a, b, first, second = a[apart], b[apart], first[apart], second[apart]
        np.minimum.at(root, np.maximum(first, second), np.minimum(first, second))
        while not np.array_equal(root, above := root[root]):
            root = above
    place = np.flatnonzero(valid)
    _, number = np.unique(root[place], return_inverse=True)
    number = number.reshape(-1)
    label = np.full(height * width, -1)
    label[place] = number
    count = int(number.max()) + 1 if len(place) else 0
    boxes = []
    for at in (place // width, place % width):
        low, high = np.full(count, max(height, width)), np.zeros(count, np.int64)
        np.minimum.at(low, number, at)
        np.maximum.at(high, number, at + 1)
        boxes.append(np.stack([low, high], -1))
    return Islands(label.reshape(height, width), *boxes)
