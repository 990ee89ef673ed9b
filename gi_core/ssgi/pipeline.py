# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes in their order: trace, reproject, temporal filter, diffuse filter, both again."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from .. import images, tiles
from ..device import Device
from ..kernels.diffuse_filter import diffuse_filter
from ..kernels.reflected import reflected
from ..kernels.reproject import reproject
from ..kernels.spread import spread
from ..kernels.temporal import history_taps, temporal
from ..sampling import r2_sequence
from ..scene import Camera
from ..trace import Tracer
from ..vectors import length
from .frame import METRE, GBuffer, before, direct_light, g_buffer, slant
from .probes import Probes, bake_probes, propagated
from .screen import Screen
from .search import Search, searched
from .settings import SsgiSettings
from .sure import sure_pixels
from .view import History, View, between, looked_up

# Pixels worked on at once by a thread: arrays that stay within a core's cache.
_PIXELS = 1 << 14

# Relative linear depth up to which the previous picture shows the same; the source's 0.1 is of raw device depth.
_DEPTH = 0.1

# How far apart a point and what the history shows may be, in the source's metres.
_HISTORY_LIMIT = np.float32(0.1)

# What moves less from picture to picture, as a share of its distance, stands still.
_STILL = np.float32(1e-5)

# Points of the diffuse filter's disk, at full and at half resolution, out of a set of so many.
_TAPS, _HALF_TAPS, _DISK = 16, 4, 64


@dataclass(frozen=True)
class Inputs:
    """What all passes over one picture share: what is seen, at full resolution and at that of tracing, direct light
    (H, W, 3) [W/m²], and the search for what is not direct. What is worked out of these lies where kernels run."""

    full: GBuffer
    buffer: GBuffer
    direct: np.ndarray
    search: Search

    @property
    def device(self) -> Device:
        return self.search.device

    @cached_property
    def here(self) -> GBuffer:
        """The buffer at the resolution of tracing."""
        return self.search.seen if self.buffer is self.full else self.buffer.on(self.device)

    @cached_property
    def sent(self) -> np.ndarray:
        """What surfaces send of direct light: (H, W, 3) mean radiance."""
        return self.full.albedo * self.direct / np.float32(np.pi)

    @cached_property
    def lit(self) -> np.ndarray:
        """The same where kernels run."""
        return self.device.array(self.sent, 3)

    @cached_property
    def known(self) -> np.ndarray:
        """The pixels whose light may be taken: (H · W,) int32, −1 for those that mixed is not sure of."""
        every = np.arange(self.full.depth.size, dtype=np.int32)
        if self.search.settings.mode != "mixed":
            return every
        return np.where(sure_pixels(self.full, self.sent).ravel(), every, np.int32(-1))

    @cached_property
    def valid(self) -> np.ndarray | None:
        """Whether it may be taken, where kernels run: (H · W,) bool; None for all."""
        return self.device.array(self.known >= 0, 1) if self.search.settings.mode == "mixed" else None

    @cached_property
    def own(self) -> tuple[np.ndarray, np.ndarray]:
        """Each pixel as its own history, as `history_taps` gives it."""
        n = self.buffer.depth.size
        weights = np.zeros((n, 4), np.float32)
        weights[:, 0] = self.buffer.surface.ravel()
        taps = np.repeat(np.arange(n, dtype=np.int32)[:, None], 4, 1)
        return self.device.array(taps, 4), self.device.array(weights, 4)

    @cached_property
    def filtering(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, tuple[np.ndarray, np.ndarray]]:
        """Where the diffuse filter works: which pixels of the buffer, (n,); which of them each pixel of its image is,
        (h, w), −1 for none; what a metre of the source is there, (n,) [m]; and its radius, in its first and in its
        second run, (n,) each [m]."""
        every = np.arange(self.buffer.depth.size, dtype=np.int32).reshape(self.buffer.depth.shape)
        every = every[:: self.step, :: self.step]
        there = self.buffer.surface.ravel()[every]
        places, row = every[there], np.full(every.shape, -1, np.int32)
        row[there] = np.arange(len(places))
        z, radius = self.buffer.depth.ravel()[places], self.search.settings.radius
        least, share = 2 * self.buffer.screen.footprint(z), z / (5 + 45 * np.minimum(z / 500, 1))
        both = (np.maximum(share * r, least).astype(np.float32) for r in (radius, radius / 2))
        place, row, metre, *radii = (self.device.array(a, 1) for a in (places, row, METRE * z, *both))
        return place, row, metre, tuple(radii)

    @property
    def step(self) -> int:
        """Pixels of the buffer to one that is filtered, along each axis."""
        return 2 if self.search.settings.half_filter and self.buffer is self.full else 1

    @cached_property
    def coarse(self) -> GBuffer:
        """Every other pixel of every other row, from which others get their light."""
        return self.full[2].on(self.device) if self.buffer is self.full else self.here

    @cached_property
    def between(self) -> tuple[tuple[np.ndarray, ...], np.ndarray]:
        """The full screen's points between the coarse pixels, and which of them each pixel is."""
        points = self.full.surfels()
        row = np.full(self.full.depth.shape, -1, np.int32)
        row.ravel()[points.place] = np.arange(len(points))
        found = zip(between(self.coarse, points.position, points.normal), (2, 1, 3, 3, 1), (-1e30, *[None] * 4))
        return tuple(self.device.array(*one) for one in found), self.device.array(row, 1)


