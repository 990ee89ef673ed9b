# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The bake: one job, run alike by the panel, the command line, scripts and tests.

    job = Job(method="rsm", target="image")
    result = finish(bake(scene, view_layer, job))

`bake` is a generator of (fraction, stage), 0…1; its value is a `Result` of plain arrays. Nothing in the file is
touched: `write` puts a result there. Closing the generator cancels the bake and leaves everything as it was.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import images, lpv, ssgi
from ..gi_core.atlas import Page
from ..gi_core.coarse import Coarse
from ..gi_core.geometry import Geometry
from ..gi_core.receivers import POINT_BYTES, Receiver, Tile, cut, guides, of_camera, of_corners, of_page
from ..gi_core.refine import Estimate
from ..gi_core.scene import Camera, Mesh, Scene
from ..gi_core.settings import Settings
from ..gi_core.techniques import METHODS, Asked
from ..gi_core.tile_light import TileLight
from ..gi_core.tiles import named, whole
from ..gi_core.trace import Tracer
from ..gi_core.vectors import pick
from . import by_method, denoise, gpu_context, layout, lightmap_borders, preflight, rebake, vertex_light
from .canvases import kept_layers, pixels, put, without_noise
from .job import Job
from .lights import coverage_of, directional_of, light_of, radiant
from .read import with_bakes
from .read.box import box_corners
from .read.camera import reading_cameras
from .read.images import ImageReader
from .read.surface_bakes import SurfaceBakes
from .result import Light, Result
from .sentence import Sentence
from .stages import Stages
from .write import lightmap_uvs

# What maps take of the whole, which the bar follows, and light at coarse texels of the rest, roughly.
_MAPS, _COARSE = {"rsm": 0.1, "lpv": 0.7, "ssgi": 0.8}, 0.55

# Points that stand for all that get light where lights are chosen.
_GUIDES = 1 << 14

# Corners of triangles that a vertex is the mean of, at least, where a surface is closed.
_CORNERS = 3

# Stages whose steps touch Blender, which allows that on its main thread only; the others may run on any.
ON_MAIN_THREAD = frozenset({"unwrap", "read", "materials", "layout", "compositor"})

# Stages after which the scene is still asked: what is undone or removed then ends the bake.
HOLDING = frozenset({"unwrap", "overlaps", "read", "checks", "materials", "trees", "layout", "packing", "signatures"})

# What generators of (fraction, stage) are.
Steps = Iterator[tuple[float, str]]


class Refused(Exception):
    """The preflight found what would make the bake fail. findings: what it found."""

    def __init__(self, findings: list[preflight.Finding]):
        super().__init__("; ".join(f"{f.code}: {f.message}" for f in findings if f.severity == "ERROR"))
        self.findings = findings


# Shown a receiver's name ("" for the camera), some of its rows and their light so far, E/π (rows, w, 3) float32; of
# corners of triangles also where they are, (rows, 3) float32 [m].
Preview = Callable[..., None]


