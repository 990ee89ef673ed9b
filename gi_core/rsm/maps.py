# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflective shadow maps: what a light sees, and the flux that it reflects (Dachsbacher & Stamminger 2005, §3)."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from .. import tiles
from ..surfels import TILE, Surfels, along_rays
from ..trace import Hits, Tracer
from ..vectors import dot, length
from ..vpls import Vpls
from .views import Rays, View, texel_rays

# Grazing texels are long; beyond this their footprint says nothing about where their light is.
_MIN_COSINE = 0.05

# The most that a shading normal may brighten what a grazing ray lights.
_MAX_SHADING = 10.0


@dataclass(frozen=True)
class Map:
    """The texels of one map that see a surface.

    surfels: their points, normals towards the light; `place` is row · resolution + column.
    flux: (n, 3) float32 reflected radiant flux Φ [W].
    area: (n,) float32 that the texel covers on the surface [m²].
    depth: (n,) float32 distance from the light along the ray [m].
    view: the projection; None where rays start all over a surface and there is nothing to project to.
    """

    surfels: Surfels
    flux: np.ndarray
    area: np.ndarray
    depth: np.ndarray
    view: View | None = None

    def __getitem__(self, rows: slice) -> "Map":
        return Map(self.surfels[rows], self.flux[rows], self.area[rows], self.depth[rows], self.view)

    def lights(self) -> Vpls:
        """A light for each texel, in the order of `surfels`; it shines about the face's normal, from the face's
        area."""
        s = self.surfels
        return Vpls(s.position, s.origin, s.face, self.flux, self.area)


def render(tracer: Tracer, views: list[View], seed: int) -> Iterator[float]:
    """The maps of views, those that are not drawn with all their rays in one go: an area light has sixteen. A generator
    of progress; returns a list of Maps."""
    maps, traced = {}, []
    for k, view in enumerate(views):
        flux_rays = texel_rays(view, seed + k)
        drawn = None
        if (grid := view.grid) is not None:
            drawn = yield from tracer.drawn(grid, flux_rays.origin, flux_rays.direction)
        if drawn is None:
            traced.append((k, flux_rays))
        else:
            maps[k] = yield from trace_flux(tracer, flux_rays, from_lamps=True, solid=drawn)
    if traced:
        every = yield from trace_flux(tracer, Rays.concatenate([r for _, r in traced]), from_lamps=True)
        first = np.cumsum([0] + [len(r.origin) for _, r in traced])
        ends = np.searchsorted(every.surfels.place, first)
        for (k, _), base, begin, end in zip(traced, first, ends, ends[1:]):
            part = every[begin:end]
            maps[k] = replace(part, surfels=replace(part.surfels, place=part.surfels.place - base))
    return [replace(maps[k], view=view) for k, view in enumerate(views)]


def trace_flux(
    tracer: Tracer, flux_rays: Rays, from_lamps: bool = False, solid: Hits | None = None
) -> Iterator[float]:
    """Follows rays that carry flux to the surfaces that reflect it. A generator of progress; returns a Map whose
    `place` is the ray's index. solid: as for `Tracer.closest`."""
    parts = tiles.slices(len(flux_rays.origin), TILE)
    found: dict[int, Map] = {}

    def tile(part: slice):
        origin, direction = flux_rays.origin[part], flux_rays.direction[part]
        place, known = np.arange(part.start, part.stop), solid and solid[part]
        surfels, hit = along_rays(tracer, origin, direction, place, reflecting=True, solid=known)
        ray = hit + part.start
        arm = surfels.position - flux_rays.origin[ray]
        depth = length(arm)
        cosine = np.abs(dot(flux_rays.direction[ray], surfels.face))
        area = (flux_rays.spread[ray] + flux_rays.solid_angle[ray] * depth**2) / np.maximum(cosine, _MIN_COSINE)
        # A smooth surface receives by its shading normal, which the flux of a ray knows nothing of (Veach 1997, §5.3).
        shading = -dot(flux_rays.direction[ray], surfels.normal) / np.maximum(cosine, 1e-6)
        if from_lamps:
            # Where it turns away from a lamp that the face sees, Cycles lights the face's other side.
            surfels = surfels.turned(shading < 0)
            shading = np.abs(shading)
        shading = shading * surfels.shadowing(slice(None), -flux_rays.direction[ray])
        flux = flux_rays.flux[ray] * surfels.albedo * np.clip(shading, 0, _MAX_SHADING)[:, None]
        found[part.start] = Map(surfels, flux, area.astype(np.float32), depth)

    yield from tiles.run(tile, parts)
    maps = [found[part.start] for part in parts]
    return Map(
        Surfels.concatenate([m.surfels for m in maps]),
        np.concatenate([m.flux for m in maps]),
        np.concatenate([m.area for m in maps]),
        np.concatenate([m.depth for m in maps]),
    )
