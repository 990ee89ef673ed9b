# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflected light from the near field, which the clamp on virtual lights leaves to short rays."""

from collections.abc import Iterator

import numpy as np

from .. import tiles
from ..direct import from_lamps, from_surroundings
from ..near import NearField, short_rays, summed
from ..sampling import Samples, cosine_hemisphere, hash01
from ..surfels import Surfels, along_rays
from ..trace import Tracer
from ..vectors import dot

# Samples where a short ray ends: of each lamp one, which the rays' own number makes many; of the surroundings more,
# since emitting surfaces near by are noisy.
_LAMP_SAMPLES, _SAMPLES = 1, Samples(2)

_PAIRS = 1 << 15


def near_light(tracer: Tracer, surfels: Surfels, field: NearField, bounces: int, seed: int) -> Iterator[float]:
    """Irradiance from surfaces in the near field. A generator of progress; returns (n, 3) float32 [W/m²].

    bounces: reflections in all, of which the last is the surface that the short ray meets.
    """
    irradiance = np.zeros((len(surfels), 3), np.float32)

    def tile(part: slice):
        here = surfels[part]
        row, met, share = short_rays(tracer, here, field, seed)
        # π times the radiance that a diffuse surface sends is albedo times what arrives there.
        sent = met.albedo * arriving(tracer, met, bounces - 1, seed)
        irradiance[part] = summed(row, sent * share[:, None], len(here)) / field.rays.count

    yield from tiles.run(tile, tiles.slices(len(surfels), _PAIRS // field.rays.count))
    return irradiance


def arriving(tracer: Tracer, here: Surfels, bounces: int, seed: int) -> np.ndarray:
    """Irradiance at points after any number of reflections, by one path from each: (n, 3) float32 [W/m²]."""
    irradiance = from_lamps(tracer, here, _LAMP_SAMPLES, seed) + from_surroundings(tracer, here, _SAMPLES, seed)
    if bounces and len(here):
        u = np.stack([hash01(here.place, seed * 1024 + 8 * bounces + k) for k in (0, 1)], -1)
        direction = cosine_hemisphere(here.normal, u)
        front = np.flatnonzero(dot(direction, here.face) > 0)
        met, hit = along_rays(tracer, here.origin[front], direction[front], here.place[front], reflecting=True)
        sent = met.albedo * arriving(tracer, met, bounces - 1, seed)
        row = front[hit]
        irradiance[row] += sent * np.reshape(here.shadowing(row, direction[row]), (-1, 1))
    return irradiance
