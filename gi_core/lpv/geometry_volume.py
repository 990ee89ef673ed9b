# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The geometry volume: how much surface stands between a cell and the next, and of which colour.

The paper injects what lamps and camera happen to see and keeps a lobe for each cell. Here all triangles go in, from
both sides, and a cell keeps the area of its surfaces as seen along each axis, which is what light between neighbours
meets: two faces of a thin wall add up, where opposite lobes would cancel. Cells are staggered by half a cell, so that a
wall between cells' middles lies in the middle of them.
"""

import numpy as np

from ..emitters import strewn
from ..geometry import Geometry
from ..kernels.lpv_inject import summed
from .grid import Grid

# Points on surfaces for each square of a cell's side, and at the most.
_DENSITY, _MOST = 16, 1 << 20


def geometry_volume(geometry: Geometry, grid: Grid, bias: float = 0.0, amplifier: float = 1.0):
    """Shares of light that surfaces stop on its way from each cell to the next along an axis, and the surfaces' albedo.

    bias: cells that surfaces are moved along their normals; amplifier: factor on their area.
    Returns (3, x, y, z) float32 in 0…1 and (3, x, y, z, 3) float32; the last layer along its axis has no next cell.
    """
    shape = tuple(n + 1 for n in grid.shape)
    corners = Grid(grid.low - grid.cell / 2, grid.cell, shape)
    area = np.zeros((*shape, 3), np.float32)
    color = np.zeros((*shape, 3), np.float32)
    if geometry.area > 0:
        n = int(np.clip(_DENSITY * geometry.area / grid.cell**2, 1024, _MOST))
        triangle, weights, share = strewn(geometry, np.ones(len(geometry.triangles)), n)
        normal = geometry.face_normal(triangle)
        local = corners.local(geometry.position(triangle, weights)) + np.float32(bias) * normal
        cell = np.floor(local).astype(np.int32)
        inside = corners.inside(cell)
        triangle, weights, normal, cell = triangle[inside], weights[inside], normal[inside], cell[inside]
        part = (share[inside] * geometry.alpha(triangle, weights) / np.float32(grid.cell**2))[:, None]
        values = np.concatenate([np.abs(normal) * part, geometry.color("albedo", triangle, weights) * part, part], -1)
        held = summed(corners.flat(cell), values, corners.size)
        area = np.minimum(held[:, :3], 1).reshape(*shape, 3)
        color = (held[:, 3:6] / np.maximum(held[:, 6:], 1e-20)).reshape(*shape, 3)
    blocked = [_between(area[..., k], k) for k in range(3)]
    albedo = [_between(color * area[..., k, None], k) / np.maximum(blocked[k], 1e-20)[..., None] for k in range(3)]
    return np.clip(np.stack(blocked) * np.float32(amplifier), 0, 1), np.stack(albedo)


def _between(values: np.ndarray, axis: int) -> np.ndarray:
    """Corners' values in the middles of the faces that cells share with the next along an axis: the mean of four."""
    values = np.moveaxis(values, axis, 0)[1:]
    mean = (values[:, 1:, 1:] + values[:, :-1, 1:] + values[:, 1:, :-1] + values[:, :-1, :-1]) / 4
    return np.moveaxis(mean, 0, axis)
