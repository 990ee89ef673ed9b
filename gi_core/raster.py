# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Pictures whose rays leave from one place, or side by side, and the pixels in which each triangle may be seen."""

from dataclasses import dataclass

import numpy as np

from .scene import Camera

# How far rays are off by rounding: their direction [1], and their start as a share of where it is.
_ROUNDING = 1e-6


@dataclass(frozen=True)
class Grid:
    """Pixels, a ray through each.

    kind: "PERSPECTIVE" or "ORTHOGRAPHIC".
    origin: (3,) where rays leave from, or a point of the plane that they do.
    axes: (3, 3) rows x, y and forward, in the world.
    window: left, right, bottom, top of the picture on the plane at forward = 1, or in metres of an orthographic one.
    size: width and height in pixels.
    reach: how far from there a ray may start [m]. slant: tangent of the angle by which it may be turned.
    centred: rays pass the middle of their pixel; otherwise somewhere in it.
    """

    kind: str
    origin: np.ndarray
    axes: np.ndarray
    window: tuple[float, float, float, float]
    size: tuple[int, int]
    reach: float = 0.0
    slant: float = 0.0
    centred: bool = True


def of_camera(camera: Camera, subpixels: int = 1, rows: slice | None = None) -> Grid:
    """What `surfels.camera_rays` pass through."""
    left, right, bottom, top = camera.window
    w, h = camera.resolution[0] * subpixels, camera.resolution[1] * subpixels
    first, last, _ = (rows or slice(None)).indices(h)
    step = (top - bottom) / h
    axes = camera.matrix[:3, :3].T * np.array([[1], [1], [-1]])
    return Grid(camera.kind, camera.matrix[:3, 3], axes, (left, right, bottom + first * step, bottom + last * step),
                (w, last - first))  # fmt: skip


def covered(grid: Grid, vertices: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Which triangles the picture may show, and the pixels of each: (v, 3), (t, 3) -> (m,) int32, (m, 4) int32, first
    and last column and row, the last not included. No ray meets a triangle outside of them.

    A ray that starts beside the origin sees what one from the origin would see of the triangle moved as much. Where a
    triangle reaches behind the origin, it is only known on which side of the view all of it lies.
    """
    left, right, bottom, top = grid.window
    inverse = np.linalg.inv(grid.axes)
    local = (vertices - grid.origin) @ inverse
    x, y, z = (plane[triangles] for plane in local.T)
    lowest, highest = z.min(-1), z.max(-1)
    size = np.abs(grid.origin).max() + (max(map(abs, grid.window)) if grid.kind == "ORTHOGRAPHIC" else 0)
    slack = grid.reach + _ROUNDING * size + (grid.slant + _ROUNDING) * np.maximum(highest, 0)
    slack = slack * np.linalg.norm(inverse, 2)
    keep = highest + slack > 0
    sides = []
    for plane, begin, end, pixels in ((x, left, right, grid.size[0]), (y, bottom, top, grid.size[1])):
        low, high = plane.min(-1) - slack, plane.max(-1) + slack
        if grid.kind == "PERSPECTIVE":
            near, far = z - slack[:, None], z + slack[:, None]
            with np.errstate(divide="ignore", invalid="ignore"):
                below, above = plane - slack[:, None], plane + slack[:, None]
                seen_low = np.minimum(below / near, below / far).min(-1)
                seen_high = np.maximum(above / near, above / far).max(-1)
                ahead = lowest > slack
                low = np.where(ahead, seen_low, np.where(low > 0, low / far.max(-1), -np.inf))
                high = np.where(ahead, seen_high, np.where(high < 0, high / far.max(-1), np.inf))
        low, high = (np.clip((side - begin) / (end - begin) * pixels, -1, pixels + 1) for side in (low, high))
        if grid.centred:
            low, high = np.ceil(low - 0.5), np.floor(high - 0.5) + 1
        else:
            low, high = np.floor(low), np.floor(high) + 1
        sides += [np.clip(low, 0, pixels), np.clip(high, 0, pixels)]
        keep &= sides[-1] > sides[-2]
    which = np.flatnonzero(keep).astype(np.int32)
    return which, np.stack(sides, -1)[which].astype(np.int32)
