# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lights matter to the points that want light.

A sun lights roofs and outer walls that nobody in the room sees; drawn by flux alone, most samples would go there.
Following Georgiev & Slusallek 2010 ("Simple and Robust Iterative Importance Sampling of Virtual Point Lights"), what a
light brings to a few receivers, shadows included, decides how often it is drawn; a share of all draws goes by flux
alone, so that no light is left out and the estimate stays unbiased.
"""

from collections.abc import Iterator

import numpy as np

from .. import tiles
from ..kernels.vpl_transfer import transfer
from ..sampling import hash01
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls

# Neighbouring lights share one estimate from this many pairs of a light and a receiver.
_GROUPS, _PAIRS = 8192, 64

# Share of the draws that go by flux alone: no light is drawn less than half as often as without the estimate.
_DEFENSE = 0.5


def draw_weight(tracer: Tracer, vpls: Vpls, receivers: Surfels, seed: int, visibility: bool = True) -> Iterator[float]:
    """How often each light should be drawn: flux times what its group brings to receivers per flux.

    vpls: in coherent order. A generator of progress; returns (n,) float64.
    """
    n, flux = len(vpls), vpls.flux.mean(-1).astype(np.float64)
    if not n or not len(receivers):
        return flux
    groups = min(_GROUPS, n)
    brought = np.zeros(groups)
    # Nearer than a few hundredths of the receivers' extent, distance no longer counts: single close pairs would decide.
    near = np.float32(np.pi * (0.02 * np.linalg.norm(np.ptp(receivers.position, 0))) ** 2)

    def tile(part: slice):
        pair = np.arange(part.start * _PAIRS, part.stop * _PAIRS)
        light = ((pair + hash01(pair, seed)) * (n / (groups * _PAIRS))).astype(np.int64)
        light = np.minimum(light, n - 1)
        here = receivers[(hash01(pair, seed + 1) * len(receivers)).astype(np.int64)]
        there = vpls[light]
        arrives = transfer(here.position, here.normal, there.position, there.normal, near)
        if visibility:
            row = np.flatnonzero(arrives)
            arrives[row] *= tracer.connected(here.origin[row], there.origin[row])
        arrives, sent = (arrives * flux[light]).reshape(-1, _PAIRS), flux[light].reshape(-1, _PAIRS)
        brought[part] = arrives.sum(-1) / np.maximum(sent.sum(-1), 1e-30)

    yield from tiles.run(tile, tiles.slices(groups, 256))
    group = np.minimum(np.arange(n) * groups // n, groups - 1)
    mean = np.sum(flux * brought[group]) / np.sum(flux)
    return flux * ((1 - _DEFENSE) * brought[group] + _DEFENSE * mean) if mean > 0 else flux
