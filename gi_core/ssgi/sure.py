# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which pixels stand for all that they cover. One whose neighbours show another surface may cover some of that too, and
one at a shadow's edge is lit in part: what a ray meets there is not what the pixel's centre shows."""

import numpy as np

from ..vectors import dot, length
from .frame import GBuffer

# How far out of each other's plane neighbours may lie, as a share of the way between them, and how much brighter than
# the other one may be.
_BENT, _UNEVEN = np.float32(0.25), np.float32(0.3)

# Differences of light below this share of the mean are none.
_DARK = np.float32(1e-4)

# Rows worked on at once.
_ROWS = 64


def sure_pixels(buffer: GBuffer, light: np.ndarray) -> np.ndarray:
    """Pixels whose neighbours, eight of them, show the same surface as evenly lit.

    light: (h, w, 3) float32, what surfaces send. Returns (h, w) bool.
    """
    sure, brightness = buffer.surface, light.max(-1)
    dark = _DARK * brightness.mean()
    h, w = sure.shape
    for first in range(0, h, _ROWS):
        for j, i in ((0, 1), (1, 0), (1, 1), (1, -1)):
            stop, left, right = min(first + _ROWS, h - j), max(0, -i), w - max(0, i)
            here, there = np.s_[first:stop, left:right], np.s_[first + j : stop + j, left + i : right + i]
            apart = buffer.position[there] - buffer.position[here]
            off = np.maximum(*(np.abs(dot(apart, buffer.face[side])) for side in (here, there)))
            less, more = (least(brightness[here], brightness[there]) for least in (np.minimum, np.maximum))
            alike = buffer.surface[here] & buffer.surface[there]
            alike &= (off <= _BENT * length(apart)) & (more - less <= _UNEVEN * less + dark)
            sure[here] &= alike
            sure[there] &= alike
    return sure
