# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: one job, run alike by the panel, the command line, scripts and tests.

    job = Job(method="rsm", target="image")
    result = finish(bake(scene, view_layer, job))

`bake` is a generator of (fraction, stage), 0…1; its value is a `Result` of plain arrays. Nothing in the file is
touched: `write` puts a result there. Closing the generator cancels the bake and leaves everything as it was.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import images, lpv, ssgi
from ..gi_core.geometry import Geometry
from ..gi_core.receivers import POINT_BYTES, Receiver, Tile, cut, guides, of_camera, of_texels, of_vertices
from ..gi_core.refine import Estimate
from ..gi_core.rsm.settings import RsmSettings
from ..gi_core.scene import Camera
from ..gi_core.settings import SettingError, Settings
from ..gi_core.techniques import METHODS, Asked
from ..gi_core.tile_light import TileLight
from ..gi_core.tiles import finish, named
from ..gi_core.trace import Tracer
from . import denoise, preflight
from .read import with_bakes
from .read.box import box_corners
from .read.camera import read_cameras
from .read.images import ImageReader
from .read.surface_bakes import SurfaceBakes
from .stages import Stages

TARGETS = ("image", "lightmap", "vertices", "volume")

# Side of a lightmap where none is asked for [texels].
LIGHTMAP_SIDE = 256

# What maps and tiles take of the whole, roughly; the bar follows it.
_MAPS, _TILES = 0.1, 0.9

# Points that stand for all that get light where lights are chosen.
_GUIDES = 1 << 14


class NotThere(ValueError):
    """What was asked for is not part of this version."""


class Refused(Exception):
    """The preflight found what would make the bake fail. findings: what it found."""

    def __init__(self, findings: list[preflight.Finding]):
        super().__init__("; ".join(f"{f.code}: {f.message}" for f in findings if f.severity == "ERROR"))
        self.findings = findings


@dataclass(frozen=True)
class Job:
    """What to bake.

    method: a technique, see METHODS. target: see TARGETS.
    objects: names of the objects that get lightmaps or vertex light; empty means every mesh that renders.
    resolution: side of each lightmap, or the longer side of the camera image [px]; None means LIGHTMAP_SIDE, or the
        scene's own.
    uv: name of the UV map that lightmaps lie on; "" means each mesh's active one.
    settings: of the technique.
    """

    method: str = "rsm"
    target: str = "image"
    objects: tuple[str, ...] = ()
    resolution: int | None = None
    uv: str = ""
    settings: Settings = field(default_factory=RsmSettings)

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras whose pictures light the target, empty for the scene's."""
        names = getattr(self.settings, "cameras", "") if self.target != "image" else ""
        return tuple(name for text in names.split(",") if (name := text.strip()))

    def __post_init__(self):
        if self.method not in METHODS:
            raise NotThere(f"the method '{self.method}' is not there yet; there is {', '.join(METHODS)}")
        if self.target not in TARGETS:
            raise NotThere(f"the target '{self.target}' is not there yet; there are {', '.join(TARGETS)}")
        if self.target == "volume" and self.method != "lpv":
            raise NotThere("only the method 'lpv' makes a volume: add --method lpv")
        if self.settings.device == "gpu":
            raise NotThere("baking on the graphics card is not there yet; use device auto or cpu")
        if self.resolution is not None and not 4 <= self.resolution <= 16384:
            raise SettingError(f"the resolution is {self.resolution}; it goes from 4 to 16384 pixels")
        if self.settings.glossy and self.target != "image":
            raise SettingError(
                f"setting 'glossy' is for the camera image: what glossy surfaces reflect depends on the view, and the "
                f"target '{self.target}' holds one light for all views"
            )

    def wants(self, light: str) -> bool:
        """Whether "direct" or "indirect" light is asked for; a camera image shows both."""
        return self.target == "image" or self.settings.light in (light, "combined")


