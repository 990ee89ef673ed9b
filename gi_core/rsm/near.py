# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflected light from the near field, which the clamp on virtual lights leaves to short rays."""

from collections.abc import Iterator

import numpy as np

from .. import tiles
from ..direct import EMITTERS, from_lamps, from_surroundings
from ..emitters import emitters
from ..gathering import gathered, strided
from ..near import NearField, short_rays, summed
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls

# Samples of soft lamps, of the surroundings and of light of earlier bounces where a short ray ends.
_SAMPLES = 2

_PAIRS = 1 << 15


def near_light(tracer: Tracer, surfels: Surfels, field: NearField, before: Vpls, seed: int) -> Iterator[float]:
    """Irradiance from surfaces in the near field. A generator of progress; returns (n, 3) float32 [W/m²].

    before: lights of all bounces but the last, which light the surfaces that the short rays meet.
    """
    irradiance = np.zeros((len(surfels), 3), np.float32)
    glow = emitters(tracer.geometry, EMITTERS)

    def tile(part: slice):
        here = surfels[part]
        row, met, share = short_rays(tracer, here, field, seed)
        arriving = from_lamps(tracer, met, _SAMPLES, seed) + from_surroundings(tracer, met, glow, _SAMPLES, seed)
        if len(before):
            arriving += gathered(tracer, met, before, strided(before, _SAMPLES, seed))
        # π times the radiance that a diffuse surface sends is albedo times what arrives there.
        irradiance[part] = summed(row, met.albedo * arriving * share[:, None], len(here)) / field.rays

    yield from tiles.run(tile, tiles.slices(len(surfels), _PAIRS // field.rays))
    return irradiance
