# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Soft light of pixels whose subpixels all look at one piece of surface.

Such light hardly changes within a pixel, and a few samples at one point tell more of it than one at each of several:
they are stratified. So one of the subpixels, drawn for each pixel, asks for all, another one in the next pass. Where
subpixels see different surfaces each asks for itself, so that silhouettes are as smooth as ever.
"""

import numpy as np

from .rsm.interpolation import spacing
from .sampling import hash01
from .scene import Camera
from .surfels import Surfels
from .vectors import dot, pick

# Subpixels look at one piece of surface when their normals are within 25° and they lie off its plane by no more than
# this share of a pixel's size.
_COSINE, _OFF_PLANE = np.float32(0.9), np.float32(0.1)


def alike(
    points: Surfels, place: np.ndarray, shape: tuple[int, int], camera: Camera, subpixels: int, seed: int
) -> np.ndarray:
    """The subpixels of each pixel in which all see one piece of surface: (m, s²) rows of the points, of each pixel in
    an order that begins anywhere.

    points: of whole pixels' rows. place: (n,) of each in an image of `shape` subpixels.
    """
    n, s = len(points), subpixels
    at = np.full(shape[0] * shape[1], -1)
    at[place] = np.arange(n)
    at = at.reshape(shape[0] // s, s, shape[1] // s, s).swapaxes(1, 2).reshape(-1, s * s)
    at = at[(at >= 0).all(1)]
    # By where the pixel lies in the whole image: the same however it is cut into tiles.
    drawn = (hash01(points.place[at[:, 0]], seed * 1024 + 1019) * (s * s)).astype(np.int64)
    leader = at[np.arange(len(at)), drawn]
    face, normal, position = (pick(a, leader[:, None]) for a in (points.face, points.normal, points.position))
    off = np.abs(dot(pick(points.position, at) - position, face)).max(1)
    same = dot(pick(points.normal, at), normal).min(1) > _COSINE
    same &= off < _OFF_PLANE * s * spacing(points[leader], camera, s)
    order = (drawn[same, None] + np.arange(s * s)) % (s * s)
    return np.take_along_axis(at[same], order, 1)