@dataclass(frozen=True)
class Light:
    """Light on one receiver, E/π, "light without colour" as Cycles' passes and bakes hold it.

    direct, indirect: (h, w, 3) float32 of a lightmap, or (v, 3) of vertices.
    valid: (h, w) or (v,) bool, where a surface is.
    centred: bool, same shape: the surface covers the texel's centre, not only a part of it.
    coverage: float32, same shape, 0…1: how surely a camera saw it; None where no camera is asked.
    """

    direct: np.ndarray
    indirect: np.ndarray
    valid: np.ndarray
    centred: np.ndarray
    coverage: np.ndarray | None = None


@dataclass(frozen=True)
class Result:
    """What a bake gives.

    layers: pass name -> (h, w, c) float32 of the camera image, else empty.
    light: object name -> Light of lightmaps or vertices, else empty.
    volume: the reflected light everywhere, of the target "volume".
    device: what computed. stages: name -> seconds, in order.
    approximated, warnings: sentences. history: what the next frame of an animation may go on from.
    """

    job: Job
    layers: dict[str, np.ndarray]
    light: dict[str, Light]
    device: str
    stages: dict[str, float]
    approximated: tuple[str, ...]
    warnings: tuple[str, ...]
    volume: lpv.Volume | None = None
    history: ssgi.History | None = None


# Shown a receiver's name ("" for the camera), some of its rows and their light so far, E/π (rows, w, 3) float32.
Preview = Callable[[str, slice, np.ndarray], None]


