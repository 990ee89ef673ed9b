# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Looking colours up in textures."""

import numpy as np

from .scene import Texture


def _wrap(i: np.ndarray, n: int, extension: str) -> np.ndarray:
    if extension == "REPEAT":
        return i % n
    if extension == "MIRROR":
        i = i % (2 * n)
        return np.minimum(i, 2 * n - 1 - i)
    return np.clip(i, 0, n - 1)


def srgb_to_linear(encoded: np.ndarray) -> np.ndarray:
    """The sRGB transfer function (IEC 61966-2-1) undone."""
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def sample(texture: Texture, uv: np.ndarray) -> np.ndarray:
    """The texture's colour at each coordinate: (n, 2) -> (n, 3) float32, filtered as its `interpolation` says."""
    h, w, _ = texture.pixels.shape
    x, y = (uv * (w, h)).astype(np.float64).T
    if texture.interpolation == "CLOSEST":
        ix, iy = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        color = texture.pixels[_wrap(iy, h, texture.extension), _wrap(ix, w, texture.extension)]
    else:
        x, y = x - 0.5, y - 0.5
        x0, y0 = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
        fx, fy = (x - x0)[:, None].astype(np.float32), (y - y0)[:, None].astype(np.float32)
        xs = [_wrap(x0 + i, w, texture.extension) for i in (0, 1)]
        ys = [_wrap(y0 + i, h, texture.extension) for i in (0, 1)]
        pixels = texture.pixels if texture.encoded is None else texture.encoded
        low = pixels[ys[0], xs[0]] * (1 - fx) + pixels[ys[0], xs[1]] * fx
        high = pixels[ys[1], xs[0]] * (1 - fx) + pixels[ys[1], xs[1]] * fx
        color = low * (1 - fy) + high * fy
        if texture.encoded is not None:
            color = srgb_to_linear(color / 255)
    if texture.extension == "CLIP":
        color = np.where(np.all((uv >= 0) & (uv <= 1), -1, keepdims=True), color, 0)
    return color.astype(np.float32)
