# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What glossy surfaces reflect to the camera, by rays that are drawn from their lobes.

Not by virtual lights, which diffuse surfaces gather from: few of those lie where a lobe looks, and the narrower it is
the brighter each must count. A ray out of the lobe counts no more than the surface reflects, so nothing needs a bound,
and where it ends the paths that stand in for virtual lights near by (`near.arriving`) tell what light there is.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from .. import environment as beyond
from .. import gloss, sh, tiles
from ..direct import from_environment, from_lamp
from ..sampling import Samples, r2_sequence, rotated
from ..scene import Camera
from ..settings import Settings
from ..surfels import Surfels, along_rays, camera_rays
from ..trace import Tracer
from ..vectors import dot, lit
from .near import arriving

# Points times samples worked on at once by a thread.
_PAIRS = 1 << 15


@dataclass(frozen=True)
class Glossy:
    """Light over colour at points that a camera sees, as Cycles' glossy passes hold it: radiance [W/(m²·sr)] that comes
    to the camera over `color`. (n, 3) float32 each.

    surfels: the points that are glossy.
    lamps: of lamps. around: of emitting surfaces and the environment, seen as in a rough mirror.
    indirect: of light that was reflected before.
    color: share of even light from all around that is reflected to the camera.
    """

    surfels: Surfels
    lamps: np.ndarray
    around: np.ndarray
    indirect: np.ndarray
    color: np.ndarray


def glossy_light(
    tracer: Tracer,
    surfels: Surfels,
    camera: Camera,
    subpixels: int,
    rows: slice,
    settings: Settings,
    field: Callable[[Surfels], np.ndarray] | None = None,
) -> Iterator[float]:
    """What glossy surfaces reflect of those that a camera sees.

    surfels: of `surfels.from_camera`, of some rows of subpixels. settings: `samples` rays go out from each point.
    field: reflected light around surfels as harmonics of radiance, (n, k, 3) (`sh`), which is then taken for what rays
        would find.
    A generator of progress; returns Glossy.
    """
    if not len(surfels):
        return Glossy(surfels, *np.zeros((4, 0, 3), np.float32))
    origins, directions = camera_rays(camera, subpixels, rows)
    first = rows.start * camera.resolution[0] * subpixels
    found: dict[int, tuple[np.ndarray, ...]] = {}

    def tile(part: slice):
        here, view = surfels[part], -directions[surfels.place[part] - first]
        # The same rays meet the same points again, and with them what surfels do not carry.
        hits = tracer.closest(origins[here.place - first], -view)
        shown = gloss.at(tracer.geometry, hits.triangle, hits.weights, here.normal, view)
        color = shown.color()
        row = np.flatnonzero(lit(color))
        shown, color = shown[row], color[row]
        here = replace(here[row], normal=shown.normal, smooth=shown.normal)
        lights = _from_lamps(tracer, here, shown, settings), *_along_lobe(tracer, here, shown, settings, field)
        over = (np.divide(light, color, out=np.zeros_like(light), where=color > 0) for light in lights)
        found[part.start] = part.start + row, *over, color

    parts = tiles.slices(len(surfels), _PAIRS // max(settings.samples, settings.light_samples))
    yield from tiles.run(tile, parts)
    row, *values = (np.concatenate(a) for a in zip(*(found[part.start] for part in parts)))
    return Glossy(surfels[row], *values)


def _along_lobe(tracer: Tracer, here: Surfels, shown: gloss.Gloss, settings: Settings, field):
    """Radiance from surroundings and from what reflects light, each (n, 3), as the mean over rays out of the lobe."""
    n, rays, environment = len(here), settings.samples, tracer.geometry.scene.environment
    around, indirect = np.zeros((2, n * rays, 3), np.float32)
    row = np.repeat(np.arange(n), rays)
    u = rotated(r2_sequence(rays), here.place, settings.seed * 1024 + 1020).reshape(-1, 2)
    direction, weight = shown[row].drawn(u)
    up = np.flatnonzero(lit(weight) & (dot(here.face[row], direction) > 0))
    # A place of its own for each ray, so that what it meets draws samples of its own.
    place = here.place[row[up]] * rays + up % rays
    met, hit = along_rays(tracer, here.origin[row[up]], direction[up], place, reflecting=True)
    around[up[hit]] = met.emission
    if field is not None:
        indirect[up] = np.maximum(sh.evaluate(field(here)[row[up]], direction[up]), 0)
    else:
        indirect[up[hit]] = met.albedo / np.pi * arriving(tracer, met, settings.bounces - 1, settings.seed)
    if not beyond.is_black(environment):
        missed = np.delete(up, hit)
        # Suns in it are drawn as lamps are.
        around[missed] = tracer.sky.radiance(direction[missed])
    return ((weight * light).reshape(n, rays, 3).mean(1) for light in (around, indirect))


def _from_lamps(tracer: Tracer, here: Surfels, shown: gloss.Gloss, settings: Settings) -> np.ndarray:
    """Radiance that is reflected of lamps and of suns in the environment: (n, 3) float32."""
    total, samples, seed = np.zeros((len(here), 3), np.float32), settings.light_samples, settings.seed * 1024

    def brdf(row, direction):
        return shown[row].brdf(direction)

    for k, light in enumerate(tracer.geometry.scene.lights):
        total += from_lamp(tracer, here, light, samples, seed + k, brdf)
    if tracer.suns:
        total += from_environment(tracer, here, tracer.suns, Samples(samples), seed + 1021, brdf)
    return total
