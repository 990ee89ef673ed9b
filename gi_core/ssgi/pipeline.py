# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The passes in their order: trace, reproject, temporal filter, diffuse filter, both again."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from .. import tiles
from ..images import spread
from ..kernels.diffuse_filter import diffuse_filter
from ..kernels.reproject import reproject
from ..kernels.temporal import history_taps, temporal
from ..sampling import hash01, r2_sequence
from ..scene import Camera
from ..trace import Tracer
from .frame import METRE, GBuffer, before, direct_light, g_buffer, slant
from .probes import Probes, bake_probes, propagated
from .screen import Screen
from .search import Search, searched
from .settings import SsgiSettings
from .view import History, View, upsampled

# Pixels worked on at once by a thread: arrays that stay within a core's cache.
_PIXELS = 1 << 14

# Relative linear depth up to which the previous picture shows the same; the source's 0.1 is of raw device depth.
_DEPTH = 0.1

# How far apart a point and what the history shows may be, in the source's metres.
_HISTORY_LIMIT = np.float32(0.1)

# Points of the diffuse filter's disk, at full and at half resolution, out of a set of so many.
_TAPS, _HALF_TAPS, _DISK = 16, 4, 64


@dataclass(frozen=True)
class Inputs:
    """What all passes over one picture share: what is seen, at full resolution and at that of tracing, direct light
    (H, W, 3) [W/m²], and the search for what is not direct."""

    full: GBuffer
    buffer: GBuffer
    direct: np.ndarray
    search: Search


def still(
    tracer: Tracer, camera: Camera, settings: SsgiSettings, probes: Probes | None = None, history: History | None = None
) -> Iterator[float]:
    """`settings.frames` passes over a camera's picture.

    probes: what stands in where the screen shows nothing; None bakes some where the settings want them.
    history: of an earlier picture, to go on from.
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
    direct = yield from tiles.within(
        0.12, 0.2, direct_light(tracer, full, settings.light_samples, settings.samples, settings.seed)
    )
    inputs = Inputs(full, buffer, direct, Search(tracer, full, buffer, settings, probes))
    for k in range(settings.frames):
        begin, end = (0.2 + 0.8 * (k + i) / settings.frames for i in (0, 1))
        radiance, history, layers = yield from tiles.within(begin, end, one_pass(inputs, history, settings))
    return View(buffer, radiance, layers if settings.debug else {}, history)


def restored(
    tracer: Tracer, camera: Camera, settings: SsgiSettings, arrays: Mapping[str, np.ndarray]
) -> Iterator[float]:
    """A History from its `arrays`, in the scene and by the camera that it is of. A generator of progress."""
    full = yield from g_buffer(tracer, Screen(camera))
    return History(
        _traced(full, settings), tuple(arrays["levels"]), arrays["filtered"], arrays["count"], arrays["picture"], full,
        int(arrays["passes"]),
    )  # fmt: skip


def _traced(full: GBuffer, settings: SsgiSettings) -> GBuffer:
    """The pixels that rays leave from."""
    return full[1 if settings.full_resolution else 2]


def one_pass(inputs: Inputs, history: History | None, settings: SsgiSettings) -> Iterator[float]:
    """All passes over a picture once. A generator of progress.

    Returns (h, w, 3) float32 mean radiance E/π at the resolution of tracing, the History, and what each pass found:
    name -> (h, w) or (h, w, 3).
    """
    full, buffer, number = inputs.full, inputs.buffer, history.passes if history else 0
    shape = buffer.depth.shape
    albedo = full.albedo.reshape(-1, 3)
    lit = albedo * inputs.direct.reshape(-1, 3) / np.float32(np.pi)
    valid = np.ones(len(lit), bool)
    previous = settings.feedback == "previous" and history is not None
    if previous:
        at, _ = before(full, history.full)
        lit, valid = reproject(np.arange(len(lit), dtype=np.int32), at, history.picture, history.full.depth, _DEPTH)

    found = yield from tiles.within(0.0, 0.6, searched(inputs.search, valid, number))
    taps = _history(buffer, history)
    levels = []
    source = lit
    for k in range(inputs.search.levels):
        raw = (yield from tiles.within(0.6, 0.7, found.radiance(source, k))).reshape(*shape, 3)
        mean, count = _mixed(raw, history.levels[k] if history else None, history, taps, settings)
        levels.append(mean)
        if k + 1 < inputs.search.levels:
            source = lit + albedo * upsampled(buffer, mean, full).reshape(-1, 3)
    missed = spread(found.missed[:, None], inputs.search.points.place, shape)[..., 0]
    layers = {"Traced": raw, "Missed": missed, "Accumulated": mean, "Passes": count}
    if settings.debug:
        layers |= {"Face": full.face, "Lit": lit.reshape(full.position.shape), "Motion": _motion(full, history)}
        layers |= {"Hit": spread(found.first_hit, inputs.search.points.place, shape)}

    filtered, result = mean, mean
    if settings.denoise == "bilateral":
        smooth = yield from tiles.within(0.7, 0.85, _filtered(buffer, mean, settings, number))
        filtered, _ = _mixed(smooth, history.filtered if history else None, history, taps, settings)
        layers |= {"Filtered": smooth, "Accumulated again": filtered}
        result = filtered
        if settings.second_pass:
            half = replace(settings, radius=settings.radius / 2)
            result = yield from tiles.within(0.85, 1.0, _filtered(buffer, filtered, half, None))
    present = albedo * inputs.direct.reshape(-1, 3) / np.float32(np.pi)
    picture = present + albedo * upsampled(buffer, result, full).reshape(-1, 3)
    history = History(buffer, tuple(levels), filtered, count, picture.reshape(full.position.shape), full, number + 1)
    return result, history, layers


def _motion(full: GBuffer, history: History | None) -> np.ndarray:
    """Where pixels were in the earlier picture less where they are, and depth likewise: (H, W, 3), NaN for nowhere."""
    if history is None:
        return np.full(full.position.shape, np.nan, np.float32)
    rows, columns = np.indices(full.depth.shape, np.float32)
    now = np.dstack([columns, rows, np.where(full.surface, full.depth, np.nan)])
    return before(full, history.full)[0].reshape(now.shape) - now


def _history(buffer: GBuffer, history: History | None) -> tuple[np.ndarray, np.ndarray] | None:
    """`history_taps` of each pixel, None where there is no history."""
    if history is None:
        return None
    n = buffer.depth.size
    if history.buffer is buffer:
        weights = np.zeros((n, 4), np.float32)
        weights[:, 0] = buffer.surface.ravel()
        return np.repeat(np.arange(n, dtype=np.int32)[:, None], 4, 1), weights
    at, where = before(buffer, history.buffer)
    z = np.where(buffer.surface, buffer.depth, 1).ravel()
    where = np.where(np.isfinite(where), where, 0)
    taps, weights = np.zeros((n, 4), np.int32), np.zeros((n, 4), np.float32)
    normal, slanted = buffer.normal.reshape(-1, 3), slant(buffer)
    for part in tiles.slices(n, _PIXELS):
        taps[part], weights[part] = history_taps(
            at[part, :2], where[part], normal[part], buffer.screen.footprint(z[part]), slanted[part],
            history.buffer.position, history.buffer.normal, _HISTORY_LIMIT * METRE * z[part],
        )  # fmt: skip
    return taps, weights


def _mixed(raw: np.ndarray, earlier: np.ndarray | None, history: History | None, taps, settings: SsgiSettings):
    """The temporal filter over an image: raw (h, w, 3) and the history's -> (h, w, 3) and (h, w) passes."""
    if history is None:
        return raw, np.ones(raw.shape[:2], np.float32)
    out, count = np.empty_like(raw), np.empty(raw.shape[:2], np.float32)
    flat, n, hdrp = raw.reshape(-1, 3), count.size, settings.accumulation == "hdrp"
    for part in tiles.slices(n, _PIXELS):
        chosen, weights = (a[part] for a in taps)
        out.reshape(-1, 3)[part], count.ravel()[part] = temporal(
            flat[part], earlier, history.count, chosen, weights, hdrp
        )
    return out, count


