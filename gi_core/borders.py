# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a lightmap still needs once its light is known: no texels from inside of walls, islands grown, seams closed."""

from dataclasses import dataclass

import numpy as np

from .dilate import dilate, spread_in
from .sampling import cosine_hemisphere, hash01
from .seams import Seams, disagreement, stitched
from .surfels import Surfels
from .trace import Tracer
from .vectors import dot

# Rays that find out whether a texel lies inside something, and the share of back faces above which it does.
_RAYS, _BACK = 16, 0.5

# Light up to which a texel may be one that none reaches, as a share of the mean.
_DARK = 1e-3


@dataclass(frozen=True)
class Bordered:
    """A finished lightmap.

    image: (h, w, c) float32. filled: (h, w) bool, where it holds a value. inside: number of texels inside of geometry.
    before, after: how far the two sides of seams disagree, see `seams.disagreement`; after no more than before.
    pairs: points at which they were compared.
    """

    image: np.ndarray
    filled: np.ndarray
    inside: int
    before: float
    after: float
    pairs: int


def bordered(
    image: np.ndarray, valid: np.ndarray, hidden: np.ndarray, centred: np.ndarray, margin: int, found: Seams
) -> Bordered:
    """A lightmap with everything that is not its own made up.

    image: (h, w, c). valid: (h, w) bool, where a surface is. hidden: (h, w) bool, where that lies inside of something.
    centred: (h, w) bool, whose middle a face covers. margin: texels by which islands grow. found: seams, empty to leave
    them.
    """
    image = spread_in(image, valid & ~hidden, hidden)
    image, filled = dilate(image, valid, margin)
    before = disagreement(image, found)
    if len(found):
        image = stitched(image, found, filled, centred & ~hidden)
    return Bordered(image, filled, int(hidden.sum()), before, disagreement(image, found), len(found))


def dark(light: np.ndarray, valid: np.ndarray) -> np.ndarray:
    """Texels that light hardly reaches: (h, w, c), (h, w) bool -> (h, w) bool; none where all is dark."""
    total = light.sum(-1)
    mean = float(total[valid].mean(dtype=np.float64)) if valid.any() else 0.0
    return valid & (total <= _DARK * mean) if mean > 0 else np.zeros_like(valid)


def unlit(light: np.ndarray, valid: np.ndarray, centred: np.ndarray, inside: np.ndarray) -> np.ndarray:
    """Texels whose darkness says nothing of the surface around them: they lie inside of something, or are a sliver of a
    face at its border, in the wall that it runs into. (h, w, c), (h, w) bool three times -> (h, w) bool."""
    return inside | (dark(light, valid) & ~centred)


def inside(tracer: Tracer, points: Surfels, seed: int = 0) -> np.ndarray:
    """Whether points lie inside of something: most of what they see are back faces. (n,) bool."""
    n = len(points)
    row = np.repeat(np.arange(n), _RAYS)
    number = points.place[row] * _RAYS + np.tile(np.arange(_RAYS), n)
    u = np.stack([hash01(number, seed + k) for k in (0, 1)], -1)
    direction = cosine_hemisphere(points.face[row], u)
    hits = tracer.closest(points.origin[row], direction)
    met = np.flatnonzero(hits.triangle >= 0)
    back = np.zeros(len(row), bool)
    back[met] = dot(tracer.geometry.face_normal(hits.triangle[met]), direction[met]) > 0
    return back.reshape(n, _RAYS).mean(1) > _BACK
