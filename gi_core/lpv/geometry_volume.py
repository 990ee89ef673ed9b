# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The geometry volume: how much surface stands between a cell and the next, and of which colour.

The paper injects what lamps and camera happen to see and keeps a lobe for each cell. Here all triangles go in, from
both sides, and a cell keeps the area of its surfaces as seen along each axis, which is what light between neighbours
meets: two faces of a thin wall add up, where opposite lobes would cancel. Cells are staggered by half a cell, so that a
wall between cells' middles lies in the middle of them.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .. import tiles
from ..device import NUMPY, Device
from ..emitters import strewn
from ..geometry import Geometry
from ..kernels.lpv_inject import summed
from .grid import Grid

# Points on surfaces for each square of a cell's side, and at the most.
_DENSITY, _MOST = 6, 1 << 20

# Points worked on at once by a thread; what stays in a core's cache is several times as fast.
_POINTS = 1 << 15


@dataclass(frozen=True)
class Blockers:
    """Points that stand for all surfaces, evenly.

    position, normal: (n, 3) float32 [m], unit.
    area: (n, 3) float32, of the surface that each stands for as it is seen along each axis; or (n, 7), where surfaces'
        colour is wanted: then also albedo times area, and area [m²].
    """

    position: np.ndarray
    normal: np.ndarray
    area: np.ndarray


def blockers(geometry: Geometry, cell: float, colored: bool = False) -> Iterator[float]:
    """Points close enough for cells of a side [m]. A generator of progress; returns Blockers."""
    if not geometry.area > 0:
        empty = np.zeros((0, 3), np.float32)
        return Blockers(empty, empty, np.zeros((0, 7 if colored else 3), np.float32))
    n = int(np.clip(_DENSITY * geometry.area / cell**2, 1024, _MOST))
    triangle, weights, share = strewn(geometry, np.ones(len(geometry.triangles)), n)
    position, normal = np.empty((2, n, 3), np.float32)
    area = np.empty((n, 7 if colored else 3), np.float32)
    clear = geometry.clear.any()

    def tile(part: slice):
        here, at, solid = triangle[part], weights[part], share[part]
        # Points on one triangle follow one another.
        first = np.flatnonzero(np.diff(here, prepend=-1))
        each = np.diff(first, append=len(here))
        position[part] = geometry.position(here, at)
        normal[part] = np.repeat(geometry.face_normal(here[first]), each, 0)
        if clear:
            solid = solid * geometry.alpha(here, at)
        np.multiply(np.abs(normal[part]), solid[:, None], out=area[part, :3])
        if colored:
            area[part, 3:6] = geometry.color("albedo", here, at) * solid[:, None]
            area[part, 6] = solid

    yield from tiles.run(tile, tiles.slices(n, _POINTS))
    return Blockers(position, normal, area)


def geometry_volume(
    surfaces: Blockers, grid: Grid, bias: float = 0.0, amplifier: float = 1.0, device: Device = NUMPY
) -> Iterator[float]:
    """Shares of light that surfaces stop on its way from each cell to the next along an axis, and the surfaces' albedo.

    bias: cells that surfaces are moved along their normals; amplifier: factor on their area.
    A generator of progress; returns (3, x, y, z) float32 in 0…1 and, of coloured surfaces, (3, x, y, z, 3) float32,
    else None. The last layer along its axis has no next cell.
    """
    shape = tuple(n + 1 for n in grid.shape)
    corners = Grid(grid.low - grid.cell / 2, grid.cell, shape)
    # What lies outside is counted in a place of its own.
    place = np.full(len(surfaces.area), corners.size, np.int32)

    def tile(part: slice):
        local = corners.local(surfaces.position[part])
        if bias:
            local += np.float32(bias) * surfaces.normal[part]
        cell = np.floor(local).astype(np.int32)
        inside = corners.inside(cell)
        place[part][inside] = corners.flat(cell[inside])

    yield from tiles.run(tile, tiles.slices(len(place), _POINTS))
    held = device.numpy(device.run(summed, place, surfaces.area, corners.size + 1))[:-1].reshape(*shape, -1)
    area = held[..., :3] / np.float32(grid.cell**2)
    blocked = [_between(area[..., k], k) for k in range(3)]
    albedo = None
    if held.shape[-1] > 3:
        color = held[..., 3:6] / np.maximum(held[..., 6:], 1e-20)
        albedo = [_between(color * area[..., k, None], k) / np.maximum(blocked[k], 1e-20)[..., None] for k in range(3)]
        albedo = np.stack(albedo)
    return np.clip(np.stack(blocked) * np.float32(amplifier), 0, 1), albedo


def _between(values: np.ndarray, axis: int) -> np.ndarray:
    """Corners' values in the middles of the faces that cells share with the next along an axis: the mean of four."""
    values = np.moveaxis(values, axis, 0)[1:]
    mean = (values[:, 1:, 1:] + values[:, :-1, 1:] + values[:, 1:, :-1] + values[:, :-1, :-1]) / 4
    return np.moveaxis(mean, 0, axis)
