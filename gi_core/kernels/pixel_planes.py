# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each pixel shows as a plane in the screen's space, for rays to be marched through."""

import numpy as np

from .depth_pyramid import NOTHING

# So that a ray that stops where the nearest is has not passed the plane by rounding.
_HAIR = np.float32(2**-19)


def pixel_planes(depth, position, face, screen):
    """Pixels' planes by what is seen there.

    depth: (n,) float32 along the view axis [m], inf where no surface is. position, face: (n, 3) float32. screen: the
    camera's.
    Returns (n,) float32 device depth, NOTHING where no surface is; (n, 2) float32, its change per pixel along x and y;
    and (n,) float32, the nearest of each pixel's corners, and a hair nearer than that.
    """
    surface = np.isfinite(depth)
    ground = np.where(surface, screen.device(np.where(surface, depth, 1)), NOTHING).astype(np.float32)
    slope = np.zeros((len(depth), 2), np.float32)
    slope[surface] = screen.slopes(position[surface], face[surface])
    nearest = np.where(surface, ground - np.abs(slope).sum(-1) / 2 - _HAIR * np.abs(ground), NOTHING)
    return ground, slope, nearest.astype(np.float32)


def pixel_planes_on_gpu(gpu, depth, position, face, screen):
    n = len(depth)
    ground, slope, nearest = gpu.empty((n,), 1), gpu.empty((n, 2), 2), gpu.empty((n,), 1)
    inputs = {"depth": (depth, 1), "position": (position, 3), "face": (face, 3), "axes": (screen.frame, 3)}
    unit_x, unit_y = screen.pixels_per_unit
    gpu.dispatch(
        "pixel_planes", n, inputs, {"ground": ground, "slope": slope, "nearest": nearest},
        integers={"parallel": screen.parallel}, floats={"unit_x": unit_x, "unit_y": unit_y},
    )  # fmt: skip
    return ground, slope, nearest
