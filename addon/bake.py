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

from ..gi_core import borders, directional, images, lpv, ssgi
from ..gi_core.atlas import Page
from ..gi_core.geometry import Geometry
from ..gi_core.receivers import POINT_BYTES, Receiver, Tile, cut, guides, of_camera, of_page, of_vertices
from ..gi_core.refine import Estimate
from ..gi_core.rsm.settings import RsmSettings
from ..gi_core.scene import Camera, Mesh, Scene
from ..gi_core.seams import Seams, atlas_seams
from ..gi_core.settings import SettingError, Settings
from ..gi_core.surfels import TILE
from ..gi_core.techniques import METHODS, Asked
from ..gi_core.tile_light import TileLight
from ..gi_core.tiles import finish, named, slices
from ..gi_core.trace import Tracer
from . import denoise, gpu_context, layout, preflight, rebake
from .read import with_bakes
from .read.box import box_corners
from .read.camera import read_cameras
from .read.images import ImageReader
from .read.surface_bakes import SurfaceBakes
from .stages import Stages
from .write import lightmap_uvs

TARGETS = ("image", "lightmap", "vertices", "volume")

# What maps and tiles take of the whole, roughly; the bar follows it.
_MAPS, _TILES = 0.1, 0.9

# Points that stand for all that get light where lights are chosen.
_GUIDES = 1 << 14

# Stages whose steps touch Blender, which allows that on its main thread only; the others may run on any.
ON_MAIN_THREAD = frozenset({"unwrap", "read", "materials", "layout", "oidn"})


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
    resolution: side of each lightmap, or the longer side of the camera image [px]; None means `layout.SIDE`, or the
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
        if self.resolution is not None and not 4 <= self.resolution <= 16384:
            raise SettingError(f"the resolution is {self.resolution}; it goes from 4 to 16384 pixels")
        if self.settings.rebake == "changed" and (self.settings.directional or self.settings.gltf):
            raise SettingError("setting 'rebake=changed' keeps plain lightmaps only: not with directional or gltf")
        if self.settings.glossy and self.target != "image":
            raise SettingError(
                f"setting 'glossy' is for the camera image: what glossy surfaces reflect depends on the view, and the "
                f"target '{self.target}' holds one light for all views"
            )

        if getattr(self.settings, "fog_density", 0) and self.target != "image":
            raise SettingError(f"setting 'fog_density' is for the camera image: the target '{self.target}' has no view")

    def wants(self, light: str) -> bool:
        """Whether "direct" or "indirect" light is asked for; a camera image shows both."""
        return self.target == "image" or self.settings.light in (light, "combined")


@dataclass(frozen=True)
class Light:
    """Light on one receiver, E/π, "light without colour" as Cycles' passes and bakes hold it.

    direct, indirect: (h, w, 3) float32 of a lightmap, or (v, 3) of vertices or of triangles' corners.
        Beyond valid texels of lightmaps too, as far as islands grow.
    valid: (h, w) or (v,) bool, where a surface is.
    centred: bool, same shape: the surface covers the texel's centre, not only a part of it, and does not lie inside of
        something. filled: bool, same shape, where there is a value.
    coverage: float32, same shape, 0…1: how surely a camera saw it; None where no camera is asked.
    directional: (h, w, 4, 3) float32, two bands of harmonics (see `gi_core.sh`) whose value at a normal is the light
        that is wanted; radiance: (h, w, 3) float32, what the surface sends out of it, and by itself. None where they
        are not asked for.
    """

    direct: np.ndarray
    indirect: np.ndarray
    valid: np.ndarray
    centred: np.ndarray
    filled: np.ndarray
    coverage: np.ndarray | None = None
    directional: np.ndarray | None = None
    radiance: np.ndarray | None = None


