# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: one job, run alike by the panel, the command line, scripts and tests.

    job = Job(method="rsm", target="image")
    result = finish(bake(scene, view_layer, job))

`bake` is a generator of (fraction, stage), 0…1; its value is a `Result` of plain arrays. Nothing in the file is
touched: `write` puts a result there. Closing the generator cancels the bake and leaves everything as it was.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import images, rsm, ssgi, surfels
from ..gi_core.direct import lamps, surroundings
from ..gi_core.geometry import Geometry
from ..gi_core.rsm.interpolation import interpolated_indirect
from ..gi_core.rsm.settings import RsmSettings
from ..gi_core.scene import Camera
from ..gi_core.settings import SettingError, Settings
from ..gi_core.ssgi.settings import SsgiSettings
from ..gi_core.surfels import Surfels
from ..gi_core.trace import Tracer
from . import denoise, preflight
from .read import read_scene
from .read.camera import read_cameras

METHODS = {"rsm": RsmSettings, "ssgi": SsgiSettings}
TARGETS = ("image", "lightmap", "vertices")

# Side of a lightmap where none is asked for [texels].
LIGHTMAP_SIDE = 256

# What the stages that take long take of the whole, roughly; the bar follows it.
_WEIGHTS = {
    "read": 5,
    "trees": 3,
    "points": 7,
    "lamps": 10,
    "surroundings": 10,
    "maps": 10,
    "gather": 45,
    "denoise": 10,
}


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
        if self.settings.device == "gpu":
            raise NotThere("baking on the graphics card is not there yet; use device auto or cpu")
        if self.resolution is not None and not 4 <= self.resolution <= 16384:
            raise SettingError(f"the resolution is {self.resolution}; it goes from 4 to 16384 pixels")


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
    history: ssgi.History | None = None


class Stages:
    """Seconds by stage, and how far the whole is."""

    def __init__(self):
        self.seconds: dict[str, float] = {}
        self._fraction = 0.0

    @contextmanager
    def time(self, name: str):
        """Adds what happens inside to a stage."""
        begin = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[name] = self.seconds.get(name, 0.0) + time.perf_counter() - begin

    def run(self, name: str, work: Iterator[float]) -> Iterator[tuple[float, str]]:
        """A stage's generator of 0…1 as one of (fraction of all, stage); returns its value."""
        before = sum(_WEIGHTS[s] for s in self.seconds if s in _WEIGHTS) / sum(_WEIGHTS.values())
        share = _WEIGHTS[name] / sum(_WEIGHTS.values())
        with self.time(name):
            while True:
                try:
                    self._fraction = max(self._fraction, before + share * next(work))
                    yield self._fraction, name
                except StopIteration as stop:
                    return stop.value


def bake(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    job: Job,
    output: Path | None = None,
    history: ssgi.History | None = None,
) -> Iterator[tuple[float, str]]:
    """The light of a scene at its current frame. A generator of (fraction, stage); returns a Result.

    output: the folder that files will go to, to be looked at before the work and not after it. history: of the frame
        before, of the same job.

    Raises Refused, before any work, where the preflight finds errors.
    """
    stages = Stages()
    yield 0.0, "check"
    with stages.time("check"):
        findings = preflight.check(
            scene, view_layer,
            target=job.target, objects=job.objects, uv=job.uv, output=output, denoise=job.settings.denoise,
        )  # fmt: skip
    if any(f.severity == "ERROR" for f in findings):
        raise Refused(findings)

    yield 0.0, "read"
    with stages.time("read"):
        core = read_scene(scene, view_layer)
        if job.target == "image":
            core = replace(core, camera=camera_at(core.camera, job.resolution))
        cameras = read_cameras(scene, view_layer, job.cameras)
    if job.method == "ssgi" and not (cameras or core.camera):
        raise Refused([preflight.no_camera(scene)])
    with stages.time("trees"):
        tracer = Tracer(Geometry(core))
    receivers = yield from stages.run("points", _receivers(tracer, job))

    settings = _per_point(job)
    points = Surfels.concatenate([r.points for r in receivers])
    direct_light = yield from stages.run("lamps", lamps(tracer, points, settings.light_samples, settings.seed))
    around = yield from stages.run("surroundings", surroundings(tracer, points, settings.samples, settings.seed))
    views, coverage = [], None
    if job.method == "ssgi":
        views = yield from stages.run("maps", ssgi.emit(tracer, points, job.settings, cameras, history))
        indirect_light, coverage = yield from stages.run("gather", ssgi.seen(views, points))
        notes = []
    else:
        lighting = yield from stages.run("maps", rsm.emit(tracer, points, settings))
        gathering = _gathered(tracer, points, lighting, settings, job)
        indirect_light, notes = yield from stages.run("gather", gathering)
    if settings.denoise != "none":
        # Screen-space GI has a filter of its own.
        filtered = job.method == "ssgi" and settings.denoise == "bilateral"
        noisy = around if filtered else np.concatenate([around, indirect_light], -1)
        clean = yield from stages.run("denoise", _denoised(receivers, noisy, settings, tracer))
        around, indirect_light = clean[:, :3], indirect_light if filtered else clean[:, 3:]
    direct_light += around

    with stages.time("layers"):
        lit = list(zip(receivers, _split(receivers, direct_light), _split(receivers, indirect_light)))
        layers, light = {}, {}
        if job.target == "image":
            [(receiver, there, here)] = lit
            camera = camera_at(core.camera, job.resolution)
            transparent = scene.render.film_transparent
            layers = images.camera_layers(
                receiver.points, there, here, camera, core.environment, settings.antialias, transparent
            )
            layers |= {f"SSGI {name}": image for view in views for name, image in view.debug(camera.resolution).items()}
        else:
            shares = [None] * len(lit) if coverage is None else _split(receivers, coverage)
            light = {r.name: r.light(there, here, share) for (r, there, here), share in zip(lit, shares)}
    warnings = (*(f"{f.code}: {f.message}" for f in findings), *notes)
    carried = views[0].history if views else None
    return Result(job, layers, light, "cpu", stages.seconds, core.approximated, warnings, carried)


