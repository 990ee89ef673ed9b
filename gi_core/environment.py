# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Radiance of what lies beyond the scene."""

import numpy as np

from .scene import Environment
from .texture import sample


def is_black(environment: Environment) -> bool:
    """Whether the environment sends no light at all."""
    texture = environment.texture
    return not np.any(environment.color) or (texture is not None and not np.any(texture.pixels))


def radiance(environment: Environment, direction: np.ndarray) -> np.ndarray:
    """Radiance seen along unit directions: (n, 3) -> (n, 3) float32 [W/(m²·sr)].

    Equirectangular as Blender has it: u = ½ − atan2(y, x)/2π, v = ½ + asin(z)/π.
    """
    out = np.broadcast_to(np.asarray(environment.color, np.float32), direction.shape)
    if environment.texture is None:
        return out
    x, y, z = (direction @ environment.rotation.T).T
    uv = np.stack([0.5 - np.arctan2(y, x) / (2 * np.pi), 0.5 + np.arctan2(z, np.hypot(x, y)) / np.pi], -1)
    return out * sample(environment.texture, uv)
