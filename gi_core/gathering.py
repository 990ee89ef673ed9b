# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Gathering: irradiance at surfels from virtual point lights, with shadow rays between them."""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from . import tiles
from .device import NUMPY, Device
from .kernels.vpl_bump import bumped
from .kernels.vpl_gather import added, chosen, unshadowed
from .kernels.vpl_shadowed import shadowed
from .sampling import Samples, hash01
from .surfels import Surfels
from .trace import Tracer
from .vectors import dot, pick
from .vpls import Packed, Vpls

# Pairs of surfel and light worked on at once by a thread: arrays that stay within a core's cache and some 50 MB of
# memory.
_PAIRS = 1 << 16

# Pairs worked on at once by a graphics card, 16 bytes each.
_DEVICE_PAIRS = 1 << 22

# Whole numbers beyond are not exact in single precision, in which a graphics card counts lights.
_DEVICE_LIGHTS = 1 << 24


class Pattern(Protocol):
    """Which lights points look at: an object that is called with Surfels, and gives index (n, s), −1 for none, and the
    factor by which each counts, (n, s) or a scalar.

    lights: s. sources: the files in kernels/ that compute the same.
    """

    lights: int
    sources: tuple[str, ...]

    def __call__(self, here: Surfels) -> tuple[np.ndarray, np.ndarray | float]: ...

    def on_gpu(self, gpu, here: Surfels, place) -> tuple[dict, dict[str, int], dict[str, float]]:
        """What its sources need beside the points' places: inputs, integers and floats, see `GpuDevice.dispatch`."""

    def order(self, here: Surfels, neighbours: int) -> np.ndarray | None:
        """The points' indices, (n,), in an order in which so many neighbours take the same light or the next as their
        samples of the same number, the later the further their state goes; None where there is no such order."""


@dataclass(frozen=True)
class Bound:
    """What keeps lights that are very near from being infinitely bright.

    kind: how, see `vpl_transfer`. area: by which area [m²]; None for what each light stands for.
    """

    kind: str = "disc"
    area: float | None = None


def gathered(
    tracer: Tracer,
    here: Surfels,
    vpls: Vpls,
    pattern: Pattern,
    visibility: bool = True,
    bound: Bound = Bound(),
    candidates: int = 1,
) -> np.ndarray:
    """Irradiance that the pattern's lights send to each surfel, all pairs at once: (n, 3) float32 [W/m²].

    candidates: of so many lights that follow each other in the pattern one gets the shadow ray, see `chosen`.
    """
    return _gathered(tracer, here, vpls, Packed.of(vpls, bound.area), pattern, visibility, bound.kind, candidates)


def _gathered(tracer, here, vpls, lights, pattern, visibility, bound, candidates) -> np.ndarray:
    picked = _picked(NUMPY, here, lights, pattern, bound, candidates)
    return _seen(tracer, here, vpls, picked) if visibility else added(picked, vpls.flux)


def _picked(device: Device, here: Surfels, lights: Packed, *how):
    """What `chosen` gives, with what relief takes of it, on the device."""
    picked = device.run(chosen, here, lights, *how)
    if not here.is_bumpy:
        return picked
    return device.run(bumped, picked, here.position, here.normal, here.smooth, lights.at)


def _seen(tracer: Tracer, here: Surfels, vpls: Vpls, picked: np.ndarray) -> np.ndarray:
    """Irradiance from the picked lights, as far as they are in sight: (s, n, 2) -> (n, 3)."""
    index, weight = picked[..., 0], picked[..., 1]
    pair = np.nonzero(weight)
    origin, target = pick(here.origin, pair[1]), pick(vpls.origin, index[pair].astype(np.int32))
    # A surface's back is dark, whatever its shading normal says.
    seen = np.flatnonzero(dot(target - origin, pick(here.face, pair[1])) > 0)
    share = np.zeros(len(origin), np.float32)
    share[seen] = tracer.between(pick(origin, seen), pick(target, seen))
    weight[pair] *= share
    return added(picked, vpls.flux)


