# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From scene-linear light to 8-bit sRGB to look at: one exposure for the whole picture, then the sRGB curve.

Our own code and not Blender's view transform, so that pictures of one scene stay comparable whatever the file's colour
management says.
"""

import numpy as np

LUMINANCE = np.array([0.2126, 0.7152, 0.0722], np.float32)


def exposure_of(pixels: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Factor that takes the 99th percentile of luminance to white; 1 for a black picture.

    pixels: (h, w, 3 or more) scene-linear. mask: (h, w) bool, the pixels that count; None means all.
    """
    luminance = pixels[..., :3] @ LUMINANCE
    values = luminance if mask is None else luminance[mask]
    white = float(np.percentile(values, 99)) if values.size else 0.0
    # A picture that is black but for a few pixels shows those.
    white = white if white > 0 else float(values.max(initial=0.0))
    return 1.0 / white if white > 0 else 1.0


def srgb(linear: np.ndarray) -> np.ndarray:
    """The sRGB curve (IEC 61966-2-1) of linear values, which are clipped to 0…1 first; same shape, float."""
    x = np.clip(linear, 0, 1)
    return np.where(x <= 0.0031308, 12.92 * x, 1.055 * np.maximum(x, 0.0031308) ** (1 / 2.4) - 0.055)


def picture(pixels: np.ndarray, exposure: float, mask: np.ndarray | None = None) -> np.ndarray:
    """(h, w, 3 or more) scene-linear to (h, w, 3) uint8 sRGB; (h, w, 4) with transparency outside a `mask`."""
    return quantise(srgb(pixels[..., :3] * np.float32(exposure)), mask)


def difference(test: np.ndarray, reference: np.ndarray, exposure: float, mask: np.ndarray | None = None) -> np.ndarray:
    """Signed difference of luminance, (h, w, 3) uint8: white is equal, red is too bright, blue too dark.

    Full red or blue is a quarter of the picture's white. test, reference: (h, w, 3 or more) scene-linear.
    """
    signed = np.clip((test - reference)[..., :3] @ LUMINANCE * (4 * exposure), -1, 1)[..., None]
    red, blue = np.array([0.80, 0.10, 0.05]), np.array([0.05, 0.25, 0.85])
    return quantise(1 - np.abs(signed) * (1 - np.where(signed > 0, red, blue)), mask)


def quantise(rgb: np.ndarray, mask: np.ndarray | None = None) -> np.ndarray:
    """(h, w, 3) of 0…1 to uint8, with an alpha channel made of `mask` (h, w) bool where there is one."""
    eight = np.rint(np.nan_to_num(rgb) * 255).astype(np.uint8)
    return eight if mask is None else np.dstack([eight, mask.astype(np.uint8) * 255])
