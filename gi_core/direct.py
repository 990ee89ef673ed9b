# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Direct light at surfels, from every kind of source, with soft shadows. The calibration against Cycles rests here."""

from collections.abc import Callable, Iterator, Sequence

import numpy as np

from . import environment as beyond
from . import tiles
from .environment import Sky
from .gathering import Strided, gathered
from .lights import towards
from .near import NearField, short_rays, summed
from .sampling import Samples, cosine_hemisphere, hash01, r2_sequence, rotated
from .scene import Light
from .surfels import Surfels
from .trace import FAR, Tracer
from .vectors import dot, lit, offset, pick

# Points times samples worked on at once by a thread; what stays in a core's cache is three times as fast.
_PAIRS = 1 << 15


# Points on emitting surfaces that are looked at for each shadow ray.
_CANDIDATES = 4

# A surface's BRDF towards its viewer: rows of the surfels (m,), unit directions to the light (m, 3) -> (m, 3) [1/sr].
Brdf = Callable[[np.ndarray, np.ndarray], np.ndarray]


def is_hard(light: Light) -> bool:
    """Whether all of a lamp's light comes from one point, or one direction."""
    return {"SUN": light.angle, "AREA": 1.0}.get(light.kind, light.radius) <= 0


def from_lamp(
    tracer: Tracer, surfels: Surfels, light: Light, samples: int, seed: int, brdf: Brdf | None = None
) -> np.ndarray:
    """Irradiance from one lamp: (n, 3) float32 [W/m²], the mean of `samples` stratified points on it.

    brdf: weighs it by what the surface reflects, for radiance [W/(m²·sr)] instead.
    """
    samples = 1 if is_hard(light) else samples
    u = rotated(r2_sequence(samples), surfels.place, seed)
    arrival = towards(light, surfels.position[:, None], u)
    cosine = dot(surfels.normal[:, None], arrival.direction)
    cosine *= (cosine > 0) & lit(arrival.irradiance)
    shone = np.nonzero(cosine)
    row, direction = shone[0], arrival.direction[shone]
    if light.shadow:
        # Not the whole way: the lamp's own surface, where a mesh models it, would stand in its light.
        far = np.minimum(arrival.distance[shone] * np.float32(1 - 1e-4), FAR)
        # The shading normal decides whether a surface is lit. Where its face looks the other way the ray starts behind
        # it, as in Cycles: a closed mesh then shades itself, a sheet of cloth is lit through.
        face = pick(surfels.face, row)
        side = np.sign(dot(face, direction))[:, None]
        cosine[shone] *= tracer.transmittance(offset(pick(surfels.position, row), face * side), direction, far)
    cosine[shone] *= surfels.shadowing(row, direction)
    irradiance = arrival.irradiance
    if brdf:
        irradiance[shone] *= brdf(row, direction)
    return np.einsum("ns,nsc->nc", cosine, irradiance) / np.float32(samples)


def from_environment(
    tracer: Tracer, surfels: Surfels, sky: Sky, samples: Samples, seed: int, brdf: Brdf | None = None
) -> np.ndarray:
    """Irradiance from what lies beyond the scene, or a part of it: (n, 3) float32 [W/m²]. brdf: as for `from_lamp`.

    A share of the rays, the sky's own, goes where its light comes from, the rest is cosine-distributed, and each counts
    by the density of both kinds together (the balance heuristic, Veach 1995).
    """
    n, count = len(surfels), samples.count
    u = rotated(r2_sequence(count, samples.first), surfels.place, seed).reshape(-1, 2)
    row = np.repeat(np.arange(n), count)
    normal = pick(surfels.normal, row)
    direction = cosine_hemisphere(normal, u)
    if sky.share:
        # Of an odd number of rays a point has one more of either kind, by chance.
        turn = (np.arange(count) + hash01(surfels.place, ~seed + samples.first)[:, None]) / count
        drawn = np.flatnonzero(turn.ravel() < sky.share)
        direction[drawn] = sky.sample(u[drawn])
    cosine = dot(normal, direction)
    up = np.flatnonzero((cosine > 0) & (dot(pick(surfels.face, row), direction) > 0))
    seen = tracer.transmittance(pick(surfels.origin, row[up]), pick(direction, up), np.full(len(up), FAR))
    up, seen = up[seen > 0], seen[seen > 0, None]
    worth = np.float32(np.pi)
    if sky.share:
        density = (1 - sky.share) * cosine[up] / np.pi + sky.share * sky.pdf(direction[up])
        # By rounding a ray may leave the light that it was drawn from.
        worth = np.divide(cosine[up], density, out=np.zeros(len(up)), where=density > 0).astype(np.float32)[:, None]
    if surfels.is_bumpy:
        seen = seen * surfels.shadowing(row[up], direction[up])[:, None]
    arrived = np.zeros((n * count, 3), np.float32)
    arrived[up] = worth * seen * sky.radiance(pick(direction, up))
    if brdf:
        arrived[up] *= brdf(row[up], direction[up])
    return arrived.reshape(n, count, 3).mean(1)


