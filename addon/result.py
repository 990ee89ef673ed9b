# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake gives: plain arrays that know nothing of the file."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..gi_core import lpv, ssgi
from ..gi_core.atlas import Page
from ..gi_core.corners import Corners
from ..gi_core.scene import Mesh
from .job import Job


@dataclass(frozen=True)
class Light:
    """Light on one receiver, E/π, "light without colour" as Cycles' passes and bakes hold it.

    direct, indirect: (h, w, 3) float32 of a lightmap, or (v, 3) of vertices or of triangles' corners.
        Beyond valid texels of lightmaps too, as far as islands grow.
    valid: (h, w) or (v,) bool, where a surface is.
    centred: bool, same shape: the surface covers the texel's centre, not only a part of it, and does not lie inside of
        something. filled: bool, same shape, where there is a value.
    coverage: float32, same shape, 0…1: how surely a camera saw it; None where no camera is asked.
    directional: (h, w, 4, 3) float32, two bands of harmonics (see `gi_core.sh`) whose value at a normal is the light
        that is wanted; radiance: (h, w, 3) float32, what the surface sends out of it, and by itself. None where they
        are not asked for.
    inside: bool, same shape as valid, what no light reaches inside of something, where known.
    corners: of triangles, where light at vertices comes from, else None. known: (3 t,) bool, those that have light.
    """

    direct: np.ndarray
    indirect: np.ndarray
    valid: np.ndarray
    centred: np.ndarray
    filled: np.ndarray
    coverage: np.ndarray | None = None
    directional: np.ndarray | None = None
    radiance: np.ndarray | None = None
    inside: np.ndarray | None = None
    corners: Corners | None = None
    known: np.ndarray | None = None


@dataclass(frozen=True)
class Result:
    """What a bake gives.

    layers: pass name -> (h, w, c) float32 of the camera image, else empty.
    light: name -> Light of lightmaps, by their page, or of vertices, by their object, else empty.
    pages: the lightmaps, and which objects lie where on them. uvs: mesh name -> (corners, 2) float32, lightmap UVs that
        were made for the bake and are not in the file yet. hashes: object name -> of what its lightmap follows from.
        kept: page name -> (h, w, 4) float32, what the file holds of objects that were not baked anew.
    meshes: object name -> its mesh and its matrix in the world, where they are to be written.
    volume: the reflected light everywhere, of the target "volume".
    device: what computed. stages: name -> seconds, in order.
    approximated, warnings: sentences. history: what the next frame of an animation may go on from.
    """

    job: Job
    layers: dict[str, np.ndarray]
    light: dict[str, Light]
    device: str
    stages: dict[str, float]
    approximated: tuple[str, ...]
    warnings: tuple[str, ...]
    volume: lpv.Volume | None = None
    history: ssgi.History | None = None
    pages: tuple[Page, ...] = ()
    hashes: dict[str, str] = field(default_factory=dict)
    kept: dict[str, np.ndarray] = field(default_factory=dict)
    meshes: dict[str, tuple[Mesh, np.ndarray]] = field(default_factory=dict)
    uvs: dict[str, np.ndarray] = field(default_factory=dict)