def still(
    tracer: Tracer,
    camera: Camera,
    settings: SsgiSettings,
    probes: Probes | None = None,
    history: History | None = None,
    shown: Callable[[np.ndarray], None] | None = None,
) -> Iterator[float]:
    """`settings.frames` passes over a camera's picture.

    probes: what stands in where the screen shows nothing; None bakes some where the settings want them.
    history: of an earlier picture, to go on from. shown: is given the light so far after each pass, direct light with
        it, (H, W, 3) E/π.
    A generator of progress; returns a View.
    """
    settings = settings.preset
    if probes is None and settings.wants_probes:
        work = propagated if settings.probes == "lpv" else bake_probes
        probes = yield from tiles.within(0.0, 0.1, work(tracer, settings))
    full = yield from tiles.within(0.1, 0.12, g_buffer(tracer, Screen(camera)))
    buffer = _traced(full, settings)
    if settings.mode == "off":
        return View(buffer, np.zeros((*buffer.depth.shape, 3), np.float32), {}, None)
    work = direct_light(
        tracer, full, settings.light_samples, settings.samples, settings.seed, settings.shadow_map_resolution
    )
    direct = yield from tiles.within(0.12, 0.2, work)
    inputs = Inputs(full, buffer, direct, Search(tracer, full, buffer, settings, probes))
    each = settings.feedback == "previous" or settings.accumulation == "hdrp"
    for k in range(settings.frames):
        begin, end = (0.2 + 0.8 * (k + i) / settings.frames for i in (0, 1))
        # An earlier picture's filtered light is to be found while it is known where its points went.
        whole = each or k == settings.frames - 1 or (k == 0 and history is not None)
        radiance, history, layers = yield from tiles.within(begin, end, one_pass(inputs, history, settings, whole))
        if shown:
            (h, w), step = full.depth.shape, 1 if settings.full_resolution else 2
            indirect = tracer.device.numpy(radiance).repeat(step, 0).repeat(step, 1)
            shown(indirect[:h, :w] + direct / np.float32(np.pi))
    device = tracer.device
    layers = {name: device.numpy(layer) for name, layer in layers.items()}
    return View(buffer, device.numpy(radiance), layers, history.of(device))


def restored(
    tracer: Tracer, camera: Camera, settings: SsgiSettings, arrays: Mapping[str, np.ndarray]
) -> Iterator[float]:
    """A History from its `arrays`, in the scene and by the camera that it is of. A generator of progress."""
    full = yield from g_buffer(tracer, Screen(camera))
    return History(
        _traced(full, settings.preset), tuple(arrays["levels"]), arrays["filtered"], arrays["count"],
        arrays["picture"], full, int(arrays["passes"]),
    )  # fmt: skip


