# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How solid triangles are, where they may let light through: what rays need of materials, as plain arrays.

As `Geometry.alpha` has it: a number, times the first channel of a texture.
"""

from collections.abc import Iterator
from dataclasses import dataclass, fields

import numpy as np

from ..geometry import Geometry
from ..scene import ColorSource
from ..texture import sample

# Textures begin at multiples of so many texels: their places, over it, are then exact in single precision.
ROW = 2048

_EXTENSIONS = ("REPEAT", "MIRROR", "EXTEND", "CLIP")


@dataclass(frozen=True)
class Veil:
    """Alphas of triangles.

    first: (t, 4) float32, UVs of the first two corners. second: (t, 4) float32, UV of the third, which of the alphas
        the triangle has, −1 where it is solid, and 0.
    alpha: (2 m, 4) float32; of each the number, where its texels begin over ROW, −1 for none, their width and height,
        then how they go on (0 repeated, 1 mirrored, 2 held, 3 not at all), whether the nearest is taken, whether they
        are encoded as sRGB, and 0.
    texel: (x,) float32.
    """

    first: np.ndarray
    second: np.ndarray
    alpha: np.ndarray
    texel: np.ndarray

    # Of each array, as devices take it.
    CHANNELS = {"first": 4, "second": 4, "alpha": 4, "texel": 1}

    @staticmethod
    def of(geometry: Geometry, triangle: np.ndarray) -> "Veil":
        """For some of a geometry's triangles: (t,)."""
        materials = geometry.scene.materials
        sources = [m.alpha for m in materials]
        material = geometry.material(triangle)
        clear = geometry.clear[triangle]
        first, second = np.zeros((2, len(triangle), 4), np.float32)
        second[:, 2] = np.where(clear, material, -1)
        for m in np.unique(material[clear]):
            here = np.flatnonzero(clear & (material == m))
            corners = [geometry.uv(triangle[here], np.tile(np.eye(3, dtype=np.float32)[k], (len(here), 1)),
                                   sources[m].uv) for k in range(3)]  # fmt: skip
            first[here], second[here, :2] = np.concatenate(corners[:2], -1), corners[2]
        alpha, texel = np.zeros((2 * len(sources), 4), np.float32), list(_texels(sources))
        begin = np.cumsum([0] + [len(t) // ROW for t in texel])
        for m, source in enumerate(sources):
            alpha[2 * m] = source.value[0], -1, 0, 0
            if (t := source.texture) is not None:
                height, width, _ = t.pixels.shape
                alpha[2 * m, 1:] = begin[m], width, height
                encoded = t.encoded is not None and t.interpolation != "CLOSEST"
                alpha[2 * m + 1, :3] = _EXTENSIONS.index(t.extension), t.interpolation == "CLOSEST", encoded
        return Veil(first, second, alpha, np.concatenate([np.zeros(0, np.float32), *texel]))

    def on(self, device) -> "Veil":
        """The same on a device."""
        return Veil(*(device.array(getattr(self, f.name), self.CHANNELS[f.name]) for f in fields(self)))


def _texels(sources: list[ColorSource]) -> Iterator[np.ndarray]:
    """The first channel of each texture, filled up to whole rows; nothing where there is none."""
    for source in sources:
        texels = np.zeros(0, np.float32)
        if (t := source.texture) is not None:
            encoded = t.encoded is not None and t.interpolation != "CLOSEST"
            texels = (t.encoded if encoded else t.pixels)[..., 0].astype(np.float32).ravel()
        yield np.pad(texels, (0, -len(texels) % ROW))


def solid(veil: Veil, k: np.ndarray, u: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Alphas at points of triangles: (n,), and (n,) weights of the second and third corner -> (n,) float32, 0…1."""
    out, which = np.ones(len(k), np.float32), veil.second[k, 2].astype(int)
    for m in np.unique(which[which >= 0]):
        here = np.flatnonzero(which == m)
        out[here], begin, width, height = veil.alpha[2 * m]
        if begin >= 0:
            extension, nearest, encoded = veil.alpha[2 * m + 1, :3].astype(int)
            begin, width, height = int(begin) * ROW, int(width), int(height)
            texels = veil.texel[begin : begin + width * height].reshape(height, width, 1)
            row, b, c = k[here], u[here, None], v[here, None]
            uv = veil.first[row, :2] * (1 - b - c) + veil.first[row, 2:] * b + veil.second[row, :2] * c
            texture = _Plain(
                texels, _EXTENSIONS[extension], "CLOSEST" if nearest else "LINEAR", texels if encoded else None
            )
            out[here] *= sample(texture, uv)[:, 0]
    return np.clip(out, 0, 1)


@dataclass(frozen=True)
class _Plain:
    """What `sample` asks of a texture."""

    pixels: np.ndarray
    extension: str
    interpolation: str
    encoded: np.ndarray | None
