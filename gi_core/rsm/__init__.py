# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflective shadow maps: the light of the first bounces, gathered from what the lamps see.

    lighting = emit(tracer, settings)                         the lamps' maps as virtual point lights
    irradiance = indirect(tracer, surfels, lighting, settings)   what they send to any surfels

Both are generators of progress; `tiles.finish` runs one to its value.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from ..emitters import emitters
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls, equalized
from .disk import disk_pattern
from .gathering import every, gather, strided
from .maps import Map, render, trace_flux
from .scatter import scattered, sky_rays
from .settings import RsmSettings
from .views import views

# Lights of equal brightness that a bake keeps: many more than a point gathers from, few enough to stay near the cores.
CLOUD = 1 << 17


@dataclass(frozen=True)
class Lighting:
    """What a bake gathers from.

    maps: of each view of each lamp, where the disk pattern looks for its samples; empty for other patterns.
    reflected: lights for everything else that is reflected; of equal flux, but for the pattern "all".
    """

    maps: tuple[Map, ...]
    reflected: Vpls


def emit(tracer: Tracer, settings: RsmSettings) -> Iterator[float]:
    """Sends the light of lamps, emitting surfaces and the sky out, `settings.bounces` times. A generator; returns
    Lighting."""
    geometry = tracer.geometry
    scene, seed = geometry.scene, settings.seed * 4096
    if not len(geometry.triangles):
        return Lighting((), Vpls.concatenate([]))
    maps, unmapped = [], []
    for light in scene.lights:
        for view in views(light, geometry.bounds, settings.map_resolution):
            maps.append((yield from render(tracer, view, seed + len(maps))))
    surfaces = emitters(geometry, CLOUD)
    for flux_rays in (
        scattered(surfaces, geometry.area, seed),
        sky_rays(scene.environment, geometry.bounds, CLOUD, seed),
    ):
        if len(flux_rays.origin):
            unmapped.append((yield from trace_flux(tracer, flux_rays)).vpls())

    bounce = Vpls.concatenate([m.vpls() for m in maps] + unmapped)
    for k in range(1, settings.bounces):
        flux_rays = scattered(equalized(bounce, CLOUD), geometry.area, seed + k)
        bounce = (yield from trace_flux(tracer, flux_rays)).vpls()
        unmapped.append(bounce)

    if settings.pattern == "disk":
        return Lighting(tuple(maps), equalized(Vpls.concatenate(unmapped), CLOUD))
    reflected = Vpls.concatenate([m.vpls() for m in maps] + unmapped)
    return Lighting((), reflected if settings.pattern == "all" else equalized(reflected, CLOUD))


def indirect(tracer: Tracer, surfels: Surfels, lighting: Lighting, settings: RsmSettings) -> Iterator[float]:
    """Irradiance from reflected light. A generator of progress; returns (n, 3) float32 [W/m²]."""
    n, seed, visibility = settings.samples, settings.seed, settings.visibility
    reflected = lighting.reflected
    if settings.pattern == "all":
        return (yield from gather(tracer, surfels, reflected, every(reflected), len(reflected), visibility))
    irradiance = yield from gather(tracer, surfels, reflected, strided(reflected, n, seed), n, visibility)
    each = max(1, n // max(1, len(lighting.maps)))
    for k, source in enumerate(lighting.maps):
        pattern = disk_pattern(source, settings.disk_radius, each, settings.weighting == "literal", seed * 4096 + k)
        irradiance += yield from gather(tracer, surfels, source.lights(), pattern, each, visibility)
    return irradiance