def bake(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    job: Job,
    output: Path | None = None,
    preview: Preview | None = None,
    history: ssgi.History | None = None,
    known: list[tuple[Scene, dict, list[str]]] | None = None,
) -> Steps:
    """The light of a scene at its current frame. A generator of (fraction, stage); returns a Result.

    output: the folder that files will go to, to be looked at before the work and not after it. preview: is shown what
    there is after each pass, noisy as it is. history: of the frame before, of the same job. known: what the first of
    a job's parts has read of the file.

    A step after a stage of ON_MAIN_THREAD belongs there, like the first one; the others may be taken on any thread.

    Raises Refused, before any work, where the preflight finds errors.
    """
    parts = by_method.parts(scene, job)
    if parts != [job]:
        run = partial(bake, scene, view_layer, output=output, preview=preview, known=[])
        return (yield from by_method.together(job, parts, run))
    stages = Stages()
    read = yield from _read(scene, view_layer, job, output, stages, [] if known is None else known)
    job, core, notes = _with_denoiser(read.job), read.core, read.notes
    camera = core.camera.at(job.resolution) if job.target == "image" else None
    with stages.time("device"):
        items = int(np.prod(camera.resolution)) if camera else 0
        spares = gpu_context.spared(job.method, items, job.settings.samples)
        device, why_not = gpu_context.device(job.settings.device, job.settings.memory << 20, spares)
    if why_not:
        notes.append(
            Sentence("NO_GPU: the graphics card was asked for; the processor computed: {why}", why=why_not)
        )
    yield 0.0, "trees"
    with stages.time("trees"):
        tracer = Tracer(Geometry(core), device)

    names, due = receiving(core, job), rebake.Due()
    if job.target == "lightmap":
        work = layout.laying_out(tracer.geometry, scene, names, job.uv, job.resolution, job.settings)
        every = yield from stages.announced(work)
        due = yield from stages.announced(rebake.due(scene, core, every, job.method, job.settings))
        if job.part_of:
            due = due.of(lambda name: by_method.method_of(scene, job, name) == job.method)
        names = tuple(place.name for page in due.pages for place in page.places)
        yield 0.0, METHODS[job.method].stage
    elif job.part_of:
        names = tuple(name for name in names if by_method.method_of(scene, job, name) == job.method)
    receivers = _receivers(tracer, job, camera, names, due.pages)

    emitted, maps = None, 0.0
    if job.target == "volume" or (job.wants("indirect") and receivers):
        spread = None if job.target == "volume" else guides(tracer, names, camera, _GUIDES)
        shown = partial(preview, "", slice(0, camera.resolution[1])) if preview and camera else None
        asked = Asked(spread, [camera] if camera else read.cameras, history, shown)
        technique, maps = METHODS[job.method], _MAPS[job.method]
        work = named(technique.stage, technique.emit(tracer, asked, job.settings))
        emitted = yield from stages.follow(work, 0, maps if receivers else 1, {technique.stage: 1.0})
    volume = emitted if isinstance(emitted, lpv.Volume) else None
    views = emitted if job.method == "ssgi" and emitted else []

    coarse, done = None, maps
    step = getattr(job.settings, "interpolation", 1)
    if step > 1 and job.target == "lightmap" and emitted is not None:
        done = maps + _COARSE * (1 - maps)
        # The filter reaches as far over the surface: each pass doubles its reach, as each step does a texel.
        passes = max(1, job.settings.denoise_passes - int(math.log2(step)))
        alone = replace(job, settings=replace(job.settings, light="indirect", denoise_passes=passes))
        of = _receivers(tracer, job, None, names, [page.coarser(step) for page in due.pages])
        canvases, more = yield from _collected(tracer, alone, emitted, None, of, None, stages, (maps, done))
        coarse, notes = Coarse(step, canvases), notes + more
    canvases, more = yield from _collected(
        tracer, job, emitted, camera, receivers, preview, stages, (done, 1), coarse
    )
    notes += more + ([_of_volume(volume)] if volume else [])
    with stages.time("layers"):
        layers, light = {}, {}
        if camera:
            layers = images.camera_layers(canvases[""], camera, scene.render.film_transparent)
            layers |= {f"SSGI {k}": v for view in views for k, v in view.debug(camera.resolution).items()}
        else:
            light = _lights(job, canvases, receivers, due.pages, views)
    if due.pages:
        work = lightmap_borders.finished(tracer.geometry, due.pages, light, job.settings)
        light, more = yield from stages.follow(named("borders", work), 1, 0, {})
        notes += more
    elif job.target == "vertices":
        work = vertex_light.finished(tracer.geometry, light, job.settings.domain == "point")
        light, more = yield from stages.follow(named("borders", work), 1, 0, {})
        notes += more
    return Result(
        job, layers, light, device.name, stages.seconds, core.approximated, tuple(notes),
        volume=volume if job.target == "volume" else None, history=views[0].history if views else None,
        pages=due.whole, hashes=due.hashes, kept=due.kept, uvs={mesh.name: uvs for mesh, uvs in read.made.items()},
        meshes=_meshes(tracer.geometry, due.pages) if job.settings.gltf else {},
    )  # fmt: skip


@dataclass(frozen=True)
class _Read:
    """What a bake knows of the file. job: with what it takes out of the file put in. cameras: that light a target other
    than the image. made: lightmap UVs that the file lacks. notes: what the preflight found."""

    job: Job
    core: Scene
    cameras: list[Camera]
    made: dict[bpy.types.Mesh, np.ndarray]
    notes: list[str]


def _read(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, job: Job, output: Path | None, stages: Stages, known: list
) -> Steps:
    """Reads the file, or takes what is known of it: a generator of (fraction, stage); returns _Read."""
    if known:
        yield 0.0, "read"
    else:
        known.append((yield from _read_file(scene, view_layer, job, output, stages)))
    [(core, made, notes)] = known
    work = named("read", reading_cameras(scene, view_layer, job.cameras))
    cameras = (yield from stages.announced(work)) or [core.camera]
    if job.method == "ssgi" and cameras == [None]:
        raise Refused([preflight.no_camera(scene)])
    if getattr(job.settings, "box", ""):
        job = replace(job, settings=replace(job.settings, box=box_corners(job.settings.box, scene)))
    return _Read(job, core, cameras, made, list(notes))