def _traced(full: GBuffer, settings: SsgiSettings) -> GBuffer:
    """The pixels that rays leave from."""
    return full[1 if settings.full_resolution else 2]


def one_pass(inputs: Inputs, history: History | None, settings: SsgiSettings, whole: bool = True) -> Iterator[float]:
    """All passes over a picture once. A generator of progress.

    whole: with the filters; without, the pass only adds to the mean, and the next one's filters stand for its too.
    Returns (h, w, 3) float32 mean radiance E/π at the resolution of tracing, the History, and, where that is asked for,
    what each pass found: name -> (h, w) or (h, w, 3). Images are left where kernels run.
    """
    full, buffer, number = inputs.full, inputs.buffer, history.passes if history else 0
    device, search, albedo = inputs.device, inputs.search, inputs.search.seen.albedo
    lit, valid = inputs.lit, inputs.valid
    if settings.feedback == "previous" and history is not None:
        at, _ = before(full, history.full)
        lit, valid = device.run(reproject, inputs.known, at, history.picture, history.full.depth, _DEPTH)
        lit = lit.reshape(*full.depth.shape, 3)

    found = yield from tiles.within(0.0, 0.6, searched(search, valid, number))
    taps = yield from tiles.within(0.6, 0.62, _history(inputs, history))
    levels = []
    source = lit
    for k in range(search.levels):
        raw, missed = yield from tiles.within(0.62, 0.7, found.radiance(source, k))
        mean, count = yield from _mixed(raw, history.levels[k] if history else None, history, taps, inputs, settings)
        levels.append(mean)
        if k + 1 < search.levels:
            again = yield from _upsampled(inputs, mean)
            source = device.run(reflected, lit, albedo, again)
    if not whole:
        behind = history.behind + 1 if history else 1
        earlier, picture = (history.filtered, history.picture) if history else (mean, None)
        return mean, History(buffer, tuple(levels), earlier, count, picture, full, number + 1, behind), {}
    layers = {}
    if settings.debug:
        place, shape = search.places, buffer.depth.shape
        layers = {"Traced": raw, "Accumulated": mean, "Passes": count, "Face": full.face}
        layers |= {"Lit": lit, "Motion": _motion(full, history)}
        if settings.mode == "mixed":
            layers["Sure"] = (inputs.known >= 0).reshape(full.depth.shape)
        layers["Missed"] = images.spread(device.numpy(missed)[:, None], place, shape)[..., 0]
        layers["Hit"] = images.spread(found.first_hit, place, shape)

    filtered, result = mean, mean
    if settings.smooths:
        behind = history.behind if history else 0
        numbers = range(number - behind, number + 1)
        smooth = yield from tiles.within(0.7, 0.85, _filtered(inputs, mean, settings, numbers))
        earlier = history.filtered if history else None
        filtered, _ = yield from _mixed(smooth, earlier, history, taps, inputs, settings, behind)
        if settings.debug:
            layers |= {"Filtered": smooth, "Accumulated again": filtered}
        result = filtered
        if settings.second_pass:
            work = _filtered(inputs, filtered, settings, None)
            result = yield from tiles.within(0.85, 1.0, work)
    all_over = yield from _upsampled(inputs, result)
    picture = device.run(reflected, inputs.lit, albedo, all_over)
    history = History(buffer, tuple(levels), filtered, count, picture, full, number + 1)
    return result, history, layers


def _upsampled(inputs: Inputs, value: np.ndarray) -> Iterator[float]:
    """An image at the coarse pixels or at all, (h, w, 3), at every pixel: (H, W, 3). A generator of progress."""
    if value.shape[:2] == inputs.full.depth.shape:
        return value
    (points, row), coarse = inputs.between, inputs.coarse

    def tile(part: slice):
        return looked_up(coarse, value, tuple(one[part] for one in points), inputs.device)[0]

    found = yield from inputs.device.each(tile, len(points[0]), _PIXELS)
    return inputs.device.run(spread, found, row)


