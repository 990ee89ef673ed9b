# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the light that arrives at a pixel comes from: hits on the screen, and what is found elsewhere."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import tiles
from ..bump import mean_shadowing
from ..device import Device
from ..kernels.clamped import clamped
from ..kernels.hit_light import hit_light
from ..kernels.horizon_scan import horizon_scan
from ..kernels.scan_light import scan_light
from ..kernels.screen_trace import MISSED, NO_RAY, rays_of, screen_trace
from ..kernels.slice_draws import slice_draws
from ..kernels.spread import spread
from ..sampling import r2_sequence
from ..surfels import Surfels
from ..trace import FAR, Tracer
from .frame import DepthMap, GBuffer, depth_map
from .paths import onward, paths
from .probes import Probes, answers, unseen
from .settings import SsgiSettings

# Rays worked on at once by a thread: few live long, and a march of few costs as much as one of many.
_RAYS = 1 << 15


@dataclass(frozen=True)
class Search:
    """What is searched, and for whom.

    full: what the screen shows. buffer: the pixels that search, at the resolution of tracing.
    """

    tracer: Tracer
    full: GBuffer
    buffer: GBuffer
    settings: SsgiSettings
    probes: Probes | None

    @property
    def device(self) -> Device:
        return self.tracer.device

    @cached_property
    def points(self) -> Surfels:
        return self.buffer.surfels()

    @cached_property
    def places(self) -> np.ndarray:
        """Which pixels of the buffer search: (n,) int32."""
        return np.flatnonzero(self.buffer.surface).astype(np.int32)

    @cached_property
    def place(self) -> np.ndarray:
        """`places` where kernels run."""
        return self.device.array(self.places, 1)

    @cached_property
    def row(self) -> np.ndarray:
        """Which of them each pixel is, where kernels run: (h, w) int32, −1 for none."""
        row = np.full(self.buffer.depth.size, -1, np.int32)
        row[self.places] = np.arange(len(self.places))
        return self.device.array(row.reshape(self.buffer.depth.shape), 1)

    @cached_property
    def pixels(self) -> np.ndarray:
        """Which pixels of the full screen they are, where kernels run: (n,) int32."""
        if self.buffer is self.full:
            return self.place
        row, column = np.divmod(self.places, self.buffer.screen.shape[1])
        step = self.buffer.screen.step
        return self.device.array(row * step * self.full.screen.shape[1] + column * step, 1)

    @cached_property
    def seen(self) -> GBuffer:
        """What the screen shows, where kernels run."""
        return self.full.on(self.device)

    @cached_property
    def depth(self) -> DepthMap:
        return tiles.finish(depth_map(self.seen, self.device))

    @cached_property
    def local(self) -> tuple[np.ndarray | None, ...]:
        """Of the full screen in camera space, where kernels run, (h, w, 3) each: positions; normals, as long as there
        is light that counts (`bump`); meshes' normals, None where these are the same."""
        axes, normal, smooth = self.full.screen.axes.T.astype(np.float32), self.full.normal, None
        position = (self.full.position - self.full.screen.eye.astype(np.float32)) @ axes
        if self.full.is_bumpy:
            normal, smooth = normal * mean_shadowing(self.full.smooth, normal)[..., None], self.full.smooth @ axes
        local = position * self.full.surface[..., None], normal @ axes, smooth
        return tuple(one if one is None else self.device.array(one, 3) for one in local)

    @property
    def levels(self) -> int:
        """How many bounces are told apart: those that the screen's own light is fed back for."""
        on_screen = self.settings.mode in ("screen_space", "mixed")
        return self.settings.bounces if on_screen and self.settings.feedback == "current" else 1

    @property
    def scans(self) -> bool:
        return self.settings.mode == "screen_space" and self.settings.tracer == "bitmask"

    @property
    def marches(self) -> bool:
        return self.settings.mode == "mixed" or (self.settings.mode == "screen_space" and not self.scans)

    @property
    def looks_elsewhere(self) -> bool:
        """Whether light comes from anything but the screen."""
        return self.settings.mode != "screen_space" or answers(self.settings.fallback, self.tracer, self.probes)

    @property
    def rays(self) -> int:
        """Of each pixel in each pass."""
        return -(-self.settings.samples // self.settings.frames)

    def sequence(self, number: int) -> np.ndarray:
        """What the rays of a pass are drawn by: (rays, 2) float32 of the unit square."""
        return r2_sequence(self.rays, number * self.rays)


@dataclass(frozen=True)
class Found:
    """What one pass of searching found, where kernels run.

    hit: (n · rays,) int32 of `screen_trace`, pixels of the full screen that the rays of each point met; None of a scan.
    rest: (n, levels, 3) float32 mean radiance of what was found elsewhere, of each bounce; of a scan, of all that the
        screen does not show. None where nothing was looked for.
    """

    search: Search
    number: int
    hit: np.ndarray | None
    rest: np.ndarray | None

    @property
    def first_hit(self) -> np.ndarray:
        """Where each point's first ray hit the screen: (n, 3) float32, x, y and depth [m], −1 for a miss or a scan."""
        full, n, rays = self.search.full, len(self.search.places), self.search.rays
        hit = np.full(n, -1) if self.hit is None else self.search.device.numpy(self.hit)[::rays]
        row, column = np.divmod(hit, full.screen.shape[1])
        at = np.stack([column, row, full.depth.ravel()[hit]], -1)
        return np.where(hit[:, None] >= 0, at, -1).astype(np.float32)

    def radiance(self, picture: np.ndarray, level: int) -> Iterator[float]:
        """Mean radiance that arrives where surfaces send what a picture (H, W, 3) shows.

        A generator of progress; returns (h, w, 3) float32 at the resolution of tracing, and (n,) float32 of the points,
        the share of what met nothing on the screen.
        """
        search, rays = self.search, self.search.rays
        device, settings, screen = search.device, search.settings, search.full.screen
        picture = device.run(clamped, picture, settings.clamp)
        pixels, place, (*local, shown) = search.pixels, search.place, search.local if search.scans else (None,)

        def look(part: slice):
            rest = None if self.rest is None else self.rest[part]
            if self.hit is not None:
                hit = self.hit[part.start * rays : part.stop * rays]
                return device.run(hit_light, hit, picture, rest, level, rays)
            u = device.run(slice_draws, place[part], self.number * rays, rays, settings.seed)
            found = device.run(
                horizon_scan, pixels[part], *local, picture, u, screen.pixels_per_unit, screen.parallel,
                settings.thickness, settings.steps, float(np.hypot(*screen.shape)), shown,
            )  # fmt: skip
            return device.run(scan_light, *found, rest, level, rays)

        light, missed = yield from device.each(look, len(search.places), max(1, _RAYS // rays))
        return device.run(spread, light, search.row), missed


def searched(search: Search, valid: np.ndarray | None, number: int) -> Iterator[float]:
    """One pass of searching. A generator of progress; returns Found.

    valid: (H · W,) bool, pixels of the full screen whose light is known; None for all. number: of the pass.
    """
    hit, rest = None, None
    if search.marches:
        hit = yield from tiles.within(0.0, 0.5, _marched(search, valid, number))
    if search.looks_elsewhere:
        hit, rest = yield from tiles.within(0.5, 1.0, _elsewhere(search, hit, number))
    return Found(search, number, hit, rest)


def _marched(search: Search, valid: np.ndarray | None, number: int) -> Iterator[float]:
    """`screen_trace` for all rays of a pass. A generator of progress."""
    device, settings, full = search.device, search.settings, search.seen
    mixed = settings.mode == "mixed"
    steps, back = settings.mixed_steps if mixed else settings.steps, full.screen.back(settings.thickness)
    pixels, place, depth, points = search.pixels, search.place, search.depth, search.sequence(number)
    smooth = full.smooth if full.is_bumpy else None

    def tile(part: slice):
        return device.run(
            screen_trace, pixels[part], place[part], valid, full.depth, full.position, full.normal,
            full.face, depth, points, full.screen, settings.seed, back, steps, mixed, smooth,
        )  # fmt: skip

    return (yield from device.each(tile, len(search.places), max(1, _RAYS // search.rays)))


def _elsewhere(search: Search, hit: np.ndarray | None, number: int) -> Iterator[float]:
    """What rays bring that met nothing on the screen. A generator of progress; returns `hit` and `rest` of Found."""
    points, rays, device = search.points, search.rays, search.device
    sequence, rest = search.sequence(number), np.zeros((len(points), search.levels, 3), np.float32)
    traced = search.settings.mode == "ray_traced"
    met = np.full(len(points) * rays, NO_RAY, np.int32) if hit is None else device.numpy(hit)

    def tile(part: slice):
        here, n = points[part], part.stop - part.start
        smooth = here.smooth if here.is_bumpy else None
        of_part = met[part.start * rays : part.stop * rays]
        rows = None if hit is None else np.flatnonzero(of_part == MISSED)
        direction, rows = rays_of(here.place, here.normal, here.face, sequence, search.settings.seed, rows, smooth)
        if traced:
            of_part[rows] = MISSED
        # A place of its own for each ray, so that what it meets draws samples of its own.
        leaving = here[rows // rays]
        leaving = replace(leaving, place=leaving.place * rays + rows % rays)
        light = np.zeros((n * rays, search.levels, 3), np.float32)
        light[rows] = clamped(_arriving(search, leaving, direction, number), search.settings.clamp)
        rest[part] = light.reshape(n, rays, -1, 3).mean(1)

    yield from tiles.run(tile, tiles.slices(len(points), max(1, _RAYS // rays)))
    return device.array(met, 1) if traced else hit, device.array(rest, 3)


def _arriving(search: Search, here: Surfels, direction: np.ndarray, number: int) -> np.ndarray:
    """Radiance of each bounce that rays bring which met nothing on the screen: (n, levels, 3)."""
    settings, tracer, probes = search.settings, search.tracer, search.probes
    if settings.mode == "screen_space":
        return np.repeat(unseen(settings.fallback, tracer, here, direction, probes)[:, None], search.levels, 1)
    seed = settings.seed * 4096 + number

    def last(met: Surfels, seed: int) -> np.ndarray:
        return np.float32(np.pi) * unseen(settings.last_bounce, tracer, met, onward(met, seed), probes)

    far = settings.ray_length or FAR
    lights = None if settings.last_bounce == "none" else last
    found = paths(tracer, (here.origin, direction, here.place), settings.bounces, seed, far, lights)
    return found if search.levels == settings.bounces else found[:, -1:]