def _read_file(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, job: Job, output: Path | None, stages: Stages
) -> Steps:
    """The scene, the lightmap UVs that it was given, and what was found: a generator of (fraction, stage)."""
    bakes, settings = SurfaceBakes(), job.settings
    made = yield from stages.announced(making_uvs(scene, view_layer, job))
    work = preflight.inspecting(
        scene, view_layer, ImageReader(),
        target=job.target, objects=job.objects, uv=job.uv, output=output, denoise=settings.denoise,
        glossy=settings.glossy, bakes=bakes, uvs=made,
    )  # fmt: skip
    findings, core = yield from stages.announced(work)
    if any(f.severity == "ERROR" for f in findings):
        raise Refused(findings)
    if bakes.patches:
        work = named("materials", with_bakes(core, scene, view_layer, bakes))
        core = yield from stages.follow(work, 0, 0, {})
    return core, made, [f.told for f in findings]


def _collected(
    tracer: Tracer,
    job: Job,
    emitted: object | None,
    camera: Camera | None,
    receivers: list[Receiver],
    preview: Preview | None,
    stages: Stages,
    between: tuple[float, float],
    coarse: Coarse | None = None,
) -> Steps:
    """The light on all receivers, tile by tile. A generator of (fraction, stage); returns the receivers' canvases by
    their names, with "Direct" and "Indirect" light, and sentences.

    between: fractions of the bake. coarse: reflected light where it is known already.
    """
    settings, technique = _per_point(job), METHODS[job.method]
    canvases: dict[str, dict[str, np.ndarray]] = {receiver.name: {} for receiver in receivers}
    margin, unit = _margin(settings, camera)
    cutting = cut(receivers, min((settings.memory << 20) // POINT_BYTES, tracer.device.most), margin, unit)
    items, done = sum(np.prod(tile.shape) for tile in cutting), 0.0
    begin, length = between[0], between[1] - between[0]
    kept, reused, estimates = kept_layers(settings, camera), [], []
    for tile in cutting:
        share = float(np.prod(tile.shape) / items)
        light = TileLight(tracer, technique, settings, emitted, job.wants("direct"), camera, share, reused, coarse)
        work = light.on(tile, _shown(preview, tile, tracer.geometry) if preview else None)
        found, estimate = yield from stages.follow(work, begin + length * done, length * share, light.stages)
        done += share
        estimates.append(estimate)
        for receiver, rows, own in tile.kept():
            put(canvases[receiver.name], found, kept, receiver, rows, own)
    if settings.denoise == "oidn" and receivers and job.target != "vertices":
        work = without_noise(canvases, technique.noisy(settings) and coarse is None, camera is None)
        yield from stages.follow(named(denoise.stage(), work), 1, 0, {})
    for canvas in canvases.values():
        for kind in ("", "Glossy ") if settings.glossy else ("",):
            canvas[f"{kind}Direct"] = canvas.pop(f"{kind}Lamps") + canvas.pop(f"{kind}Around")
    return canvases, _notes(settings, reused, estimates)


def _lights(
    job: Job,
    canvases: dict[str, dict[str, np.ndarray]],
    receivers: list[Receiver],
    pages: Sequence[Page],
    views: list[ssgi.View],
) -> dict[str, Light]:
    """Light of lightmaps, by their page, or of vertices, by their object."""
    light = {r.name: light_of(canvases[r.name], r.shape, coverage_of(r, views)) for r in receivers}
    if job.settings.directional and pages:
        light = {page.name: directional_of(light, page, canvases[page.name], job) for page in pages}
    if job.settings.gltf and pages:
        light = {page.name: radiant(light[page.name], canvases[page.name], job) for page in pages}
    return light


def making_uvs(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, job: Job) -> Iterator[tuple[str, float]]:
    """Lightmap UVs that a job needs and the file lacks: mesh -> (corners, 2) float32. A generator of (stage, fraction
    of it)."""
    yield "unwrap", 0.0
    settings = job.settings
    if job.target != "lightmap" or job.uv or settings.unwrap == "never":
        return {}
    return (yield from lightmap_uvs.unwrapping(
        scene, view_layer, job.objects, layout.side(scene, job.resolution, settings), settings.room,
        settings.density, layout.is_shared(scene, settings),
    ))  # fmt: skip


missing_uvs = whole(making_uvs)


def _meshes(geometry: Geometry, pages: Sequence[Page]) -> dict[str, tuple[Mesh, np.ndarray]]:
    names = [place.name for page in pages for place in page.places]
    return {name: (geometry.mesh_of(name)[0], geometry.scene.instances[geometry.find(name)].matrix) for name in names}


def receiving(core: Scene, job: Job) -> tuple[str, ...]:
    """Names of the objects that get lightmaps or vertex light."""
    return job.objects or tuple(i.name for i in core.instances if i.receives and not i.is_copy)


def _with_denoiser(job: Job) -> Job:
    """The job with the denoiser that it leaves open: Open Image Denoise leaves a third of the filter's error, of light
    that has noise."""
    settings = job.settings
    if settings.denoise != "auto":
        return job
    fits = job.target == "image" and METHODS[job.method].in_passes(settings) and denoise.works_now()
    return replace(job, settings=replace(settings, denoise="oidn" if fits else "bilateral"))


def _per_point(job: Job) -> Settings:
    """The job's settings with a pixel's samples shared out among its subpixels, or a vertex's among its corners."""
    settings = job.settings
    share = {"image": settings.antialias**2, "vertices": _CORNERS if settings.domain == "point" else 1}
    share = share.get(job.target, 1)
    # A pixel's noise is that of its one point which asks for all of it.
    part = 1 if job.target == "image" else share
    return replace(
        settings,
        samples=-(-settings.samples // share),
        light_samples=-(-settings.light_samples // share),
        # Of a part, of which the whole is the mean.
        noise_threshold=min(1.0, settings.noise_threshold * part),
    )


def _receivers(
    tracer: Tracer, job: Job, camera: Camera | None, names: tuple[str, ...], pages: Sequence[Page]
) -> list[Receiver]:
    """What gets light."""
    if camera:
        return [of_camera(tracer, camera, job.settings.antialias)]
    if job.target == "lightmap":
        sides = range(4 if job.settings.directional else 1)
        return [of_page(tracer.geometry, page, side) for page in pages for side in sides]
    return [of_corners(tracer.geometry, name, job.settings.domain == "corner") for name in names]


def _margin(settings: Settings, camera: Camera | None) -> tuple[int, int]:
    """Rows beyond its own that a tile works out, so that filters find their neighbours, and rows that stay together."""
    subpixels = settings.antialias if camera else 1
    cell = getattr(settings, "interpolation", 1) * subpixels if camera else 1
    margin = images.reach(settings.denoise_passes, subpixels) if settings.smooths else 0
    margin += cell if cell > subpixels else 0
    return -(-margin // cell) * cell, cell


def _shown(preview: Preview, tile: Tile, geometry: Geometry) -> Callable[[dict[str, np.ndarray]], None]:
    """Hands a tile's layers on to a preview, receiver by receiver."""

    def show(layers: dict[str, np.ndarray]):
        light = (layers["Lamps"] + layers["Around"] + layers["Indirect"]) / np.float32(np.pi)
        for receiver, rows, kept in tile.kept():
            places = () if receiver.is_image else (_corners(geometry, receiver.name, kept),)
            preview(receiver.name, pixels(kept, receiver), light[pixels(rows, receiver)], *places)

    return show


def _corners(geometry: Geometry, name: str, rows: slice) -> np.ndarray:
    """Where some of the corners of an object's triangles are, (n, 3) [m]."""
    _, triangles = geometry.mesh_of(name)
    return pick(geometry.vertices, geometry.triangles[triangles].ravel()[rows])


def _of_volume(volume: lpv.Volume) -> Sentence:
    """How fine a volume is, and how large."""
    if not volume.levels:
        return Sentence("volume: there is no light in it")
    grids = [level.grid for level in volume.levels]
    return Sentence(
        "volume: {count} cascades, {cells} cells, the finest of {cell:.3g} m, {size:.1f} MB",
        count=len(grids), cells=sum(grid.size for grid in grids), cell=grids[0].cell, size=volume.nbytes / 2**20,
    )  # fmt: skip


def _notes(settings: Settings, reused: list[tuple[float, int]], estimates: list[Estimate]) -> list[str]:
    """Sentences on how the light was found."""
    notes = []
    if reused:
        share = sum(n for n, _ in reused) / max(1, sum(n for _, n in reused))
        notes.append(
            Sentence("interpolation: {share:.1%} of the image's points reuse their neighbours' light", share=share)
        )
    if estimates and (settings.noise_threshold or settings.time_limit):
        samples = min(estimate.samples for estimate in estimates)
        noise = max(estimate.noise for estimate in estimates)
        notes.append(
            Sentence(
                "refinement: {samples} samples for each point, relMSE {noise:.2g} by the spread of passes",
                samples=samples, noise=noise,
            )
        )  # fmt: skip
    return notes