@dataclass(frozen=True)
class _Receiver:
    """The points of an image, a lightmap or a mesh's vertices.

    shape: (h, w) or (v,) of what they are places in. subpixels: of a pixel along each axis.
    """

    name: str
    points: Surfels
    shape: tuple[int, ...]
    centred: np.ndarray
    subpixels: int = 1

    def light(self, direct_light: np.ndarray, indirect_light: np.ndarray, coverage: np.ndarray | None) -> Light:
        count = int(np.prod(self.shape))
        values = np.zeros((2, count, 3), np.float32)
        values[:, self.points.place] = direct_light / np.pi, indirect_light / np.pi
        masks = np.zeros((2, count), bool)
        masks[0, self.points.place], masks[1, self.points.place] = True, self.centred
        if coverage is not None:
            seen = np.zeros(count, np.float32)
            seen[self.points.place] = coverage
            coverage = seen.reshape(self.shape)
        return Light(*values.reshape(2, *self.shape, 3), *masks.reshape(2, *self.shape), coverage)


def _per_point(job: Job) -> Settings:
    """The job's settings with a pixel's samples shared out among its subpixels."""
    settings = job.settings
    if job.target != "image":
        return settings
    share = settings.antialias**2
    return replace(settings, samples=-(-settings.samples // share), light_samples=-(-settings.light_samples // share))


def _gathered(tracer: Tracer, points: Surfels, lighting: rsm.Lighting, settings: Settings, job: Job) -> Iterator[float]:
    """Reflected light at all points: a generator of progress; returns (n, 3) irradiance and sentences about it."""
    if job.target != "image" or settings.interpolation == 1:
        return (yield from rsm.indirect(tracer, points, lighting, settings)), []
    camera = camera_at(tracer.geometry.scene.camera, job.resolution)
    irradiance, share = yield from interpolated_indirect(tracer, points, lighting, settings, camera, settings.antialias)
    return irradiance, [f"interpolation: {share:.1%} of the image's points reuse their neighbours' light"]


def _receivers(tracer: Tracer, job: Job) -> Iterator[float]:
    """What gets light: a generator of progress; returns a list of _Receiver."""
    scene = tracer.geometry.scene
    if job.target == "image":
        camera, subpixels = camera_at(scene.camera, job.resolution), job.settings.antialias
        points = yield from surfels.from_camera(tracer, camera, subpixels)
        shape = (camera.resolution[1] * subpixels, camera.resolution[0] * subpixels)
        return [_Receiver("", points, shape, np.ones(len(points), bool), subpixels)]

    receivers = []
    names = job.objects or tuple(i.name for i in scene.instances if not i.is_copy)
    side = job.resolution or LIGHTMAP_SIDE
    for k, name in enumerate(names):
        if job.target == "lightmap":
            points, centred = surfels.from_texels(tracer.geometry, name, job.uv, (side, side))
            shape = (side, side)
        else:
            points = surfels.from_vertices(tracer.geometry, name)
            centred = np.ones(len(points), bool)
            shape = (len(tracer.geometry.mesh_of(name)[0].vertices),)
        receivers.append(_Receiver(name, points, shape, centred))
        yield (k + 1) / len(names)
    return receivers


def camera_at(camera: Camera, side: int | None) -> Camera:
    """The camera with its longer side at so many pixels."""
    if side is None:
        return camera
    longer = max(camera.resolution)
    return replace(camera, resolution=tuple(max(1, round(n * side / longer)) for n in camera.resolution))


def _split(receivers: list[_Receiver], values: np.ndarray) -> list[np.ndarray]:
    """Values of all points, by receiver."""
    return np.split(values, np.cumsum([len(r.points) for r in receivers])[:-1])


def _denoised(
    receivers: list[_Receiver], irradiance: np.ndarray, settings: Settings, tracer: Tracer
) -> Iterator[float]:
    """Irradiance smoothed in those receivers that are images: (n, c). A generator of progress; returns the values."""
    parts = _split(receivers, irradiance)
    for k, receiver in enumerate(receivers):
        if len(receiver.shape) != 2:
            continue
        points, resolution = receiver.points, receiver.shape[::-1]
        # A lightmap goes on under walls; what a camera sees does not.
        walls = tracer if receiver.name else None
        if settings.denoise == "oidn":
            parts[k] = yield from denoise.smoothed(parts[k], points, resolution, receiver.subpixels)
        else:
            parts[k] = yield from images.smoothed(parts[k], points, resolution, settings.denoise_passes, walls)
    return np.concatenate(parts)