@dataclass(frozen=True)
class Result:
    """What a bake gives.

    layers: pass name -> (h, w, c) float32 of the camera image, else empty.
    light: name -> Light of lightmaps, by their page, or of vertices, by their object, else empty.
    pages: the lightmaps, and which objects lie where on them. uvs: mesh name -> (corners, 2) float32, lightmap UVs that
        were made for the bake and are not in the file yet. hashes: object name -> of what its lightmap follows from.
        kept: page name -> (h, w, 4) float32, what the file holds of objects that were not baked anew.
    meshes: object name -> its mesh and its matrix in the world, where they are to be written.
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
    pages: tuple[Page, ...] = ()
    hashes: dict[str, str] = field(default_factory=dict)
    kept: dict[str, np.ndarray] = field(default_factory=dict)
    meshes: dict[str, tuple[Mesh, np.ndarray]] = field(default_factory=dict)
    uvs: dict[str, np.ndarray] = field(default_factory=dict)


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

    A step after a stage of ON_MAIN_THREAD belongs there, like the first one; the others may be taken on any thread.

    Raises Refused, before any work, where the preflight finds errors.
    """
    stages, bakes = Stages(), SurfaceBakes()
    yield 0.0, "unwrap"
    with stages.time("unwrap"):
        made = missing_uvs(scene, view_layer, job)
    yield 0.0, "read"
    with stages.time("read"), lightmap_uvs.lent(made):
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
    if getattr(job.settings, "box", ""):
        job = replace(job, settings=replace(job.settings, box=box_corners(job.settings.box, scene)))
    transparent = scene.render.film_transparent
    with stages.time("device"):
        pixels = np.prod(camera_at(core.camera, job.resolution).resolution) if job.target == "image" else 0
        spares = gpu_context.spared(job.method, int(pixels), job.settings.samples)
        device, why_not = gpu_context.device(job.settings.device, job.settings.memory << 20, spares)
    yield 0.0, "trees"
    with stages.time("trees"):
        tracer = Tracer(Geometry(core), device)

    settings, technique = _per_point(job), METHODS[job.method]
    notes = [f"{f.code}: {f.message}" for f in findings]
    if why_not:
        notes.append(f"NO_GPU: the graphics card was asked for; the processor computed: {why_not}")
    if job.target == "volume":
        work = named("maps", technique.emit(tracer, Asked(None), settings))
        volume = yield from stages.follow(work, 0, 1, {"maps": 1.0})
        notes.append(volume.summary)
        return Result(job, {}, {}, device.name, stages.seconds, core.approximated, tuple(notes), volume)

    camera = camera_at(core.camera, job.resolution) if job.target == "image" else None
    names, whole, pages, hashes, earlier = receiving(core, job), [], [], {}, {}
    if job.target == "lightmap":
        yield 0.0, "layout"
        with stages.time("layout"):
            whole = layout.pages(tracer.geometry, scene, names, job.uv, job.resolution, job.settings)
            whole, pages, hashes, earlier = rebake.due(scene, core, whole, job.method, job.settings)
        names = tuple(place.name for page in pages for place in page.places)
        yield 0.0, "maps"
    receivers = _receivers(tracer, job, camera, names, pages)
    emitted = None
    if job.wants("indirect") and receivers:
        spread = guides(tracer, names, camera, _GUIDES)
        asked = Asked(spread, [camera] if camera else cameras, history)
        work = named("maps", technique.emit(tracer, asked, job.settings))
        emitted = yield from stages.follow(work, 0, _MAPS, {"maps": 1.0})

    margin, unit = _margin(settings, camera)
    cutting = cut(receivers, min((settings.memory << 20) // POINT_BYTES, device.most), margin, unit)
    items, done = sum(np.prod(tile.shape) for tile in cutting), 0.0
    canvases: dict[str, dict[str, np.ndarray]] = {receiver.name: {} for receiver in receivers}
    kept_layers, reused, estimates = _kept_layers(settings, camera), [], []
    for tile in cutting:
        share = float(np.prod(tile.shape) / items)
        light = TileLight(tracer, technique, settings, emitted, job.wants("direct"), camera, share, reused)
        seen = _shown(preview, tile) if preview else None
        work = light.on(tile, seen)
        found, estimate = yield from stages.follow(work, _MAPS + _TILES * done, _TILES * share, light.stages)
        done += share
        estimates.append(estimate)
        for receiver, rows, kept in tile.kept():
            _put(canvases[receiver.name], found, kept_layers, receiver, rows, kept)
    if settings.denoise == "oidn" and job.target != "vertices":
        yield from stages.follow(named("oidn", _oidn(canvases, technique.noisy(settings), camera is None)), 1, 0, {})

    views = emitted if job.method == "ssgi" and emitted else []
    with stages.time("layers"):
        for canvas in canvases.values():
            for kind in ("", "Glossy ") if job.settings.glossy else ("",):
                canvas[f"{kind}Direct"] = canvas.pop(f"{kind}Lamps") + canvas.pop(f"{kind}Around")
        layers, light = {}, {}
        if camera:
            layers = images.camera_layers(canvases[""], camera, transparent)
            layers |= {f"SSGI {k}": v for view in views for k, v in view.debug(camera.resolution).items()}
        else:
            light = {r.name: _light(canvases[r.name], r.shape, _coverage(r, views)) for r in receivers}
            if job.settings.directional:
                light = {page.name: _directional(light, page, canvases[page.name], job) for page in pages}
                receivers = [r for r in receivers if r.name in light]
            if job.settings.gltf and pages:
                light = {page.name: _radiant(light[page.name], canvases[page.name], job) for page in pages}
    warnings = notes + _notes(settings, reused, estimates)
    if isinstance(emitted, lpv.Volume):
        warnings.append(emitted.summary)
    if pages:
        work = named("borders", _bordered(tracer, receivers, pages, light, settings))
        light, more = yield from stages.follow(work, 1, 0, {})
        warnings += more
    carried = views[0].history if views else None
    uvs = {mesh.name: uvs for mesh, uvs in made.items()}
    return Result(
        job, layers, light, device.name, stages.seconds, core.approximated, tuple(warnings), history=carried,
        pages=tuple(whole), hashes=hashes, kept=earlier, uvs=uvs,
        meshes=_meshes(tracer.geometry, pages) if job.settings.gltf else {},
    )  # fmt: skip


def missing_uvs(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, job: Job
) -> dict[bpy.types.Mesh, np.ndarray]:
    """Lightmap UVs that a job needs and the file lacks: mesh -> (corners, 2) float32."""
    settings = job.settings
    if job.target != "lightmap" or job.uv or settings.unwrap == "never":
        return {}
    return lightmap_uvs.unwrapped(
        scene, view_layer, job.objects, layout.side(scene, job.resolution, settings), settings.padding,
        settings.density, layout.is_shared(scene, settings),
    )  # fmt: skip


def _meshes(geometry: Geometry, pages: list[Page]) -> dict[str, tuple[Mesh, np.ndarray]]:
    names = [place.name for page in pages for place in page.places]
    return {name: (geometry.mesh_of(name)[0], geometry.scene.instances[geometry.find(name)].matrix) for name in names}


def receiving(core: Scene, job: Job) -> tuple[str, ...]:
    """Names of the objects that get lightmaps or vertex light."""
    return job.objects or tuple(i.name for i in core.instances if i.receives and not i.is_copy)


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


def _receivers(
    tracer: Tracer, job: Job, camera: Camera | None, names: tuple[str, ...], pages: list[Page]
) -> list[Receiver]:
    """What gets light."""
    if camera:
        return [of_camera(tracer, camera, job.settings.antialias)]
    if job.target == "lightmap":
        sides = range(4 if job.settings.directional else 1)
        return [of_page(tracer.geometry, page, side) for page in pages for side in sides]
    return [of_vertices(tracer.geometry, name, job.settings.domain == "corner") for name in names]


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
    guides |= {"Normal"} if settings.directional else set()
    guides |= {"Color", "Emission"} if settings.gltf and not camera else set()
    gloss = {"Glossy Lamps", "Glossy Around", "Glossy Indirect", "Glossy Color"} if settings.glossy else set()
    fog = {"Volume Direct", "Volume Indirect", "Transmittance"} if getattr(settings, "fog_density", 0) else set()
    return light | guides | gloss | fog | ({"Emission", "Sky"} if camera else set())


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


def _oidn(canvases: dict[str, dict[str, np.ndarray]], noisy: bool, apart: bool) -> Iterator[float]:
    """Takes the noise out of all images; noisy: out of reflected light too. apart: each island by itself. A generator
    of progress."""
    found = list(canvases.values())
    kinds = ["Around", *(["Indirect"] if noisy else []), "Glossy Around", "Glossy Indirect"]
    kinds = [kind for kind in kinds if any(kind in canvas for canvas in found)]
    smoothed = denoise.smoothed_islands if apart else denoise.smoothed
    clean = yield from smoothed([np.concatenate([c[k] for k in kinds], -1) for c in found], found)
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
    valid = canvas["Coverage"].reshape(shape) > 0
    return Light(direct, indirect, valid, canvas["Centred"].reshape(shape), valid, coverage)


def _directional(light: dict[str, Light], page: Page, canvas: dict[str, np.ndarray], job: Job) -> Light:
    """A page's light with what it is for other normals too, out of its lights for four."""
    four = [light[directional.named(page.name, k)] for k in range(4)]
    seen = np.stack([job.settings.wanted(each.direct, each.indirect) for each in four])
    return replace(four[0], directional=directional.coefficients(seen, canvas["Normal"]))


def _radiant(light: Light, canvas: dict[str, np.ndarray], job: Job) -> Light:
    """Light with what the surface makes of it."""
    wanted = job.settings.wanted(light.direct, light.indirect)
    return replace(light, radiance=canvas["Color"] * wanted + canvas["Emission"])


def _bordered(
    tracer: Tracer, receivers: list[Receiver], pages: list[Page], light: dict[str, Light], settings: Settings
) -> Iterator[float]:
    """Lightmaps without texels from inside of walls, with islands grown and seams closed. A generator of progress;
    returns the lights by their names, and sentences."""
    done, found, hidden = {}, {}, 0
    for k, (receiver, page) in enumerate(zip(receivers, pages)):
        yield k / len(pages)
        raw = light[page.name]
        layers = [raw.direct, raw.indirect]
        dark = borders.dark(np.concatenate(layers, -1), raw.valid)
        layers.append(raw.radiance if raw.radiance is not None else np.zeros((*raw.valid.shape, 0), np.float32))
        if raw.directional is not None:
            layers.append(raw.directional.reshape(*raw.valid.shape, -1))
        # A sliver of a face at its border, in the wall that it runs into, says nothing of the texel.
        inside = _inside(tracer, receiver, dark) | (dark & ~raw.centred)
        cuts = atlas_seams(tracer.geometry, page) if settings.stitch else Seams.concatenate([])
        whole = borders.bordered(np.concatenate(layers, -1), raw.valid, inside, settings.margin, cuts)
        direct, indirect, radiance, more = np.split(whole.image, np.cumsum([n.shape[-1] for n in layers[:3]]), -1)
        done[page.name] = replace(
            raw, direct=direct, indirect=indirect, centred=raw.centred & ~inside, filled=whole.filled,
            radiance=None if raw.radiance is None else radiance,
            directional=None if raw.directional is None else more.reshape(*raw.valid.shape, 4, 3),
        )  # fmt: skip
        hidden += whole.inside
        if len(cuts):
            found[page.name] = whole.before, whole.after, len(cuts)
    notes = []
    if hidden:
        notes.append(f"inside: {hidden} texels lie inside of something, or at its border: filled from around them")
    if found:
        pairs = sum(n for _, _, n in found.values())
        before, after = (sum(f[k] * f[2] for f in found.values()) / pairs for k in (0, 1))
        notes.append(f"seams: the two sides disagree by {after:.2%}, before stitching by {before:.2%}")
    return done, notes


def _inside(tracer: Tracer, receiver: Receiver, asked: np.ndarray) -> np.ndarray:
    """Which of the texels asked for lie inside of something: (h, w) bool to the same."""
    inside = np.zeros(asked.size, bool)
    rows = np.flatnonzero(asked.any(1))
    for part in slices(receiver.height, max(1, TILE // receiver.width)) if len(rows) else []:
        if asked[part].any():
            points, _ = receiver.points(part)
            points = points[asked.ravel()[points.place]]
            inside[points.place[borders.inside(tracer, points)]] = True
    return inside.reshape(asked.shape)


def _notes(settings: Settings, reused: list[tuple[float, int]], estimates: list[Estimate]) -> list[str]:
    """Sentences on how the light was found."""
    notes = []
    if reused:
        share = sum(n for n, _ in reused) / max(1, sum(n for _, n in reused))
        notes.append(f"interpolation: {share:.1%} of the image's points reuse their neighbours' light")
    if estimates and (settings.noise_threshold or settings.time_limit):
        samples = min(estimate.samples for estimate in estimates)
        noise = max(estimate.noise for estimate in estimates)
        notes.append(f"refinement: {samples} samples for each point, relMSE {noise:.2g} by the spread of passes")
    return notes
