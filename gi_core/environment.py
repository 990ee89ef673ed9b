# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What lies beyond the scene: its radiance, and directions drawn by where its light comes from."""

from dataclasses import dataclass

import numpy as np

from .scene import Environment, Texture
from .texture import sample


def is_black(environment: Environment) -> bool:
    """Whether the environment sends no light at all."""
    texture = environment.texture
    return not np.any(environment.color) or (texture is not None and not np.any(texture.pixels))


def radiance(environment: Environment, direction: np.ndarray) -> np.ndarray:
    """Radiance seen along unit directions: (n, 3) -> (n, 3) float32 [W/(m²·sr)]."""
    out = np.broadcast_to(np.asarray(environment.color, np.float32), direction.shape)
    if environment.texture is None:
        return out
    return out * sample(environment.texture, _uv(environment, direction))


def _uv(environment: Environment, direction: np.ndarray) -> np.ndarray:
    """Equirectangular as Blender has it, u = ½ − atan2(y, x)/2π, v = ½ + asin(z)/π: (n, 3) -> (n, 2)."""
    x, y, z = (direction @ environment.rotation.T).T
    return np.stack([0.5 - np.arctan2(y, x) / (2 * np.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi], -1)


@dataclass(frozen=True)
class Sky:
    """The part of an environment's light between two levels of brightness, and the distribution of that light.

    share: of rays that should go where the light comes from, by `sample`; the rest may go anywhere.
    between: lowest and highest brightness (mean of the channels): what a direction has above the lowest, cut at the
        highest.
    density: (h, w, 1) relative density of directions over the texture, looked up as the texture is; its mean is 1.
    cumulative: (h · w + 1,) float64, share of all light from the pixels before each, row by row from below.
    """

    environment: Environment
    share: float = 0.0
    between: tuple[float, float] = (0.0, np.inf)
    density: Texture | None = None
    cumulative: np.ndarray | None = None

    def radiance(self, direction: np.ndarray) -> np.ndarray:
        """Radiance seen along unit directions: (n, 3) -> (n, 3) float32 [W/(m²·sr)]."""
        whole = radiance(self.environment, direction)
        if self.between == (0.0, np.inf):
            return whole
        brightness = whole.mean(-1, keepdims=True)
        part = np.clip(brightness, *self.between) - self.between[0]
        return whole * np.divide(part, brightness, out=np.zeros_like(part), where=brightness > 0)

    def sample(self, u: np.ndarray) -> np.ndarray:
        """Unit directions towards the light, where the share is not zero: (n, 2) in [0, 1)² -> (n, 3) float32."""
        h, w = self.density.pixels.shape[:2]
        u = u.astype(np.float64)
        rows = self.cumulative[::w]
        row = np.searchsorted(rows, u[:, 1], "right") - 1
        share = rows[row + 1] - rows[row]
        along = rows[row] + u[:, 0] * share
        # Rounding must not leave the row.
        pixel = np.clip(np.searchsorted(self.cumulative, along, "right") - 1, row * w, row * w + w - 1)
        width = np.maximum(self.cumulative[pixel + 1] - self.cumulative[pixel], 1e-300)
        inside = np.stack([np.clip((along - self.cumulative[pixel]) / width, 0, 1), (u[:, 1] - rows[row]) / share], -1)
        if self.density.interpolation == "LINEAR":
            # A pixel's light is spread as a tent over its neighbours' halves: drawn like that it is met exactly.
            inside = np.where(inside < 0.5, np.sqrt(2 * inside) - 0.5, 1.5 - np.sqrt(2 - 2 * inside))
        x, y = ((np.stack([pixel % w, row], -1) + inside) / (w, h)).T
        # As the look-up has it, what goes out over a pole comes in at the other.
        angle, z = 2 * np.pi * (0.5 - x), np.sin(np.pi * (y % 1 - 0.5))
        across = np.sqrt(np.maximum(1 - z * z, 0))
        direction = np.stack([across * np.cos(angle), across * np.sin(angle), z], -1)
        return (direction @ self.environment.rotation).astype(np.float32)

    def pdf(self, direction: np.ndarray) -> np.ndarray:
        """Density with which `sample` draws directions: (n, 3) -> (n,) float64 [1/sr]."""
        uv = _uv(self.environment, direction)
        # The whole image is 2π wide and π high, and narrows with the cosine of the latitude.
        area = 2 * np.pi**2 * np.maximum(np.sin(np.pi * uv[:, 1]), 1e-9)
        return sample(self.density, uv)[:, 0] / area


# Brightness over the mean from which on light of a sky is that of a sun in it.
_SUN = 10.0


def parted(environment: Environment) -> tuple[Sky, Sky | None]:
    """The environment's light in two parts that add up to it: the sky, and suns in it where there are some.

    The sky's light is smooth. Suns light as lamps do, with shadows that want no filter, and all rays should go there.
    """
    texture = environment.texture
    if texture is None:
        return Sky(environment), None
    h = len(texture.pixels)
    brightness = texture.pixels @ (np.asarray(environment.color, np.float32) / 3)
    narrowing = np.cos(np.pi * ((np.arange(h) + 0.5) / h - 0.5)).astype(np.float32)[:, None]
    level = _SUN * float(np.mean(brightness * narrowing) / np.mean(narrowing))

    def part(share: float, low: float, high: float) -> Sky | None:
        light = (np.clip(brightness, low, high) - low) * narrowing
        cumulative = np.concatenate([[0.0], np.cumsum(light, dtype=np.float64)])
        if not 0 < cumulative[-1] < np.inf:
            return None
        pixels = (light * (light.size / cumulative[-1])).astype(np.float32)[..., None]
        density = Texture(texture.name, pixels, "REPEAT", texture.interpolation)
        return Sky(environment, share, (low, high), density, cumulative / cumulative[-1])

    return part(0.5, 0.0, level) or Sky(environment), part(1.0, level, np.inf)
