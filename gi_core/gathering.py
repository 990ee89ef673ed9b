# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gathering: irradiance at surfels from virtual point lights, with shadow rays between them."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from . import tiles
from .kernels.vpl_transfer import transfer
from .sampling import Samples, hash01
from .surfels import Surfels
from .trace import Tracer
from .vectors import dot
from .vpls import Vpls

# Pairs of surfel and light worked on at once by a thread: arrays that stay within a core's cache and some 50 MB of
# memory.
_PAIRS = 1 << 16

# For the surfels of a tile: which lights (n, s), and by what factor (n, s) or a scalar each counts.
Pattern = Callable[[Surfels], tuple[np.ndarray, np.ndarray | float]]


@dataclass(frozen=True)
class Bound:
    """What keeps lights that are very near from being infinitely bright.

    kind: how, see `vpl_transfer`. area: by which area [m²]; None for what each light stands for.
    """

    kind: str = "disc"
    area: float | None = None


def gathered(
    tracer: Tracer, here: Surfels, vpls: Vpls, pattern: Pattern, visibility: bool = True, bound: Bound = Bound()
) -> np.ndarray:
    """Irradiance that the pattern's lights send to each surfel, all pairs at once: (n, 3) float32 [W/m²]."""
    index, factor = pattern(here)
    area = vpls.area[index] if bound.area is None else np.float32(bound.area)
    there = vpls.position[index], vpls.normal[index]
    pairs = transfer(here.position[:, None], here.normal[:, None], *there, area, bound.kind)
    pairs = np.where(index >= 0, pairs * factor, 0).astype(np.float32)
    if visibility:
        row, column = np.nonzero(pairs)
        origin, target = here.origin[row], vpls.origin[index[row, column]]
        # A surface's back is dark, whatever its shading normal says.
        seen = dot(target - origin, here.face[row]) > 0
        seen[seen] = tracer.connected(origin[seen], target[seen])
        pairs[row[~seen], column[~seen]] = 0
    return np.einsum("ns,nsc->nc", pairs, vpls.flux[index])


def gather(
    tracer: Tracer,
    surfels: Surfels,
    vpls: Vpls,
    pattern: Pattern,
    samples: int,
    visibility: bool = True,
    bound: Bound = Bound(),
) -> Iterator[float]:
    """The same for any number of surfels, tile by tile. A generator of progress; returns (n, 3) float32 [W/m²].

    samples: how many lights the pattern picks, which sets the tile's size.
    """
    irradiance = np.zeros((len(surfels), 3), np.float32)
    if not len(vpls) or not len(surfels):
        return irradiance

    def tile(part: slice):
        irradiance[part] = gathered(tracer, surfels[part], vpls, pattern, visibility, bound)

    yield from tiles.run(tile, tiles.slices(len(surfels), _PAIRS // samples))
    return irradiance


def every(vpls: Vpls) -> Pattern:
    """The reference: each point gathers from all lights."""
    index = np.arange(len(vpls))
    return lambda here: (np.broadcast_to(index, (len(here), len(vpls))), 1.0)


def strided(vpls: Vpls, samples: Samples, seed: int) -> Pattern:
    """Each point takes every k-th light from a start of its own; for lights of equal brightness (`vpls.equalized`)."""
    step = len(vpls) / samples.count

    def pattern(here: Surfels):
        start = (hash01(here.place, seed)[:, None] + np.float32(samples.shift())) % 1
        index = ((np.arange(samples.count) + start) * step).astype(np.int64)
        return np.minimum(index, len(vpls) - 1), step

    return pattern
