# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of all sources in the middles of cells, in straight lines, with shadow rays.

On a processor `lpv.hierarchy` finds the pairs between which light may go and lets Embree trace; a graphics card has
each cell look at every source.
"""

import numpy as np

from .. import sh
from ..vectors import dot, length
from .lpv_inject import summed
from .lpv_transfer import beam
from .rays import through, trace

BANDS = 3

# Of what a source sends straight ahead: so little is worth one ray, and so little is nothing but rounding.
DIM, NOTHING = 0.05, 1e-5

# Share of a radius over which light goes from one grid to the next.
SEAM = 0.25

# What stands for no radius on a card.
_ENDLESS = 1e30

# Turns that the loops for a source's rays take.
_RAY = 1 << 12

# A ray's end over the distance of the cell, as for `Tracer.connected`.
_SHORT = np.float32(1 - 1e-4)


def window(r: np.ndarray, inner: float, outer: float) -> np.ndarray:
    """1 between two distances, 0 beyond, 1 in sum over all pairs of neighbouring distances: (p,) -> (p,) float32."""

    def beyond(limit):
        if limit in (0, np.inf):
            return np.full(len(r), limit == 0, np.float32)
        t = np.clip((r / np.float32(limit) - (1 - SEAM)) / (2 * SEAM), 0, 1)
        return t * t * (3 - 2 * t)

    return beyond(inner) - beyond(outer)


def transfers(middles, centre, vector, rest, ahead, row, place, inner: float, outer: float, cell: float):
    """What goes from sources to cells, for those pairs for which it is anything.

    As for `arriving`; row, place: (p,) of each pair. Returns row and place of those, (q,), unit directions (q, 3),
    irradiance across the beam (q, 3) [W/m²], its share of what the source sends straight ahead (q,).
    """
    d = middles[place] - centre[row]
    r2 = dot(d, d)
    weight = window(np.sqrt(r2), inner, outer)
    near = np.flatnonzero(weight)
    row, place, r2 = row[near], place[near], r2[near]
    direction = d[near] / np.sqrt(np.maximum(r2, 1e-20))[:, None]
    arrives = beam(vector, rest, row, direction, r2, cell) * weight[near, None]
    share = arrives.mean(-1) * np.maximum(r2, np.float32(cell**2)) / ahead[row]
    live = np.flatnonzero(share > NOTHING)
    return row[live], place[live], direction[live], arrives[live], share[live]


def asked(row: np.ndarray, place: np.ndarray, share: np.ndarray, starts: int):
    """Which of a source's starts rays go from: for each of them the pairs (a,) and how much they count (a,)."""
    turn, bright = (row + place) % starts, share > DIM
    for k in range(starts):
        pair = np.flatnonzero(bright | (turn == k))
        yield k, pair, np.where(bright[pair], np.float32(1 / starts), np.float32(1))


def received(place: np.ndarray, direction: np.ndarray, arrives: np.ndarray, n: int) -> np.ndarray:
    """Light across beams as irradiance over the normal, in n cells: (n, 9, 3) float32 [W/m²]."""
    lobe = sh.cosine_lobe(-direction, BANDS)
    return summed(place, lobe[:, :, None] * arrives[:, None, :], n)


def arriving(middles, centre, vector, rest, ahead, starts, inner: float, outer: float, cell: float, bvh=None):
    """Irradiance over the normal in the middles of cells: (m, 3) [m] -> (m, 9, 3) float32 [W/m²].

    centre: (n, 3) where sources are [m]. vector, rest: of those, see `lpv_transfer.sharpened`. ahead: (n,) what each
    sends straight ahead. starts: (n, k, 3) where its shadow rays begin [m]. inner, outer: the distances between which
    light goes [m]. cell: side of a cell [m]. bvh: what may be between; None for nothing.
    """
    place, row = (index.ravel() for index in np.indices((len(middles), len(centre))))
    row, place, direction, arrives, share = transfers(
        middles, centre, vector, rest, ahead, row, place, inner, outer, cell
    )
    if bvh is not None:
        seen = np.zeros(len(row), np.float32)
        for k, pair, counts in asked(row, place, share, starts.shape[1]):
            start = starts[row[pair], k]
            d = middles[place[pair]] - start
            far = length(d)
            seen[pair] += counts * through(start, d / np.maximum(far, 1e-20)[:, None], far * _SHORT, bvh)
        arrives = arrives * seen[:, None]
    return received(place, direction, arrives, len(middles))


def arriving_on_gpu(gpu, middles, centre, vector, rest, ahead, starts, inner, outer, cell, bvh=None):
    inputs = {
        "middle": (middles, 3), "centre": (centre, 3), "vector": (vector, 3),
        "rest": (np.column_stack([rest, ahead]), 4), "start": (starts, 3),
    }  # fmt: skip
    inputs = {name: (gpu.array(*values), values[1]) for name, values in inputs.items()}
    floats = {"inner": inner, "outer": min(outer, _ENDLESS), "cell": cell}
    defines = {"STARTS": starts.shape[1], "SEEN": int(bvh is not None)}

    def part(first: int, last: int):
        found, span = gpu.empty((len(middles), BANDS**2, 3), 3), {"begin": first, "end": last}
        given = "lpv_arriving", len(middles), inputs, {"found": found}, span, floats, defines
        if bvh is None:
            gpu.dispatch(*given, steps=last - first)
        else:
            trace(gpu, *given, bvh=bvh, is_any=True, rays=last - first)
        return found

    return gpu.added_up(len(centre), 1 if bvh is None else _RAY, part)
