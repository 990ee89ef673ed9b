# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflective shadow maps: the light of the first bounces, gathered from what the lamps see.

    lighting = emit(tracer, surfels, settings)                   the lamps' maps as virtual point lights
    irradiance = indirect(tracer, surfels, lighting, settings)   what they send to surfels

Both are generators of progress; `tiles.finish` runs one to its value.
"""

from collections.abc import Iterator
from dataclasses import dataclass

from ..emitters import emitters
from ..gathering import every, gather, strided
from ..near import NearField
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls, coherent, equalized
from .disk import disk_pattern
from .importance import chosen
from .maps import Map, render, trace_flux
from .near import near_light
from .scatter import scattered, sky_rays
from .settings import RsmSettings
from .views import views

# Lights of equal brightness that a bake keeps: many more than a point gathers from, few enough to stay near the cores.
CLOUD = 1 << 17


@dataclass(frozen=True)
class Lighting:
    """What a bake gathers from.

    maps: of each view of each lamp, where the disk pattern looks for its samples; empty for other patterns.
    reflected: lights for everything else that is reflected, in coherent order, chosen for the points that gather.
    before: the same without the last bounce, for the flux pattern: what arrives where the last bounce leaves.
    """

    maps: tuple[Map, ...]
    reflected: Vpls
    before: Vpls


def emit(tracer: Tracer, receivers: Surfels, settings: RsmSettings) -> Iterator[float]:
    """Sends the light of lamps, emitting surfaces and the sky out, `settings.bounces` times.

    receivers: the points that will gather, to which the lights are chosen. A generator of progress; returns Lighting.
    """
    geometry = tracer.geometry
    scene, seed = geometry.scene, settings.seed * 4096
    if not len(geometry.triangles):
        return Lighting((), Vpls.concatenate([]), Vpls.concatenate([]))
    maps: list[Map] = []
    for light in scene.lights:
        for view in views(light, geometry.bounds, settings.map_resolution):
            maps.append((yield from render(tracer, view, seed + len(maps))))
    others = []
    for flux_rays in (
        scattered(emitters(geometry, CLOUD), geometry.area, seed),
        sky_rays(scene.environment, geometry.bounds, CLOUD, seed),
    ):
        if len(flux_rays.origin):
            others.append((yield from trace_flux(tracer, flux_rays)).lights())

    bounce = Vpls.concatenate([m.lights() for m in maps] + others)
    for k in range(1, settings.bounces):
        bounce = bounce[coherent(bounce)]
        drawn = equalized(bounce, bounce.flux.mean(-1), CLOUD)
        bounce = (yield from trace_flux(tracer, scattered(drawn, geometry.area, seed + k))).lights()
        others.append(bounce)

    if settings.pattern == "all":
        return Lighting((), Vpls.concatenate([m.lights() for m in maps] + others), Vpls.concatenate([]))
    if settings.pattern == "disk":
        cloud = yield from chosen(tracer, [], others, receivers, CLOUD, seed, settings.visibility)
        return Lighting(tuple(maps), cloud, Vpls.concatenate([]))
    cloud = yield from chosen(tracer, maps, others, receivers, CLOUD, seed, settings.visibility)
    before = Vpls.concatenate([])
    if settings.bounces > 1:
        before = yield from chosen(tracer, maps, others[:-1], receivers, CLOUD, seed, settings.visibility)
    return Lighting((), cloud, before)


def indirect(tracer: Tracer, surfels: Surfels, lighting: Lighting, settings: RsmSettings) -> Iterator[float]:
    """Irradiance from reflected light. A generator of progress; returns (n, 3) float32 [W/m²]."""
    n, seed, visibility = settings.samples, settings.seed, settings.visibility
    reflected = lighting.reflected
    if settings.pattern == "all":
        return (yield from gather(tracer, surfels, reflected, every(reflected), len(reflected), visibility))
    pattern = strided(reflected, n, seed)
    # Short rays find light of all lamps and in sight only: with maps apart or without shadow rays they do not fit.
    if settings.bound == "compensated" and settings.pattern == "flux" and visibility and len(reflected):
        field = NearField.of(reflected, n)
        irradiance = yield from gather(tracer, surfels, reflected, pattern, n, visibility, field.ceiling)
        irradiance += yield from near_light(tracer, surfels, field, lighting.before, seed)
    else:
        irradiance = yield from gather(tracer, surfels, reflected, pattern, n, visibility)
    each = max(1, n // max(1, len(lighting.maps)))
    for k, source in enumerate(lighting.maps):
        pattern = disk_pattern(source, settings.disk_radius, each, settings.weighting == "literal", seed * 4096 + k)
        irradiance += yield from gather(tracer, surfels, source.lights(), pattern, each, visibility)
    return irradiance
