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

from .. import sh, tiles
from ..kernels.lpv_inject import summed
from ..kernels.lpv_transfer import beam, sharpened
from ..trace import Tracer
from ..vectors import dot, lit
from ..vpls import Vpls
from .grid import Grid, levels
from .injection import STARTS, Sources, sources
from .settings import LpvSettings
from .volume import Level

BANDS = 3

# Pairs of cells worked on at once by a thread.
_PAIRS = 1 << 15

# Steps from a source that are listed; beyond, all cells are looked at.
_STEPS = 32

# Share of a radius over which light goes from one grid to the next.
_SEAM = 0.25


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
        margin = settings.reach * (1 + _SEAM) + 1 if k < len(grids) else 0
        lights.append(sources(vpls, grid, settings.injection_bias, literal, margin))
    casting = tracer if settings.visibility else None
    found = []
    for k, grid in enumerate(grids):
        out = np.zeros((len(wanted[k]), BANDS**2, 3), np.float32)
        for j in range(k, len(every)):
            yield from _arriving(casting, lights[j], grid, wanted[k], radius[j - 1] if j > k else 0, radius[j], out)
        irradiance = np.zeros((grid.size, BANDS**2, 3), np.float32)
        irradiance[wanted[k]] = out
        found.append(Level(grid, irradiance))
    return found


def _window(r: np.ndarray, inner: float, outer: float) -> np.ndarray:
    """1 between two distances, 0 beyond, 1 in sum over all pairs of neighbouring distances: (p,) -> (p,) float32."""

    def beyond(limit):
        if limit in (0, np.inf):
            return np.float32(limit == 0)
        t = np.clip((r / np.float32(limit) - (1 - _SEAM)) / (2 * _SEAM), 0, 1)
        return t * t * (3 - 2 * t)

    return beyond(inner) - beyond(outer)


def _offsets(inner: float, outer: float, n: int) -> np.ndarray:
    """Steps, none longer than n along an axis, from the cell of a source to all whose middles lie between two distances
    from it [cells]: (m, 3)."""
    step = np.stack(np.meshgrid(*[np.arange(-n, n + 1)] * 3, indexing="ij"), -1).reshape(-1, 3)
    r = np.sqrt((step * step).sum(-1))
    # A source may lie anywhere in its cell: half the diagonal from the middle.
    return step[(r <= outer * (1 + _SEAM) + 0.87) & (r >= inner * (1 - _SEAM) - 0.87)]


def _arriving(tracer, lights: Sources, grid: Grid, wanted, inner: float, outer: float, out) -> Iterator[float]:
    """Adds what comes to the wanted cells from sources between two distances [m] to out, (n, 9, 3) float32 coefficients
    of irradiance [W/m²]. A generator of progress."""
    if not len(lights) or not len(wanted):
        return
    vector, rest = sharpened(lights.coefficients)
    cells = np.stack(np.unravel_index(wanted, grid.shape), -1).astype(np.int32)
    middles = grid.centres(cells)
    base = np.floor(grid.local(lights.centre)).astype(np.int32)
    offsets, n = None, int(np.ceil(outer / grid.cell * (1 + _SEAM) + 1)) if outer < np.inf else _STEPS + 1
    if n <= _STEPS:
        offsets = _offsets(inner / grid.cell, outer / grid.cell, n)
        # Which row a cell has, with room for steps that leave the grid: no step has to be looked at for that.
        room = Grid(grid.low - 2 * n * grid.cell, grid.cell, tuple(m + 4 * n for m in grid.shape))
        slot = np.full(room.size, -1, np.int32)
        slot[room.flat(cells + 2 * n)] = np.arange(len(wanted))
        base, offsets = base + 2 * n, room.flat(offsets).astype(np.int32)

    def pairs(part: slice, rows: np.ndarray):
        """Sources and wanted cells of a part between which light may go: (p,), (p,)."""
        if offsets is None:
            return np.repeat(rows, part.stop - part.start), np.tile(np.arange(part.start, part.stop), len(rows))
        place = slot[(room.flat(base[rows])[:, None] + offsets).ravel()]
        own = np.flatnonzero((place >= part.start) & (place < part.stop))
        return rows[own // len(offsets)], place[own]

    def tile(part: slice):
        rows = np.arange(len(lights))
        if offsets is not None:
            low, high = cells[part].min(0) + n, cells[part].max(0) + 3 * n
            rows = np.flatnonzero(np.all((base >= low) & (base <= high), -1))
        columns = part.stop - part.start if offsets is None else len(offsets)
        for chunk in tiles.slices(len(rows), _PAIRS // columns):
            row, place = pairs(part, rows[chunk])
            d = middles[place] - lights.centre[row]
            r2 = dot(d, d)
            window = _window(np.sqrt(r2), inner, outer)
            near = np.flatnonzero(window)
            row, place, r2, window = row[near], place[near], r2[near], window[near]
            direction = d[near] / np.sqrt(np.maximum(r2, 1e-20))[:, None]
            arrives = beam(vector, rest, row, direction, r2, grid.cell) * window[:, None]
            live = np.flatnonzero(lit(arrives))
            row, arrives, direction, place = row[live], arrives[live], direction[live], place[live]
            if tracer is not None:
                seen = sum(tracer.connected(lights.starts[row, k], middles[place]) for k in range(STARTS))
                arrives *= (seen * np.float32(1 / STARTS))[:, None]
            lobe = sh.cosine_lobe(-direction, BANDS)
            out[part] += summed(place - part.start, lobe[:, :, None] * arrives[:, None, :], part.stop - part.start)

    yield from tiles.run(tile, tiles.slices(len(wanted), 2048))