def from_lamps(
    tracer: Tracer, surfels: Surfels, samples: int, seed: int, lights: Sequence[Light] | None = None
) -> np.ndarray:
    """Irradiance from all lamps and from suns in the environment, all points at once: (n, 3) float32 [W/m²].

    samples: for each soft lamp, and for the suns. lights: the lamps, None for the scene's.
    """
    irradiance = np.zeros((len(surfels), 3), np.float32)
    for k, light in enumerate(tracer.geometry.scene.lights if lights is None else lights):
        irradiance += from_lamp(tracer, surfels, light, samples, seed * 1024 + k)
    if tracer.suns:
        irradiance += from_environment(tracer, surfels, tracer.suns, Samples(samples), seed * 1024 + 1021)
    return irradiance


def from_surroundings(tracer: Tracer, surfels: Surfels, samples: Samples, seed: int) -> np.ndarray:
    """Irradiance from emitting surfaces and the environment but its suns, all points at once: (n, 3) float32 [W/m²].

    samples: for all emitting surfaces together, and for the environment.
    """
    irradiance = np.zeros((len(surfels), 3), np.float32)
    glow = tracer.glow
    if len(glow):
        field = NearField.of(glow, samples)
        pattern = Strided.of(glow, samples, seed, _CANDIDATES)
        irradiance += gathered(tracer, surfels, glow, pattern, bound=field.clamp, candidates=_CANDIDATES)
        row, met, share = short_rays(tracer, surfels, field, seed)
        irradiance += summed(row, np.pi * met.emission * share[:, None], len(surfels)) / field.rays.count
    if not beyond.is_black(tracer.geometry.scene.environment):
        irradiance += from_environment(tracer, surfels, tracer.sky, samples, seed * 1024 + 1023)
    return irradiance


def lamps(
    tracer: Tracer, surfels: Surfels, samples: int, seed: int, lights: Sequence[Light] | None = None
) -> Iterator[float]:
    """`from_lamps` for any number of surfels, tile by tile. A generator of progress; returns (n, 3) float32 [W/m²]."""
    return (yield from _tiled(lambda here: from_lamps(tracer, here, samples, seed, lights), surfels, samples))


def surroundings(tracer: Tracer, surfels: Surfels, samples: Samples, seed: int) -> Iterator[float]:
    """`from_surroundings` for any number of surfels, tile by tile. A generator; returns (n, 3) float32 [W/m²].

    Such light comes from all around and is as smooth, and as noisy, as reflected light: it may be filtered with it,
    which a lamp's shadows may not.
    """
    if not len(tracer.glow) and beyond.is_black(tracer.geometry.scene.environment):
        return np.zeros((len(surfels), 3), np.float32)
    return (yield from _tiled(lambda here: from_surroundings(tracer, here, samples, seed), surfels, samples.count))


def _tiled(light: Callable[[Surfels], np.ndarray], surfels: Surfels, samples: int) -> Iterator[float]:
    irradiance = np.zeros((len(surfels), 3), np.float32)

    def tile(part: slice):
        irradiance[part] = light(surfels[part])

    yield from tiles.run(tile, tiles.slices(len(surfels), max(1, _PAIRS // samples)))
    return irradiance
