# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The pictures of a comparison, 8-bit sRGB; colours have one scale for all pictures of all reports."""

import numpy as np

from ...gi_core import display, metrics

# Magma (Smith & van der Walt, CC0) at nine even steps.
_MAGMA = np.array([
    (0, 0, 4), (29, 17, 71), (81, 18, 124), (130, 38, 129), (182, 54, 121), (230, 81, 100), (251, 136, 97),
    (254, 194, 135), (252, 253, 191),
]) / 255  # fmt: skip
_LEFT_OUT, _DARK = np.array([0.95, 0.45, 0.1]), np.array([0.15, 0.45, 0.95])
# Of the false colours of errors, a logarithmic scale.
LOW, HIGH = 0.01, 1.0
# Of the signed difference, as a share of white.
SIGNED = 0.25


def magma(value: np.ndarray) -> np.ndarray:
    """0…1 of any shape to RGB in 0…1, one dimension more."""
    place = np.clip(np.nan_to_num(value), 0, 1) * (len(_MAGMA) - 1)
    low = np.minimum(place.astype(int), len(_MAGMA) - 2)
    return _MAGMA[low] + (place - low)[..., None] * (_MAGMA[low + 1] - _MAGMA[low])


def error(test: np.ndarray, reference: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """The root of each pixel's share of relMSE in false colours, black at LOW and light yellow at HIGH: (h, w, 4)."""
    x, r = test.astype(np.float64), reference.astype(np.float64)
    relative = np.sqrt(np.mean((x - r) ** 2 / (r**2 + 0.01), axis=-1))
    return display.quantise(magma(np.log(np.maximum(relative, LOW) / LOW) / np.log(HIGH / LOW)), mask)


def flip(test: np.ndarray, reference: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """FLIP in its authors' colours, 0…1: (h, w, 4) uint8."""
    return display.quantise(magma(metrics.flip_map(test, reference, mask)), mask)


def counted(
    reference: np.ndarray, exposure: float, mask: np.ndarray, seen: np.ndarray, dark: np.ndarray | None
) -> np.ndarray:
    """What counts, in grey; orange what is seen and left out, blue the region that is to be dark: (h, w, 4) uint8."""
    grey = display.srgb(reference @ display.LUMINANCE * exposure)[..., None] * 0.5 + 0.35
    rgb = np.where(mask[..., None], grey, _LEFT_OUT)
    if dark is not None:
        rgb = np.where((mask & dark)[..., None], (grey + _DARK) / 2, rgb)
    return display.quantise(np.broadcast_to(rgb, (*mask.shape, 3)), seen)
