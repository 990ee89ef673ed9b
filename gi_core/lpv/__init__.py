# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light propagation volumes: reflected light on a grid, from which any point takes its own.

    volume = emit(tracer, surfels, settings)                   the lamps' maps injected and propagated
    irradiance = indirect(tracer, surfels, volume, settings)   what arrives at surfels

Both are generators of progress; `tiles.finish` runs one to its value.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..emitters import strewn
from ..geometry import Geometry
from ..rsm import further, reflections
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls
from . import flat, hierarchy
from .grid import placed
from .lookup import around, indirect, radiance
from .scattering import scattered
from .settings import LpvSettings
from .volume import Level, Volume

__all__ = ["Level", "LpvSettings", "Volume", "emit", "indirect", "injected", "propagate", "radiance", "scattered"]


# Points that stand for all surfaces where cells at a surface are looked for.
_SURFACE = 1 << 18


def emit(tracer: Tracer, receivers: Surfels | None, settings: LpvSettings) -> Iterator[float]:
    """The volume of a scene.

    receivers: points spread over what will be lit: the finer cascades lie around them. Cells that neither they nor any
        surface looks at stay black; None for all cells.
    A generator of progress; returns a Volume.
    """
    lights = yield from injected(tracer, settings)
    return (yield from propagate(tracer, lights, receivers, settings))


def injected(tracer: Tracer, settings: LpvSettings) -> Iterator[float]:
    """All lights that go into the volume: what lamps, emitting surfaces and the sky light, `settings.bounces` times.

    A generator of progress; returns the Vpls.
    """
    seed = settings.seed * 4096
    if not len(tracer.geometry.triangles):
        return Vpls.concatenate([])
    maps, others = yield from reflections(tracer, settings.map_resolution, seed)
    first = Vpls.concatenate([m.lights() for m in maps] + others)
    every = [first, *(yield from further(tracer, first, settings.bounces, seed))]
    if settings.emissive:
        glow = tracer.glow
        every.append(replace(glow, flux=glow.flux * np.float32(settings.emissive)))
    return Vpls.concatenate(every)


def propagate(tracer: Tracer, lights: Vpls, receivers: Surfels | None, settings: LpvSettings) -> Iterator[float]:
    """Lights into the grids and through them. A generator of progress; returns a Volume."""
    if not len(lights):
        return Volume(())
    camera = tracer.geometry.scene.camera
    eye = None if camera is None else camera.matrix[:3, 3]
    grids = placed(tracer.geometry.bounds, eye, None if receivers is None else receivers.position, settings)
    if settings.propagation == "flat":
        return Volume(tuple((yield from flat.propagated(tracer.geometry, lights, grids, settings, tracer.device))))
    wanted = [np.arange(g.size) for g in grids]
    if receivers is not None:
        looking = np.concatenate([receivers.origin, _surface(tracer.geometry)])
        # A medium looks at all of space.
        wanted = wanted if settings.fog_density else [around(g, looking) for g in grids]
    return Volume(tuple((yield from hierarchy.propagated(tracer, lights, grids, wanted, settings))))


def _surface(geometry: Geometry) -> np.ndarray:
    """Points all over the surfaces, so close that none of the cells at a surface is missed: (n, 3) float32 [m]."""
    corners = geometry.vertices[geometry.triangles]
    triangle, weights, _ = strewn(geometry, np.ones(len(corners)), _SURFACE) if geometry.area > 0 else ([], [], [])
    even = [geometry.position(triangle, weights)] if len(triangle) else []
    return np.concatenate([geometry.vertices, corners.mean(1), *even])
