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
    tracer: Tracer,
    here: Surfels,
    vpls: Vpls,
    pattern: Pattern,
    visibility: bool = True,
    bound: Bound = Bound(),
    candidates: int = 1,
) -> np.ndarray:
    """Irradiance that the pattern's lights send to each surfel, all pairs at once: (n, 3) float32 [W/m²].

    candidates: of so many lights that follow each other in the pattern one gets the shadow ray, see `resampled`.
    """
    index, factor = pattern(here)
    area = vpls.area[index] if bound.area is None else np.float32(bound.area)
    there = vpls.position[index], vpls.normal[index]
    pairs = transfer(here.position[:, None], here.normal[:, None], *there, area, bound.kind)
    pairs = np.where(index >= 0, pairs * factor, 0).astype(np.float32)
    if candidates > 1:
        index, pairs = resampled(index, pairs, vpls, candidates, here.place)
    if visibility:
        row, column = np.nonzero(pairs)
        origin, target = here.origin[row], vpls.origin[index[row, column]]
        # A surface's back is dark, whatever its shading normal says.
        seen = dot(target - origin, here.face[row]) > 0
        seen[seen] = tracer.connected(origin[seen], target[seen])
        pairs[row[~seen], column[~seen]] = 0
    return np.einsum("ns,nsc->nc", pairs, vpls.flux[index])


def resampled(
    index: np.ndarray, pairs: np.ndarray, vpls: Vpls, candidates: int, place: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """One light for every so many candidates, drawn in proportion to what it brings where nothing shades it.

    Resampled importance sampling (Talbot, Cline & Egbert 2005): the survivor stands for the sum of its group, so that
    the mean stays what it is and rays go where light comes from.

    index, pairs: (n, s) lights and their irradiance over flux; place: (n,) seeds the draw. Returns the same of the
    survivors, (n, s / candidates).
    """
    groups = (len(index), index.shape[1] // candidates, candidates)
    index, pairs = index.reshape(groups), pairs.reshape(groups)
    brought = np.cumsum(pairs * vpls.brightness[index], -1)
    total = brought[..., -1]
    u = hash01(place[:, None] * total.shape[1] + np.arange(total.shape[1]), candidates)
    # Never the last one by rounding where it brings nothing.
    survivor = np.argmax(brought > (u * total)[..., None], -1)[..., None]
    index = np.take_along_axis(index, survivor, -1)[..., 0]
    brightness = vpls.brightness[index]
    return index, np.divide(total, brightness, out=np.zeros_like(total), where=brightness > 0)


def gather(
    tracer: Tracer,
    surfels: Surfels,
    vpls: Vpls,
    pattern: Pattern,
    samples: int,
    visibility: bool = True,
    bound: Bound = Bound(),
    candidates: int = 1,
) -> Iterator[float]:
    """The same for any number of surfels, tile by tile. A generator of progress; returns (n, 3) float32 [W/m²].

    samples: how many lights the pattern picks, which sets the tile's size.
    """
    irradiance = np.zeros((len(surfels), 3), np.float32)
    if not len(vpls) or not len(surfels):
        return irradiance

    def tile(part: slice):
        irradiance[part] = gathered(tracer, surfels[part], vpls, pattern, visibility, bound, candidates)

    yield from tiles.run(tile, tiles.slices(len(surfels), _PAIRS // samples))
    return irradiance


def every(vpls: Vpls) -> Pattern:
    """The reference: each point gathers from all lights."""
    index = np.arange(len(vpls))
    return lambda here: (np.broadcast_to(index, (len(here), len(vpls))), 1.0)


def strided(vpls: Vpls, samples: Samples, seed: int, candidates: int = 1) -> Pattern:
    """Each point takes every k-th light from a start of its own; for lights of equal brightness (`vpls.equalized`).

    candidates: lights for each sample.
    """
    step = len(vpls) / (samples.count * candidates)

    def pattern(here: Surfels):
        start = (hash01(here.place, seed)[:, None] + np.float32(samples.shift())) % 1
        index = ((np.arange(samples.count * candidates) + start) * step).astype(np.int64)
        return np.minimum(index, len(vpls) - 1), step

    return pattern