def _motion(full: GBuffer, history: History | None) -> np.ndarray:
    """Where pixels were in the earlier picture less where they are, and depth likewise: (H, W, 3), NaN for nowhere."""
    if history is None:
        return np.full(full.position.shape, np.nan, np.float32)
    rows, columns = np.indices(full.depth.shape, np.float32)
    now = np.dstack([columns, rows, np.where(full.surface, full.depth, np.nan)])
    return before(full, history.full)[0].reshape(now.shape) - now


def _history(inputs: Inputs, history: History | None) -> Iterator[float]:
    """`history_taps` of each pixel, None where there is no history. A generator of progress."""
    if history is None:
        return None
    buffer, device = inputs.buffer, inputs.device
    if history.buffer is buffer:
        return inputs.own
    at, where = before(buffer, history.buffer)
    z = np.where(buffer.surface, buffer.depth, 1).ravel()
    if inputs.search.settings.motion_rejection:
        with np.errstate(invalid="ignore"):
            at[length(where - buffer.position.reshape(-1, 3)) > _STILL * z] = np.nan
    where = np.where(np.isfinite(where), where, 0)
    at, normal, slanted = at[:, :2], buffer.normal.reshape(-1, 3), slant(buffer)
    footprint, limit, then = buffer.screen.footprint(z), _HISTORY_LIMIT * METRE * z, history.buffer

    def tile(part: slice):
        return device.run(
            history_taps, at[part], where[part], normal[part], footprint[part], slanted[part], then.position,
            then.normal, limit[part],
        )  # fmt: skip

    return (yield from device.each(tile, buffer.depth.size, _PIXELS))


def _mixed(
    raw, earlier, history: History | None, taps, inputs: Inputs, settings: SsgiSettings, skipped: int = 0
) -> Iterator[float]:
    """The temporal filter over an image: raw (h, w, 3) and the history's -> (h, w, 3) and (h, w) passes. A generator of
    progress. skipped: as for `temporal`."""
    (h, w, _), device = raw.shape, inputs.device
    if history is None:
        return raw, device.array(np.ones((h, w), np.float32), 1)
    flat, hdrp = raw.reshape(-1, 3), settings.accumulation == "hdrp"
    earlier, passes = device.array(earlier, 3), device.array(history.count, 1)

    def tile(part: slice):
        return device.run(temporal, flat[part], earlier, passes, *(a[part] for a in taps), hdrp, skipped)

    out, count = yield from device.each(tile, h * w, _PIXELS)
    return out.reshape(h, w, 3), count.reshape(h, w)


def _filtered(inputs: Inputs, value: np.ndarray, settings: SsgiSettings, numbers: range | None) -> Iterator[float]:
    """The diffuse filter over an image: (h, w, 3) -> (h, w, 3).

    numbers: of the passes that it stands for, each of which has points of its own in the first filter; None for the
        second, with the same ones each time.
    A generator of progress.
    """
    here, device, screen = inputs.here, inputs.device, inputs.buffer.screen
    taps = _TAPS if settings.full_resolution and inputs.step == 1 else _HALF_TAPS
    passes = range(1) if numbers is None else numbers[-(_DISK // taps) :]
    points = np.arange(passes.start * taps, passes.stop * taps) % _DISK
    r, turn = r2_sequence(_DISK)[points].T
    disk = r[:, None] * np.stack([np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)], -1).astype(np.float32)
    seed = None if numbers is None else settings.seed * 4096 + numbers[-1]
    place, row, metre, radii = inputs.filtering
    reach, far, literal = radii[numbers is None], np.float32(screen.camera.clip[1]), settings.weights == "literal"

    def tile(part: slice):
        return device.run(
            diffuse_filter, place[part], value, here.depth, here.position, here.normal, reach[part], disk,
            screen.matrix, far, metre[part], literal, seed,
        )  # fmt: skip

    found = device.run(spread, (yield from device.each(tile, len(place), _PIXELS)), row)
    return found if inputs.step == 1 else (yield from _upsampled(inputs, found))
