# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rays through the real scene: what they meet sends on its direct light, and further bounces by further rays."""

from collections.abc import Callable

import numpy as np

from ..direct import from_lamps, from_surroundings
from ..sampling import Samples, cosine_hemisphere, hash01
from ..surfels import Surfels, along_rays
from ..trace import FAR, Tracer
from ..vectors import dot

# Samples of each lamp where a ray ends, and of emitting surfaces and the sky: rays are many, so few do.
_LAMP_SAMPLES, _SAMPLES = 1, Samples(2)

# Light that a path's last point gets besides direct light: points and a seed to (n, 3) irradiance [W/m²].
Last = Callable[[Surfels, int], np.ndarray]


def paths(tracer: Tracer, rays, bounces: int, seed: int, far: float = FAR, last: Last | None = None):
    """Reflected light that rays meet: its radiance after 1, 2, … bounces.

    rays: origins (n, 3), unit directions (n, 3) and places (n,), a different one for each ray that is to draw samples
        of its own. far: how far rays go [m].
    Returns (n, bounces, 3) float32, of which each includes those before.
    """
    origin, direction, place = rays
    arrived = np.zeros((len(origin), bounces, 3), np.float32)
    row, sent = np.arange(len(origin)), np.full((len(origin), 3), 1 / np.pi, np.float32)
    for k in range(bounces):
        met, hit = along_rays(tracer, origin, direction, place, far, reflecting=True)
        row, sent = row[hit], sent[hit] * met.albedo
        if not len(met):
            break
        here = seed * 32 + k
        light = from_lamps(tracer, met, _LAMP_SAMPLES, here) + from_surroundings(tracer, met, _SAMPLES, here)
        arrived[row, k:] += (sent * light)[:, None]
        if k == bounces - 1:
            if last is not None:
                arrived[row, k] += sent * last(met, here)
            break
        direction = onward(met, here)
        front = np.flatnonzero(dot(direction, met.face) > 0)
        met, direction, row, sent = met[front], direction[front], row[front], sent[front]
        sent = sent * np.reshape(met.shadowing(slice(None), direction), (-1, 1))
        origin, place = met.origin, met.place
    return arrived


def onward(here: Surfels, seed: int) -> np.ndarray:
    """A cosine-distributed direction from each point: (n, 3) float32."""
    return cosine_hemisphere(here.normal, np.stack([hash01(here.place, 8 * seed + k) for k in (0, 1)], -1))
