# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The geometry volume: how much surface stands between a cell and the next, and of which colour.

The paper injects what lamps and camera happen to see and keeps a lobe for each cell. Here all triangles go in, from
both sides, and a cell keeps the area of its surfaces as seen along each axis, which is what light between neighbours
meets: two faces of a thin wall add up, where opposite lobes would cancel. Cells are staggered by half a cell, so that a
wall between cells' middles lies in the middle of them.
"""

from dataclasses import dataclass

import numpy as np

from ..device import NUMPY, Device
from ..emitters import strewn
from ..geometry import Geometry
from ..kernels.lpv_inject import summed
from .grid import Grid

# Points on surfaces for each square of a cell's side, and at the most.
_DENSITY, _MOST = 6, 1 << 20


@dataclass(frozen=True)
class Blockers:
    """Points that stand for all surfaces, evenly.

    position, normal, albedo: (n, 3) float32 [m], unit, 0…1. area: (n,) float32 [m²].
    """

    position: np.ndarray
    normal: np.ndarray
    albedo: np.ndarray
    area: np.ndarray


def blockers(geometry: Geometry, cell: float) -> Blockers:
    """Points close enough for cells of a side [m]."""
    if not geometry.area > 0:
        empty = np.zeros((0, 3), np.float32)
        return Blockers(empty, empty, empty, empty[:, 0])
    n = int(np.clip(_DENSITY * geometry.area / cell**2, 1024, _MOST))
    triangle, weights, share = strewn(geometry, np.ones(len(geometry.triangles)), n)
    return Blockers(
        geometry.position(triangle, weights), geometry.face_normal(triangle),
        geometry.color("albedo", triangle, weights), share * geometry.alpha(triangle, weights),
    )  # fmt: skip


def geometry_volume(surfaces: Blockers, grid: Grid, bias: float = 0.0, amplifier: float = 1.0, device: Device = NUMPY):
    """Shares of light that surfaces stop on its way from each cell to the next along an axis, and the surfaces' albedo.

    bias: cells that surfaces are moved along their normals; amplifier: factor on their area.
    Returns (3, x, y, z) float32 in 0…1 and (3, x, y, z, 3) float32; the last layer along its axis has no next cell.
    """
    shape = tuple(n + 1 for n in grid.shape)
    corners = Grid(grid.low - grid.cell / 2, grid.cell, shape)
    cell = np.floor(corners.local(surfaces.position) + np.float32(bias) * surfaces.normal).astype(np.int32)
    inside = np.flatnonzero(corners.inside(cell))
    part = (surfaces.area[inside] / np.float32(grid.cell**2))[:, None]
    values = np.concatenate([np.abs(surfaces.normal[inside]) * part, surfaces.albedo[inside] * part, part], -1)
    held = device.numpy(device.run(summed, corners.flat(cell[inside]), values, corners.size)).reshape(*shape, 7)
    area = held[..., :3]
    color = held[..., 3:6] / np.maximum(held[..., 6:], 1e-20)
    blocked = [_between(area[..., k], k) for k in range(3)]
    albedo = [_between(color * area[..., k, None], k) / np.maximum(blocked[k], 1e-20)[..., None] for k in range(3)]
    return np.clip(np.stack(blocked) * np.float32(amplifier), 0, 1), np.stack(albedo)


def _between(values: np.ndarray, axis: int) -> np.ndarray:
    """Corners' values in the middles of the faces that cells share with the next along an axis: the mean of four."""
    values = np.moveaxis(values, axis, 0)[1:]
    mean = (values[:, 1:, 1:] + values[:, :-1, 1:] + values[:, 1:, :-1] + values[:, :-1, :-1]) / 4
    return np.moveaxis(mean, 0, axis)