def bake(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    job: Job,
    output: Path | None = None,
    preview: Preview | None = None,
    history: ssgi.History | None = None,
) -> Iterator[tuple[float, str]]:
    """The light of a scene at its current frame. A generator of (fraction, stage); returns a Result.

    output: the folder that files will go to, to be looked at before the work and not after it. preview: is shown what
    there is after each pass, noisy as it is. history: of the frame before, of the same job.

    Raises Refused, before any work, where the preflight finds errors.
    """
    stages, bakes = Stages(), SurfaceBakes()
    yield 0.0, "read"
    with stages.time("read"):
        findings, core = preflight.inspected(
            scene, view_layer, ImageReader(),
            target=job.target, objects=job.objects, uv=job.uv, output=output, denoise=job.settings.denoise,
            glossy=job.settings.glossy, bakes=bakes,
        )  # fmt: skip
    if any(f.severity == "ERROR" for f in findings):
        raise Refused(findings)
    if bakes.patches:
        work = named("materials", with_bakes(core, scene, view_layer, bakes))
        core = yield from stages.follow(work, 0, 0, {})
    with stages.time("read"):
        cameras = read_cameras(scene, view_layer, job.cameras) or [core.camera]
    if job.method == "ssgi" and cameras == [None]:
        raise Refused([preflight.no_camera(scene)])
    with stages.time("trees"):
        tracer = Tracer(Geometry(core))

    if getattr(job.settings, "box", ""):
        job = replace(job, settings=replace(job.settings, box=box_corners(job.settings.box, scene)))
    settings, technique = _per_point(job), METHODS[job.method]
    if job.target == "volume":
        work = named("maps", technique.emit(tracer, Asked(None), settings))
        volume = yield from stages.follow(work, 0, 1, {"maps": 1.0})
        notes = tuple(f"{f.code}: {f.message}" for f in findings)
        return Result(job, {}, {}, "cpu", stages.seconds, core.approximated, notes, volume)

    camera = camera_at(core.camera, job.resolution) if job.target == "image" else None
    receivers = _receivers(tracer, job, camera)
    emitted = None
    if job.wants("indirect"):
        spread = guides(tracer, [r.name for r in receivers], camera, _GUIDES)
        asked = Asked(spread, [camera] if camera else cameras, history)
        work = named("maps", technique.emit(tracer, asked, job.settings))
        emitted = yield from stages.follow(work, 0, _MAPS, {"maps": 1.0})

    margin, unit = _margin(settings, camera)
    cutting = cut(receivers, (settings.memory << 20) // POINT_BYTES, margin, unit)
    whole, done = sum(np.prod(tile.shape) for tile in cutting), 0.0
    canvases: dict[str, dict[str, np.ndarray]] = {receiver.name: {} for receiver in receivers}
    names, reused, estimates = _kept_layers(settings, camera), [], []
    for tile in cutting:
        share = float(np.prod(tile.shape) / whole)
        light = TileLight(tracer, technique, settings, emitted, job.wants("direct"), camera, share, reused)
        seen = _shown(preview, tile) if preview else None
        work = light.on(tile, seen)
        found, estimate = yield from stages.follow(work, _MAPS + _TILES * done, _TILES * share, light.stages)
        done += share
        estimates.append(estimate)
        for receiver, rows, kept in tile.kept():
            _put(canvases[receiver.name], found, names, receiver, rows, kept)
    if settings.denoise == "oidn" and job.target != "vertices":
        yield from stages.follow(named("denoise", _oidn(canvases, technique.noisy(settings))), 1, 0, {})

    views = emitted if job.method == "ssgi" and emitted else []
    with stages.time("layers"):
        for canvas in canvases.values():
            for kind in ("", "Glossy ") if job.settings.glossy else ("",):
                canvas[f"{kind}Direct"] = canvas.pop(f"{kind}Lamps") + canvas.pop(f"{kind}Around")
        layers, light = {}, {}
        if camera:
            layers = images.camera_layers(canvases[""], camera, scene.render.film_transparent)
            layers |= {f"SSGI {k}": v for view in views for k, v in view.debug(camera.resolution).items()}
        else:
            light = {r.name: _light(canvases[r.name], r.shape, _coverage(r, views)) for r in receivers}
    warnings = [f"{f.code}: {f.message}" for f in findings] + _notes(settings, reused, estimates)
    carried = views[0].history if views else None
    return Result(job, layers, light, "cpu", stages.seconds, core.approximated, tuple(warnings), history=carried)


def _per_point(job: Job) -> Settings:
    """The job's settings with a pixel's samples shared out among its subpixels."""
    settings = job.settings
    if job.target != "image":
        return settings
    share = settings.antialias**2
    return replace(
        settings,
        samples=-(-settings.samples // share),
        light_samples=-(-settings.light_samples // share),
        # Of a subpixel, whose pixel is the mean of all.
        noise_threshold=min(1.0, settings.noise_threshold * share),
    )


def _receivers(tracer: Tracer, job: Job, camera: Camera | None) -> list[Receiver]:
    """What gets light."""
    if camera:
        return [of_camera(tracer, camera, job.settings.antialias)]
    names = job.objects or tuple(i.name for i in tracer.geometry.scene.instances if not i.is_copy)
    if job.target == "lightmap":
        side = job.resolution or LIGHTMAP_SIDE
        return [of_texels(tracer.geometry, name, job.uv, side) for name in names]
    return [of_vertices(tracer.geometry, name) for name in names]


def camera_at(camera: Camera, side: int | None) -> Camera:
    """The camera with its longer side at so many pixels."""
    if side is None:
        return camera
    longer = max(camera.resolution)
    return replace(camera, resolution=tuple(max(1, round(n * side / longer)) for n in camera.resolution))


def _margin(settings: Settings, camera: Camera | None) -> tuple[int, int]:
    """Rows beyond its own that a tile works out, so that filters find their neighbours, and rows that stay together."""
    subpixels = settings.antialias if camera else 1
    cell = getattr(settings, "interpolation", 1) * subpixels if camera else 1
    margin = images.reach(settings.denoise_passes) if settings.denoise == "bilateral" else 0
    margin += cell if cell > subpixels else 0
    return -(-margin // cell) * cell, cell


def _shown(preview: Preview, tile: Tile) -> Callable[[dict[str, np.ndarray]], None]:
    """Hands a tile's layers on to a preview, receiver by receiver."""

    def show(layers: dict[str, np.ndarray]):
        light = (layers["Lamps"] + layers["Around"] + layers["Indirect"]) / np.float32(np.pi)
        for receiver, rows, kept in tile.kept():
            preview(receiver.name, _pixels(kept, receiver), light[_pixels(rows, receiver)])

    return show


def _pixels(rows: slice, receiver: Receiver) -> slice:
    """Rows of subpixels as rows of pixels."""
    return slice(rows.start // receiver.subpixels, rows.stop // receiver.subpixels)


def _kept_layers(settings: Settings, camera: Camera | None) -> set[str]:
    """Layers that the result or the denoiser needs: a hundred large lightmaps have no memory to give away."""
    light = {"Lamps", "Around", "Indirect", "Coverage", "Centred"}
    guides = {"Color", "Normal", "Position"} if camera or settings.denoise == "oidn" else set()
    gloss = {"Glossy Lamps", "Glossy Around", "Glossy Indirect", "Glossy Color"} if settings.glossy else set()
    return light | guides | gloss | ({"Emission", "Sky"} if camera else set())


def _put(
    canvas: dict[str, np.ndarray], found: dict[str, np.ndarray], names: set[str], receiver: Receiver, rows, kept
):
    """Copies the rows of a tile that are kept to the receiver's rows that they are."""
    height = receiver.height // receiver.subpixels
    for name in names:
        layer = found[name]
        if name not in canvas:
            canvas[name] = np.zeros((height, *layer.shape[1:]), layer.dtype)
        canvas[name][_pixels(kept, receiver)] = layer[_pixels(rows, receiver)]


def _oidn(canvases: dict[str, dict[str, np.ndarray]], noisy: bool) -> Iterator[float]:
    """Takes the noise out of all images; noisy: out of reflected light too. A generator of progress."""
    found = list(canvases.values())
    kinds = ["Around", *(["Indirect"] if noisy else []), "Glossy Around", "Glossy Indirect"]
    kinds = [kind for kind in kinds if any(kind in canvas for canvas in found)]
    clean = yield from denoise.smoothed([np.concatenate([c[k] for k in kinds], -1) for c in found], found)
    for canvas, light in zip(found, clean):
        for kind, part in zip(kinds, np.split(light, len(kinds), axis=-1)):
            valid = canvas["Glossy Color" if kind.startswith("Glossy") else "Coverage"].any(-1, keepdims=True)
            canvas[kind] = np.where(valid, part, 0)


def _coverage(receiver: Receiver, views: list[ssgi.View]) -> np.ndarray | None:
    """How surely cameras saw a receiver's places, 0…1, in its shape; None without cameras."""
    if not views:
        return None
    points, _ = receiver.points(slice(0, receiver.height))
    _, coverage = finish(ssgi.seen(views, points))
    return images.spread(coverage[:, None], points.place, (receiver.height, receiver.width)).reshape(receiver.shape)


def _light(canvas: dict[str, np.ndarray], shape: tuple[int, ...], coverage: np.ndarray | None) -> Light:
    direct, indirect = (canvas[name].reshape(*shape, 3) / np.float32(np.pi) for name in ("Direct", "Indirect"))
    return Light(direct, indirect, canvas["Coverage"].reshape(shape) > 0, canvas["Centred"].reshape(shape), coverage)


def _notes(settings: Settings, reused: list[tuple[float, int]], estimates: list[Estimate]) -> list[str]:
    """Sentences on how the light was found."""
    notes = []
    if reused:
        share = sum(n for n, _ in reused) / max(1, sum(n for _, n in reused))
        notes.append(f"interpolation: {share:.1%} of the image's points reuse their neighbours' light")
    if settings.noise_threshold or settings.time_limit:
        samples = min(estimate.samples for estimate in estimates)
        noise = max(estimate.noise for estimate in estimates)
        notes.append(f"refinement: {samples} samples for each point, relMSE {noise:.2g} by the spread of passes")
    return notes
