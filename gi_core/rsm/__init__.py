# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Reflective shadow maps: the light of the first bounces, gathered from what the lamps see.

    lighting = emit(tracer, surfels, settings)                   the lamps' maps as virtual point lights
    irradiance = indirect(tracer, surfels, lighting, settings)   what they send to surfels

Both are generators of progress; `tiles.finish` runs one to its value.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..gathering import Bound, Every, Strided, gather
from ..near import NearField
from ..sampling import Samples
from ..surfels import Surfels
from ..trace import Tracer
from ..vpls import Vpls, coherent, equalized
from .disk import Disk
from .importance import chosen
from .maps import Map, render, trace_flux
from .near import near_light
from .scatter import scattered, skylit
from .settings import RsmSettings
from .views import views

# Lights of equal brightness that stand for all: at the most so many, which stay near the cores, and so many for each
# that a point looks at. With 128 no error is measurably greater than with all; fewer than the least save nothing.
CLOUD = 1 << 17
_LEAST_CLOUD, _CLOUD_SHARE = 1 << 14, 128

# Lamps whose maps have their full resolution; more lamps share as many texels.
_FULL_MAPS = 4


@dataclass(frozen=True)
class Lighting:
    """What a bake gathers from.

    maps: of each view of each lamp, where the disk pattern looks for its samples; empty for other patterns.
    reflected: lights for everything else that is reflected, in coherent order, chosen for the points that gather.
    """

    maps: tuple[Map, ...]
    reflected: Vpls


def emit(tracer: Tracer, receivers: Surfels, settings: RsmSettings) -> Iterator[float]:
    """Sends the light of lamps, emitting surfaces and the sky out, `settings.bounces` times.

    receivers: the points that will gather, to which the lights are chosen. A generator of progress; returns Lighting.
    """
    seed = settings.seed * 4096
    if not len(tracer.geometry.triangles):
        return Lighting((), Vpls.concatenate([]))
    # Only the flux pattern draws maps anew where they matter; the others gather from one map of a sun as it is.
    focus = _focus(receivers) if settings.pattern == "flux" else None
    cloud = int(np.clip(settings.samples * settings.candidates * _CLOUD_SHARE, _LEAST_CLOUD, CLOUD))
    maps, others = yield from reflections(tracer, settings.map_resolution, seed, focus, cloud)

    first = Vpls.concatenate([m.lights() for m in maps] + others)
    others += yield from further(tracer, first, settings.bounces, seed, cloud)

    if settings.pattern == "all":
        return Lighting((), Vpls.concatenate([m.lights() for m in maps] + others))
    apart = maps if settings.pattern == "disk" else []
    maps = [] if apart else maps
    return Lighting(
        tuple(apart), (yield from chosen(tracer, maps, others, receivers, cloud, seed, settings.visibility))
    )


def reflections(
    tracer: Tracer, resolution: int, seed: int, focus: np.ndarray | None = None, cloud: int = CLOUD
) -> Iterator[float]:
    """The light of lamps, emitting surfaces and the sky where it is first reflected.

    resolution: texels along the side of a lamp's map. focus: (2, 3) corners of the box that a sun's finest map covers,
    None for one map over everything [m]. cloud: lights that stand for what the sky lights.
    A generator of progress; returns the lamps' Maps and a list of Vpls for what has no map.
    """
    geometry = tracer.geometry
    scene = geometry.scene
    # However many lamps there are, their maps take no more than those of a few.
    resolution = max(8, round(resolution * min(1.0, np.sqrt(_FULL_MAPS / max(1, len(scene.lights))))))
    every = [view for light in scene.lights for view in views(light, geometry.bounds, resolution, focus)]
    maps = yield from render(tracer, every, seed)
    others = []
    glow = scattered(tracer.glow, geometry.area, seed)
    if len(glow.origin):
        others.append((yield from trace_flux(tracer, glow)).lights())
    others.append((yield from skylit(tracer, cloud, seed)))
    return maps, others


def further(tracer: Tracer, bounce: Vpls, bounces: int, seed: int, cloud: int = CLOUD) -> Iterator[float]:
    """Light of the first bounce on its way from surface to surface, to the last of so many.

    Of each bounce `cloud` lights of equal brightness send their flux on along one ray. A generator of progress; returns
    a list of Vpls, of each bounce but the first.
    """
    found = []
    for k in range(1, bounces):
        bounce = bounce[coherent(bounce)]
        drawn = equalized(bounce, bounce.flux.mean(-1), cloud)
        bounce = (yield from trace_flux(tracer, scattered(drawn, tracer.geometry.area, seed + k))).lights()
        found.append(bounce)
    return found


def _focus(receivers: Surfels) -> np.ndarray | None:
    """Corners of the box around nearly all points that gather, with room for what lights them: (2, 3) [m]."""
    if not len(receivers):
        return None
    low, high = np.quantile(receivers.position[:: max(1, len(receivers) // 4096)], (0.02, 0.98), axis=0)
    return np.stack([low, high]) + 0.25 * np.max(high - low) * np.array([[-1], [1]])


def indirect(
    tracer: Tracer, surfels: Surfels, lighting: Lighting, settings: RsmSettings, samples: Samples | None = None
) -> Iterator[float]:
    """Irradiance from reflected light. A generator of progress; returns (n, 3) float32 [W/m²].

    samples: those of one pass of several, whose mean is the estimate; None for `settings.samples` at once.
    """
    samples = samples or Samples(settings.samples)
    seed, visibility = settings.seed, settings.visibility
    reflected, bound = lighting.reflected, _bound(settings)
    if not settings.pattern_per_point:
        surfels = replace(surfels, place=np.zeros_like(surfels.place))
    if settings.pattern == "all":
        return (yield from gather(tracer, surfels, reflected, Every(len(reflected)), visibility, bound))
    m = settings.candidates
    pattern = Strided.of(reflected, samples, seed, m)
    # Short rays find light of all lamps and in sight only: with maps apart or without shadow rays they do not fit.
    if settings.bound == "compensated" and settings.pattern == "flux" and visibility and len(reflected):
        field = NearField.of(reflected, samples)
        if bound.area is not None:
            field = replace(field, area=bound.area)
        irradiance = yield from gather(tracer, surfels, reflected, pattern, visibility, field.clamp, m)
        irradiance += yield from near_light(tracer, surfels, field, settings.bounces, seed)
    else:
        irradiance = yield from gather(tracer, surfels, reflected, pattern, visibility, bound, m)
    each = samples.part(1 / max(1, len(lighting.maps)))
    for k, source in enumerate(lighting.maps):
        pattern = Disk.of(source, settings.disk_radius, each, settings.weighting == "literal", seed * 4096 + k)
        irradiance += yield from gather(tracer, surfels, source.lights(), pattern, visibility, bound)
    return irradiance


def _bound(settings: RsmSettings) -> Bound:
    """The bound of lights that nothing compensates for."""
    kind = "disc" if settings.bound == "compensated" else settings.bound
    return Bound(kind, np.pi * settings.bound_distance**2 if settings.bound_distance else None)