def _filtered(buffer: GBuffer, value: np.ndarray, settings: SsgiSettings, number: int | None) -> Iterator[float]:
    """The diffuse filter over an image: (h, w, 3) -> (h, w, 3).

    number: of the pass, which has points of its own; None for the same ones each time.
    A generator of progress.
    """
    screen, points = buffer.screen, np.flatnonzero(buffer.surface)
    out = np.zeros_like(value)
    taps = _TAPS if settings.full_resolution else _HALF_TAPS
    first = (number or 0) * taps % _DISK
    u = r2_sequence(_DISK)[first : first + taps]
    depth = buffer.depth.ravel()
    literal = settings.weights == "literal"

    def tile(part: slice):
        pixels = points[part].astype(np.int32)
        z = depth[pixels]
        turn = 0 if number is None else hash01(pixels, settings.seed * 4096 + number)[:, None]
        angle = 2 * np.float32(np.pi) * (u[:, 1] + turn)
        disk = u[:, :1].T[..., None] * np.stack(np.broadcast_arrays(np.cos(angle), np.sin(angle)), -1)
        radius = z * settings.radius / (5 + 45 * np.minimum(z / 500, 1))
        radius = np.maximum(radius, 2 * screen.footprint(z)).astype(np.float32)
        out.reshape(-1, 3)[pixels] = diffuse_filter(
            pixels, value, buffer.depth, buffer.position, buffer.normal, radius,
            np.broadcast_to(disk, (len(pixels), taps, 2)), screen.matrix, np.float32(screen.camera.clip[1]),
            METRE * z, literal,
        )  # fmt: skip

    yield from tiles.run(tile, tiles.slices(len(points), _PIXELS))
    return out
