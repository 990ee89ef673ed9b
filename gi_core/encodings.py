# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light in 8 bits a channel: as a picture, or with a multiplier or divisor in alpha that keeps its full range.

    srgb    the sRGB curve; what is brighter than white is lost
    rgbm    light = rgb · alpha · range
    rgbd    light = rgb / alpha · range

Of rgbm and rgbd rgb is linear. All are light times the exposure.
"""

import numpy as np

from .display import picture

# How much brighter than what alpha 1 stands for rgbd can be: darker than this alpha is too coarse.
_LEAST_ALPHA = 16 / 255


def encoded(pixels: np.ndarray, encoding: str, exposure: float, mask: np.ndarray | None) -> tuple[np.ndarray, str]:
    """Linear light as 8-bit values, and the sentence that says how they are decoded.

    pixels: (h, w, 3 or 4). mask: (h, w) bool, where there is light, None for everywhere. Returns (h, w, 3 or 4) uint8.
    """
    light = np.maximum(np.nan_to_num(pixels[..., :3]), 0) * np.float32(exposure)
    if encoding == "srgb":
        return picture(pixels, exposure, mask), f"linear = sRGB to linear(rgb) / {exposure:.9g}"
    peak = light.max(-1)
    most = float(peak.max(initial=0.0)) or 1.0
    if encoding == "rgbm":
        alpha = np.ceil(np.clip(peak / most, 1 / 255, 1) * 255) / 255
        rgb, sentence = light / (alpha * most)[..., None], f"linear = rgb * alpha * {most / exposure:.9g}"
    else:
        scale = most * _LEAST_ALPHA
        alpha = np.floor(np.clip(scale / np.maximum(peak, 1e-20), _LEAST_ALPHA, 1) * 255 + 1e-3) / 255
        rgb, sentence = light * alpha[..., None] / scale, f"linear = rgb / alpha * {scale / exposure:.9g}"
    return np.rint(np.clip(np.dstack([rgb, alpha]), 0, 1) * 255).astype(np.uint8), sentence
