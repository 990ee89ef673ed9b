# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Light where the screen shows nothing: probes in the scene, and the sky.

Anything that gives irradiance at points can stand in for the probes here (`Probes`), a light propagation volume for
one. Those here are what is baked where no other are there: a small grid, each probe six irradiances, to ±x, ±y and ±z
(the ambient cube; McTaggart, "Half-Life 2/Valve Source Shading", 2004), by rays through the scene.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from .. import environment as beyond
from .. import lpv, tiles
from ..surfels import Surfels
from ..trace import FAR, Tracer
from .paths import paths
from .settings import SsgiSettings

# Points to irradiance of reflected light (n, 3) [W/m²], and how far that is known there (n,), 0…1.
Probes = Callable[[Surfels], tuple[np.ndarray, np.ndarray]]

_RAYS, _PAIRS = 1 << 15, 1 << 16


@dataclass(frozen=True)
class ProbeVolume:
    """A grid of probes.

    tracer: finds what stands between a point and a probe. origin: (3,) of the first probe, spacing: between probes [m].
    cube: (x, y, z, 6, 3) float32, irradiance on a plane that faces +x, +y, +z, −x, −y, −z [W/m²].
    """

    tracer: Tracer
    origin: np.ndarray
    spacing: float
    cube: np.ndarray

    def __call__(self, points: Surfels) -> tuple[np.ndarray, np.ndarray]:
        """Irradiance at points, the trilinear mix of the probes around that are in sight of them."""
        irradiance, weight = np.zeros((len(points), 3), np.float32), np.zeros(len(points), np.float32)
        for part in tiles.slices(len(points), _PAIRS):
            irradiance[part], weight[part] = self._at(points[part])
        return irradiance, weight

    def _at(self, points: Surfels):
        size = np.array(self.cube.shape[:3])
        at = (points.position - self.origin) / self.spacing
        low = np.floor(np.clip(at, 0, np.maximum(size - 1.001, 0)))
        u = np.clip(at - low, 0, 1)
        square = points.normal**2
        side = np.where(points.normal < 0, 3, 0) + np.arange(3)
        start = points.origin
        total, weight = np.zeros((len(points), 3), np.float32), np.zeros(len(points), np.float32)
        for corner in np.ndindex(2, 2, 2):
            x, y, z = np.minimum(low + corner, size - 1).astype(np.int64).T
            share = np.prod(np.where(corner, u, 1 - u), -1)
            probe = (self.origin + np.stack([x, y, z], -1) * self.spacing).astype(np.float32)
            wanted = np.flatnonzero(share > 0)
            share[wanted] *= self.tracer.connected(start[wanted], probe[wanted])
            cube = self.cube[x[:, None], y[:, None], z[:, None], side]
            total += share[:, None] * np.einsum("na,nac->nc", square, cube)
            weight += share
        return total / np.maximum(weight, np.float32(1e-20))[:, None], np.minimum(weight, 1)


def bake_probes(tracer: Tracer, settings: SsgiSettings) -> Iterator[float]:
    """Probes all over the scene. A generator of progress; returns a ProbeVolume, None for a scene without surfaces."""
    if not len(tracer.geometry.triangles):
        return None
    low, high = tracer.geometry.bounds.astype(np.float64)
    spacing = max(float(np.max(high - low)) / settings.probe_cells, 1e-6)
    size = np.maximum(np.ceil((high - low) / spacing - 1e-6), 1).astype(int)
    # In the middles of cells that share out the extent evenly around its centre.
    origin = (low + high) / 2 - (size - 1) / 2 * spacing
    position = origin + np.stack(np.indices(size), -1).reshape(-1, 3) * spacing
    rays = settings.probe_rays
    direction = _sphere(rays)
    axes = np.concatenate([np.eye(3), -np.eye(3)]).astype(np.float32)
    lobe = np.maximum(direction @ axes.T, 0) * np.float32(4 * np.pi / rays)
    cube = np.zeros((len(position), 6, 3), np.float32)

    def tile(part: slice):
        place = np.arange(part.start * rays, part.stop * rays)
        start = np.repeat(position[part], rays, 0).astype(np.float32)
        every = np.tile(direction, (part.stop - part.start, 1))
        light = paths(tracer, (start, every, place), settings.bounces, settings.seed * 4096 + 4095)[:, -1]
        cube[part] = np.einsum("pnc,na->pac", light.reshape(-1, rays, 3), lobe)

    yield from tiles.run(tile, tiles.slices(len(position), max(1, _RAYS // rays)))
    return ProbeVolume(tracer, origin, spacing, cube.reshape(*size, 6, 3))


def propagated(tracer: Tracer, settings: SsgiSettings) -> Iterator[float]:
    """A light propagation volume as Probes. A generator of progress."""
    chosen = lpv.LpvSettings(bounces=settings.bounces, seed=settings.seed)
    volume = yield from lpv.emit(tracer, None, chosen)

    def light(points: Surfels) -> tuple[np.ndarray, np.ndarray]:
        return tiles.finish(lpv.indirect(tracer, points, volume, chosen)), np.ones(len(points), np.float32)

    return light


def _sphere(n: int) -> np.ndarray:
    """Directions spread evenly over the sphere, a Fibonacci lattice: (n, 3) float32."""
    i = np.arange(n) + 0.5
    z, angle = 1 - 2 * i / n, np.pi * (1 + np.sqrt(5)) * i
    across = np.sqrt(1 - z * z)
    return np.stack([across * np.cos(angle), across * np.sin(angle), z], -1).astype(np.float32)


def answers(kind: str, tracer: Tracer, probes: Probes | None) -> bool:
    """Whether there may be anything but black in what is `unseen`."""
    sky = kind in ("sky", "both") and not beyond.is_black(tracer.sky.environment)
    return sky or (kind in ("probes", "both") and probes is not None)


def unseen(kind: str, tracer: Tracer, points: Surfels, direction: np.ndarray, probes: Probes | None) -> np.ndarray:
    """Radiance along rays for which the screen has no answer: (n, 3) float32 [W/(m²·sr)].

    kind: "none", "sky", "probes", or "both": probes as far as they reach, and the sky beyond. points: where the rays
        leave, direction: (n, 3).
    Where a ray really reaches the sky that is direct light, which is counted already: the sky stands in only for what
    hides it.
    """
    radiance, left = np.zeros((len(points), 3), np.float32), np.ones(len(points), np.float32)
    if kind in ("probes", "both") and probes is not None:
        irradiance, weight = probes(points)
        radiance += irradiance / np.pi * weight[:, None]
        left -= weight
    if kind in ("sky", "both") and not beyond.is_black(tracer.sky.environment):
        rows = np.flatnonzero(left > 0)
        hidden = 1 - tracer.transmittance(points.origin[rows], direction[rows], np.full(len(rows), FAR))
        radiance[rows] += (left[rows] * hidden)[:, None] * tracer.sky.radiance(direction[rows])
    return radiance
