# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Soft light found once for a pixel whose subpixels all look at one piece of surface.

Such light does not change within a pixel, but what finds it costs as much for each point that asks. One of the
subpixels, drawn anew for each pixel, asks for all, with the samples of all: the mean over the pixel stays what it is.
Where subpixels see different surfaces each asks for itself, so that silhouettes are as smooth as before.
"""

from dataclasses import dataclass

import numpy as np

from .rsm.interpolation import spacing
from .sampling import hash01
from .scene import Camera
from .surfels import Surfels
from .vectors import dot

# Subpixels look at one piece of surface when their normals are within 25° and they lie off its plane by no more than
# this share of a pixel's size.
_COSINE, _OFF_PLANE = np.float32(0.9), np.float32(0.1)


@dataclass(frozen=True)
class Asking:
    """Which points ask for light.

    rows: (m,) of the points, those that ask for their whole pixel first. whole: how many these are.
    source: (n,) for each of all points which of the m it takes its light from.
    """

    rows: np.ndarray
    whole: int
    source: np.ndarray


def asking(
    points: Surfels, place: np.ndarray, shape: tuple[int, int], camera: Camera, subpixels: int, seed: int
) -> Asking:
    """Which of the points that a camera sees ask for light.

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
    face, normal, position = (a[leader, None] for a in (points.face, points.normal, points.position))
    off = np.abs(dot(points.position[at] - position, face)).max(1)
    alike = dot(points.normal[at], normal).min(1) > _COSINE
    alike &= off < _OFF_PLANE * s * spacing(points[leader], camera, s)
    at, leader = at[alike], leader[alike]
    alone = np.ones(n, bool)
    alone[at] = False
    rows = np.concatenate([leader, np.flatnonzero(alone)])
    source = np.zeros(n, np.int64)
    source[at] = np.arange(len(at))[:, None]
    source[alone] = np.arange(len(at), len(rows))
    return Asking(rows, len(at), source)
