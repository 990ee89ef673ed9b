# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The hierarchical wave front: light travels in straight lines, over coarser cells the further it has come.

From neighbour to neighbour two bands forget within a few cells where light was going, and what was a lobe becomes a
cloud. Here a cell's light goes straight to every cell within `reach` cells, by Lambert's law and the inverse square;
what goes further starts from the cells of a grid twice as coarse, which hold the sum of all in them. Flux is kept, and
a cell is as small as its light is near. It is the tree of Barnes & Hut (1986), with shadow rays.

Each cascade so holds all light by itself, near and far, and only in those of its cells that are looked at.
"""

from collections.abc import Iterator

import numpy as np

from .. import tiles
from ..device import NUMPY, Device
from ..kernels.lpv_arriving import BANDS, SEAM, arriving, asked, received, transfers
from ..kernels.lpv_transfer import sharpened
from ..sampling import morton
from ..trace import Tracer
from ..vectors import dot
from ..vpls import Vpls
from .grid import Grid, levels
from .injection import Sources, sources
from .settings import LpvSettings
from .volume import Level

# Pairs of cells worked on at once by a thread.
_PAIRS = 1 << 15

# Wanted cells worked on at once by a thread, and how many neighbours of those are near to a source or far together.
_CELLS, _BLOCK = 2048, 64


def propagated(
    tracer: Tracer, vpls: Vpls, grids: list[Grid], wanted: list[np.ndarray], settings: LpvSettings
) -> Iterator[float]:
    """The light of virtual lights in the cells of cascades that are wanted. A generator; returns a list of Levels.

    wanted: for each grid, places in C order of the cells that will be looked at; the others stay black.
    """
    every = levels(grids, settings.cascade_ratio)
    radius = [settings.reach * g.cell for g in every[:-1]] + [np.inf]
    literal = settings.injection == "literal"
    lights = []
    for k, grid in enumerate(every):
        # Cells at a cascade's border are lit from beyond it.
        margin = settings.reach * (1 + SEAM) + 1 if k < len(grids) else 0
        lights.append(sources(vpls, grid, settings.injection_bias, literal, margin))
    casting = tracer if settings.visibility else None
    # Embree's rays need the processor's threads.
    device = NUMPY if tracer is None or (casting and not tracer.on_card) else tracer.device
    found = []
    for k, grid in enumerate(grids):
        out = np.zeros((len(wanted[k]), BANDS**2, 3), np.float32)
        for j in range(k, len(every)):
            inner = radius[j - 1] if j > k else 0
            yield from _arriving(casting, device, lights[j], grid, wanted[k], inner, radius[j], out)
        irradiance = np.zeros((grid.size, BANDS**2, 3), np.float32)
        irradiance[wanted[k]] = out
        found.append(Level(grid, irradiance))
    return found


def _within(centre: np.ndarray, low: np.ndarray, high: np.ndarray, inner: float, outer: float) -> np.ndarray:
    """Whether any point of a box may lie between two distances from a centre, in their window: (..., 3) each -> (...)
    bool."""
    near = np.maximum(np.maximum(low - centre, centre - high), 0)
    far = np.maximum(high - centre, centre - low)
    return (dot(near, near) <= (outer * (1 + SEAM)) ** 2) & (dot(far, far) >= (inner * (1 - SEAM)) ** 2)


def _pairs(centre: np.ndarray, middles: np.ndarray, inner: float, outer: float) -> Iterator:
    """Sources and cells between which light may go, (p,) and (p,), _PAIRS at a time at the most.

    centre, middles: (n, 3), (m, 3) where they are; neighbouring cells in blocks of _BLOCK [m].
    """
    first = np.arange(0, len(middles), _BLOCK)
    low, high = np.minimum.reduceat(middles, first), np.maximum.reduceat(middles, first)
    rows = np.flatnonzero(_within(centre, low.min(0), high.max(0), inner, outer))
    source, block = [], []
    for part in tiles.slices(len(rows), _PAIRS // len(first)):
        r, b = np.nonzero(_within(centre[rows[part], None], low, high, inner, outer))
        source.append(rows[part][r])
        block.append(b)
    if source:
        source, block = np.concatenate(source), np.concatenate(block)
    for part in tiles.slices(len(source), _PAIRS // _BLOCK):
        place = (block[part, None] * _BLOCK + np.arange(_BLOCK)).ravel()
        there = np.flatnonzero(place < len(middles))
        yield source[part][there // _BLOCK], place[there]


def _seen(tracer: Tracer, starts, row, middles, place, share) -> np.ndarray:
    """Share of what sources send to cells that comes through: (p,) float32. As for `lpv_arriving`."""
    seen = np.zeros(len(row), np.float32)
    for k, pair, counts in asked(row, place, share, starts.shape[1]):
        seen[pair] += counts * tracer.between(starts[row[pair], k], middles[place[pair]])
    return seen


def _arriving(tracer, device: Device, lights: Sources, grid: Grid, wanted, inner: float, outer: float, out):
    """Adds what comes to the wanted cells from sources between two distances [m] to out, (n, 9, 3) float32 coefficients
    of irradiance [W/m²]. A generator of progress."""
    if not len(lights) or not len(wanted):
        return
    vector, rest = sharpened(lights.coefficients)
    # What each sends straight ahead.
    ahead = np.maximum((np.sqrt(np.einsum("nac,nac->nc", vector, vector)) + rest).mean(-1), np.float32(1e-30))
    sent = lights.centre, vector, rest, ahead
    cells = np.stack(np.unravel_index(wanted, grid.shape), -1)
    order = np.argsort(morton(cells), kind="stable")
    every = grid.centres(cells[order])
    if device is not NUMPY:
        bvh = tracer.on_card.bvh if tracer else None
        rest_ = lights.starts, inner, outer, grid.cell, bvh
        found = yield from device.each(lambda _: device.run(arriving, every, *sent, *rest_), len(every), len(every))
        out[order] += device.numpy(found)
        return

    def tile(part: slice):
        middles, found = every[part], np.zeros((part.stop - part.start, *out.shape[1:]), np.float32)
        for pairs in _pairs(lights.centre, middles, inner, outer):
            row, place, direction, arrives, share = transfers(middles, *sent, *pairs, inner, outer, grid.cell)
            if tracer is not None:
                arrives *= _seen(tracer, lights.starts, row, middles, place, share)[:, None]
            found += received(place, direction, arrives, len(found))
        out[order[part]] += found

    yield from tiles.run(tile, tiles.slices(len(wanted), _CELLS))
