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
from ..sampling import hash01, r2_sequence, systematic
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls, coherent, equalized
from .maps import Map, trace_flux
from .views import Rays, rays

# Neighbouring lights share one estimate from this many pairs of a light and a receiver.
_GROUPS, _PAIRS = 4096, 32

# Share of the draws that go by flux alone: no light is drawn less than half as often as without the estimate.
_DEFENSE = 0.5

# Share of a map's rays that go evenly over it.
_EXPLORE = 0.1


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


# Texels along the side of a cell, the unit in which a map's rays are handed out anew.
_CELL = 4


def chosen(
    tracer: Tracer, maps: list[Map], others: list[Vpls], receivers: Surfels, n: int, seed: int, visibility: bool
) -> Iterator[float]:
    """About n lights, in coherent order, that matter to the receivers and stand for all.

    maps: are drawn anew, with most rays where they matter: a sunlit strip that has forty texels in the map of a whole
    building gets thousands. others: lights without a map, of which a part is taken.
    A generator of progress; returns the Vpls.
    """
    parts = [m.lights() for m in maps] + others
    every = Vpls.concatenate(parts)
    order = coherent(every)
    weight = np.zeros(len(every))
    weight[order] = yield from draw_weight(tracer, every[order], receivers, seed, visibility)
    if not np.any(weight):
        return Vpls.concatenate([])

    ends = np.cumsum([len(p) for p in parts])
    mapped = ends[len(maps) - 1] if maps else 0
    lights = []
    if np.any(weight[:mapped]):
        count = round(n * weight[:mapped].sum() / weight.sum())
        of_maps = np.split(weight[:mapped], ends[: len(maps) - 1])
        lights.append((yield from _redrawn(tracer, maps, of_maps, max(1, count), seed)))
    if np.any(weight[mapped:]):
        order = order[order >= mapped]
        count = round(n * weight[mapped:].sum() / weight.sum())
        lights.append(equalized(every[order], weight[order], max(1, count)))
    cloud = Vpls.concatenate(lights)
    return cloud[coherent(cloud)]


def _redrawn(tracer: Tracer, maps: list[Map], weights: list[np.ndarray], n: int, seed: int) -> Iterator[float]:
    """n rays through cells of maps in proportion to their texels' weights. A generator; returns the Vpls."""
    cells = []
    for source, weight in zip(maps, weights):
        side = source.view.resolution
        blocks = -(-side // _CELL)
        row, column = np.divmod(source.surfels.place, side)
        cell = row // _CELL * blocks + column // _CELL
        cells.append(np.bincount(cell, weight, blocks * blocks))
    weight = np.concatenate(cells)
    # What the map's few texels have missed may be lit all the same: a part goes to the whole map, evenly.
    lit_cells = np.concatenate([np.full(len(c), c.sum() / len(c)) for c in cells])
    weight = (1 - _EXPLORE) * weight + _EXPLORE * lit_cells
    drawn = systematic(weight, n)
    expected = n * weight / weight.sum()

    drawn_rays, begin = [], 0
    for k, (source, of_map) in enumerate(zip(maps, cells)):
        here = drawn[(drawn >= begin) & (drawn < begin + len(of_map))] - begin
        if len(here):
            side = source.view.resolution
            blocks = -(-side // _CELL)
            low = np.stack([here % blocks, here // blocks], -1) * _CELL
            size = np.minimum(_CELL, side - low)
            # Within a cell one low-discrepancy sequence, from a start of the cell's own.
            rank = np.arange(len(here)) - np.searchsorted(here, here)
            start = np.stack([hash01(here, seed * 4 + 2 * k + i) for i in (0, 1)], -1)
            u = (r2_sequence(int(rank.max()) + 1)[rank] + start) % 1
            lens = np.stack([hash01(np.arange(len(here)), seed * 4 + 2 * k + i + 1024) for i in (0, 1)], -1)
            share = np.prod(size, -1) / side**2 / expected[begin + here]
            flux_rays = rays(source.view, (low + u * size) / side, lens, share)
            drawn_rays.append(flux_rays)
        begin += len(of_map)
    return (yield from trace_flux(tracer, Rays.concatenate(drawn_rays), from_lamps=True)).lights()
