# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bilateral filter on the graphics card."""

import numpy as np
import pytest
from gi_bake.gi_core.kernels.bilateral import bilateral


def an_image(h, w, c, seed):
    """Random values on a bumpy surface with holes."""
    rng = np.random.default_rng(seed)
    normal = rng.normal((0, 0, 2), 1, (h, w, 3)).astype(np.float32)
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    footprint = rng.random((h, w), np.float32) * (rng.random((h, w)) > 0.2)
    return rng.random((h, w, c), np.float32), rng.random((h, w, 3), np.float32), normal, footprint


@pytest.mark.parametrize("size", [(1, 1), (5, 70), (64, 64), (33, 129), (0, 0)])
@pytest.mark.parametrize("channels", [2, 3, 6])
@pytest.mark.parametrize("step", [1, 4])
def test_bilateral(same, size, channels, step):
    image = an_image(*size, channels, seed=step)
    same(bilateral, *image, step)
    walls = np.random.default_rng(9).integers(0, 2, (*size, 2)).astype(np.float32)
    same(bilateral, *image, step, walls)