def gather(
    tracer: Tracer,
    surfels: Surfels,
    vpls: Vpls,
    pattern: Pattern,
    visibility: bool = True,
    bound: Bound = Bound(),
    candidates: int = 1,
) -> Iterator[float]:
    """The same for any number of surfels, tile by tile, on the tracer's device. A generator of progress; returns (n, 3)
    float32 [W/m²]."""
    irradiance = np.zeros((len(surfels), 3), np.float32)
    if not len(vpls) or not len(surfels):
        return irradiance
    device = tracer.device if len(vpls) < _DEVICE_LIGHTS else NUMPY
    lights = Packed.of(vpls, bound.area)
    if device is not NUMPY:
        lights = lights.on(device, bool(visibility and tracer.on_card))
        # Of the lights of all no list is made where they are not asked for one by one.
        at_once = candidates == 1 and not visibility and not surfels.is_bumpy
        samples = 1 if at_once else pattern.lights // candidates
        parts = tiles.slices(len(surfels), _DEVICE_PAIRS // samples)
        for k, part in enumerate(parts):
            work = _on_device(device, tracer, surfels[part], vpls, lights, pattern, visibility, bound.kind, candidates)
            irradiance[part] = yield from tiles.within(k / len(parts), (k + 1) / len(parts), work)
        return irradiance

    def tile(part: slice):
        here = surfels[part]
        irradiance[part] = _gathered(tracer, here, vpls, lights, pattern, visibility, bound.kind, candidates)

    yield from tiles.run(tile, tiles.slices(len(surfels), _PAIRS // pattern.lights))
    return irradiance


def _on_device(device: Device, tracer, here, vpls, lights, pattern, visibility, bound, candidates) -> Iterator[float]:
    """Irradiance at surfels, all at once but for Embree's rays. A generator of progress; returns (n, 3) float32."""
    asked = here, lights, pattern, bound, candidates
    if not visibility:

        def unseen(_):
            if here.is_bumpy:
                return device.run(added, _picked(device, *asked), lights.flux)
            return device.run(unshadowed, *asked)

        return device.numpy((yield from device.each(unseen, len(here), len(here))))
    if tracer.on_card:

        def work(_):
            picked = _picked(device, *asked)
            seen = device.run(shadowed, picked, here.origin, here.face, lights.origin, tracer.on_card.bvh)
            return device.run(added, seen, lights.flux)

        return device.numpy((yield from device.each(work, len(here), len(here))))
    picked = device.numpy((yield from device.each(lambda _: _picked(device, *asked), len(here), len(here))))
    irradiance = np.zeros((len(here), 3), np.float32)

    def tile(part: slice):
        irradiance[part] = _seen(tracer, here[part], vpls, picked[:, part])

    yield from tiles.run(tile, tiles.slices(len(here), _PAIRS // len(picked)))
    return irradiance


@dataclass(frozen=True)
class Every:
    """The reference: each point gathers from all lights."""

    lights: int
    sources = ("vpl_every",)

    def __call__(self, here: Surfels):
        return np.broadcast_to(np.arange(self.lights), (len(here), self.lights)), 1.0

    def on_gpu(self, gpu, here: Surfels, place):
        return {}, {}, {}

    def order(self, here: Surfels, neighbours: int):
        return None


@dataclass(frozen=True)
class Strided:
    """Each point takes every k-th light from a start of its own; for lights of equal brightness (`vpls.equalized`).

    lights: that a point takes, of `count`. shift: of these in the gaps between others, 0…1.
    """

    lights: int
    count: int
    shift: float
    seed: int
    sources = ("vpl_strided",)

    @staticmethod
    def of(vpls: Vpls, samples: Samples, seed: int, candidates: int = 1) -> "Strided":
        """candidates: lights for each sample."""
        return Strided(samples.count * candidates, len(vpls), samples.shift(), seed)

    @property
    def stride(self) -> np.float32:
        return np.float32(self.count / self.lights)

    def __call__(self, here: Surfels):
        # In single precision throughout, so that every device finds the same lights.
        lights = np.arange(self.lights, dtype=np.float32) + self._start(here)[:, None]
        return np.minimum((lights * self.stride).astype(np.int64), self.count - 1), self.stride

    def on_gpu(self, gpu, here: Surfels, place):
        return {"start": (self._start(here), 1)}, {"count": self.count}, {"stride": float(self.stride)}

    def order(self, here: Surfels, neighbours: int):
        if neighbours * self.stride > len(here):
            return None
        # Numbers of sixteen bits are sorted the fastest, and need not be told apart further.
        return np.argsort((self._start(here) * 65536).astype(np.uint16), kind="stable")

    def _start(self, here: Surfels) -> np.ndarray:
        start = hash01(here.place, self.seed) + np.float32(self.shift)
        return start - (start >= 1)
