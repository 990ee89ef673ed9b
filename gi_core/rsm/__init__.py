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
from .importance import draw_weight
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
    reflected: lights for everything else that is reflected; equally important ones, but for the pattern "all".
    before: the same without the last bounce: what arrives where the last bounce leaves.
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
            unmapped.append((yield from trace_flux(tracer, flux_rays)).lights())

    bounce = coherent(Vpls.concatenate([m.lights() for m in maps] + unmapped))
    for k in range(1, settings.bounces):
        drawn = equalized(bounce, bounce.flux.mean(-1), CLOUD)
        bounce = coherent((yield from trace_flux(tracer, scattered(drawn, geometry.area, seed + k))).lights())
        unmapped.append(bounce)

    before, reflected = unmapped[:-1] if settings.bounces > 1 else [], unmapped
    if settings.pattern != "disk":
        reflected = [m.lights() for m in maps] + unmapped
        before = reflected[:-1] if settings.bounces > 1 else []
        maps = []
    clouds = []
    for lights in (coherent(Vpls.concatenate(reflected)), coherent(Vpls.concatenate(before))):
        if settings.pattern != "all":
            weight = yield from draw_weight(tracer, lights, receivers, seed, settings.visibility)
            lights = equalized(lights, weight, CLOUD)
        clouds.append(lights)
    return Lighting(tuple(maps), *clouds)


def indirect(tracer: Tracer, surfels: Surfels, lighting: Lighting, settings: RsmSettings) -> Iterator[float]:
    """Irradiance from reflected light. A generator of progress; returns (n, 3) float32 [W/m²]."""
    n, seed, visibility = settings.samples, settings.seed, settings.visibility
    reflected = lighting.reflected
    if settings.pattern == "all":
        return (yield from gather(tracer, surfels, reflected, every(reflected), len(reflected), visibility))
    pattern = strided(reflected, n, seed)
    # Without shadow rays there is no telling what is near in sight.
    if settings.bound == "compensated" and visibility and len(reflected):
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
