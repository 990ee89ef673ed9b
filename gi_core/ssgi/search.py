# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Where the light that arrives at a pixel comes from: hits on the screen, and what is found elsewhere."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import tiles
from ..kernels.depth_march import depth_march
from ..kernels.horizon_scan import horizon_scan
from ..sampling import cosine_hemisphere, hash01, r2_sequence, rotated
from ..surfels import Surfels
from ..trace import FAR, Tracer
from ..vectors import dot, length
from .frame import DepthMap, GBuffer, depth_map
from .paths import onward, paths
from .probes import Probes, unseen
from .settings import SsgiSettings

# Rays worked on at once by a thread: few live long, and a march of few costs as much as one of many.
_RAYS = 1 << 15

# The start bias as a share of the distance, and the slant at which it stops growing.
_BIAS, _LEAST_SLANT = np.float32(1e-3), np.float32(1e-2)


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

    @cached_property
    def points(self) -> Surfels:
        return self.buffer.surfels()

    @cached_property
    def pixels(self) -> np.ndarray:
        """Which pixels of the full screen search: (n,) int32."""
        row, column = np.divmod(self.points.place, self.buffer.screen.shape[1])
        step = self.buffer.screen.step
        return (row * step * self.full.screen.shape[1] + column * step).astype(np.int32)

    @cached_property
    def depth(self) -> DepthMap:
        return depth_map(self.full)

    @cached_property
    def local(self) -> tuple[np.ndarray, np.ndarray]:
        """Positions and normals of the full screen in camera space: (h, w, 3) each."""
        axes = self.full.screen.axes.T.astype(np.float32)
        position = (self.full.position - self.full.screen.eye.astype(np.float32)) @ axes
        return position * self.full.surface[..., None], self.full.normal @ axes

    @property
    def levels(self) -> int:
        """How many bounces are told apart: those that the screen's own light is fed back for."""
        on_screen = self.settings.mode in ("screen_space", "mixed")
        return self.settings.bounces if on_screen and self.settings.feedback == "current" else 1

    @property
    def scans(self) -> bool:
        return self.settings.mode == "screen_space" and self.settings.tracer == "bitmask"

    @property
    def rays(self) -> int:
        """Of each pixel in each pass."""
        return -(-self.settings.samples // self.settings.frames)


@dataclass(frozen=True)
class Found:
    """What one pass of searching found.

    hit: (n, rays) int32 pixels of the full screen that the rays of each point met, −1 for none; empty for a scan.
    rest: (n, levels, 3) float32 mean radiance of what was found elsewhere, of each bounce; of a scan, of all that the
        screen does not show. missed: (n,) float32, the share of rays that met nothing on the screen.
    """

    search: Search
    number: int
    hit: np.ndarray
    rest: np.ndarray
    missed: np.ndarray

    @property
    def first_hit(self) -> np.ndarray:
        """Where each point's first ray hit the screen: (n, 3) float32, x, y and depth [m], −1 for a miss or a scan."""
        full = self.search.full
        hit = self.hit[:, 0] if self.hit.shape[1] else np.full(len(self.hit), -1)
        row, column = np.divmod(hit, full.screen.shape[1])
        at = np.stack([column, row, full.depth.ravel()[hit]], -1)
        return np.where(hit[:, None] >= 0, at, -1).astype(np.float32)

    def radiance(self, picture: np.ndarray, level: int) -> Iterator[float]:
        """Mean radiance that arrives where surfaces send what a picture (H · W, 3) shows.

        A generator of progress; returns (h · w, 3) float32 at the resolution of tracing.
        """
        search, points = self.search, self.search.points
        out = np.zeros((search.buffer.depth.size, 3), np.float32)
        picture = clamped(picture, search.settings.clamp)

        def look(part: slice):
            value = self.rest[part, level].copy()
            for hit in self.hit[part].T:
                value += np.where(hit[:, None] >= 0, picture[hit], 0) / np.float32(search.rays)
            out[points.place[part]] = value

        def scan(part: slice):
            value = np.zeros((part.stop - part.start, 3), np.float32)
            for ray in range(search.rays):
                arrived, open_share = _scanned(search, part, picture, self.number, ray)
                value += arrived + open_share[:, None] * self.rest[part, level]
                self.missed[part] += open_share / search.rays
            out[points.place[part]] = value / search.rays

        self.missed[...] = 0 if search.scans else self.missed
        yield from tiles.run(scan if search.scans else look, tiles.slices(len(points), _RAYS))
        return out


def searched(search: Search, valid: np.ndarray, number: int) -> Iterator[float]:
    """One pass of searching. A generator of progress; returns Found.

    valid: (H · W,) bool, pixels of the full screen whose light is known. number: of the pass.
    """
    points, settings, rays = search.points, search.settings, search.rays
    hit = np.full((len(points), 0 if search.scans else rays), -1, np.int32)
    rest, missed = np.zeros((len(points), search.levels, 3), np.float32), np.zeros(len(points), np.float32)
    # Made before several threads ask for them.
    if settings.mode != "ray_traced":
        _ = search.local if search.scans else search.depth

    def tile(part: slice):
        n = part.stop - part.start
        here = points[part][np.repeat(np.arange(n), rays)]
        direction = cosine_hemisphere(here.normal, _drawn(points.place[part], number * rays, rays, settings.seed))
        rows = np.flatnonzero(dot(direction, here.face) > 0)
        if not (search.scans or settings.mode == "ray_traced"):
            found = _marched(search, search.pixels[part][rows // rays], here[rows], direction[rows])
            found[(found >= 0) & ~valid[found]] = -1
            hit[part].reshape(-1)[rows] = found
            rows = rows[found < 0]
        # A place of its own for each ray, so that what it meets draws samples of its own.
        leaving = replace(here[rows], place=here.place[rows] * rays + rows % rays)
        elsewhere = np.zeros((n * rays, search.levels, 3), np.float32)
        elsewhere[rows] = clamped(_elsewhere(search, leaving, direction[rows], number), settings.clamp)
        rest[part] = elsewhere.reshape(n, rays, -1, 3).mean(1)
        missed[part] = np.bincount(rows // rays, minlength=n) / rays

    yield from tiles.run(tile, tiles.slices(len(points), max(1, _RAYS // rays)))
    return Found(search, number, hit, rest, missed)


def clamped(radiance: np.ndarray, most: float) -> np.ndarray:
    """Colours (..., 3) darkened to where their strongest channel is no more than that; 0 leaves all as they are."""
    if not most:
        return radiance
    return radiance * np.minimum(1, most / np.maximum(radiance.max(-1, keepdims=True), np.float32(1e-20)))


def _drawn(place: np.ndarray, first: int, count: int, seed: int) -> np.ndarray:
    """Points of the unit square from each pixel's own sequence, pixel by pixel: (n,) -> (n · count, 2)."""
    return rotated(r2_sequence(count, first), place, seed).reshape(-1, 2)


def _marched(search: Search, pixel: np.ndarray, here: Surfels, direction: np.ndarray) -> np.ndarray:
    """Which pixels rays meet on the screen: (n,) int32, −1 for none."""
    full, settings, mixed = search.full, search.settings, search.settings.mode == "mixed"
    screen, depth = full.screen, search.depth
    view = screen.towards(here.position)
    row, column = np.divmod(pixel, screen.shape[1])
    z = full.depth.ravel()[pixel] * (1 - _BIAS / np.maximum(dot(here.normal, view), _LEAST_SLANT))
    start = np.stack([column + np.float32(0.5), row + np.float32(0.5), screen.device(z)], -1).astype(np.float32)
    way = screen.march(here.position, direction).astype(np.float32)
    hit, hidden = depth_march(
        start, way, depth.depth, depth.slope, depth.pyramid, depth.table, screen.device(screen.camera.clip[0]),
        screen.back(settings.thickness), settings.mixed_steps if mixed else settings.steps,
    )  # fmt: skip
    position, face = full.position.reshape(-1, 3)[hit], full.face.reshape(-1, 3)[hit]
    # A surface turned away shows the eye another side than the one that the ray meets.
    kept = (hit >= 0) & (dot(face, direction) < 0)
    if mixed:
        # Only what is certain: rays in sight all the way, and hits on the very surface that the pixel shows.
        d = position - here.position
        off = length(d - dot(d, direction)[:, None] * direction)
        slant = np.abs(dot(face, screen.towards(position)))
        kept &= ~hidden & (off * slant <= screen.footprint(np.where(hit >= 0, full.depth.ravel()[hit], 1)))
    return np.where(kept, hit, -1)


def _elsewhere(search: Search, here: Surfels, direction: np.ndarray, number: int) -> np.ndarray:
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


def _scanned(search: Search, part: slice, picture: np.ndarray, number: int, ray: int):
    """One slice of the horizon scan from each pixel of a tile; see `horizon_scan`."""
    settings, pixel = search.settings, search.pixels[part]
    place = search.points.place[part]
    index = number * search.rays + ray
    more = np.stack([hash01(place, settings.seed * 65536 + 4 * index + k) for k in (2, 3)], -1)
    u = np.concatenate([_drawn(place, index, 1, settings.seed)[:, :1], more], -1)
    (position, normal), (h, w) = search.local, search.full.screen.shape
    return horizon_scan(
        pixel, position, normal, picture.reshape(h, w, 3), u, search.full.screen.pixels_per_unit,
        search.full.screen.parallel, settings.thickness, settings.steps, float(np.hypot(h, w)),
    )  # fmt: skip
