# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes measured against Cycles: light, not beauty, direct and indirect apart, on equal terms."""

import os
import platform
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import exr
from ...gi_core.atlas import Place
from ...gi_core.tiles import relayed, whole, within
from ..read.box import box_corners
from ..result import Result
from ..sentence import Sentence
from ..write import hookup
from ..write.attributes import loops_of
from ..write.images import file_stem
from . import curves as over_time
from .edges import smooth
from .halves import Truth, truth_in_steps
from .machine import processor, version
from .report import write_report
from .subject import Subject, summed

# Stages whose steps touch Blender, which allows that on its main thread only; the others may run on any, and know
# nothing of the file.
ON_MAIN_THREAD = HOLDING = frozenset({"cycles"})

# What has been done of the whole when Cycles is done, and when all is measured.
_CYCLES, _REPORT = 0.9, 0.95


@dataclass(frozen=True)
class Report:
    """paths: files written. metrics: technique -> name of what was compared -> measure -> value. seconds: that Cycles
    took for the reference, now or when it was made. subjects: the pictures."""

    paths: tuple[Path, ...]
    metrics: dict[str, dict[str, dict[str, float]]]
    seconds: float
    subjects: tuple[Subject, ...] = ()


def compare_in_steps(
    results: Result | dict[str, Result],
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    samples: int,
    folder: Path,
    dark: str = "",
    curves: bool = False,
    go: int = 0,
) -> Iterator[tuple[float, str]]:
    """Renders with Cycles what was baked, at the same bounces, and writes FOLDER/report.html and .json, the reference
    as EXR, and FOLDER/reference.npz, which saves the next comparison of the same scene the render. A generator of
    (fraction, stage); a step after a stage of ON_MAIN_THREAD belongs there, like the first one. Between steps the file
    is as it was. Returns Report.

    results: one, or several by the name that each has in the report, of the same target, objects, size and bounces.
    samples: of Cycles for each pixel, texel or vertex. The scene must be at the frame that was baked; it is left as it
        was.
    dark: a box that is to be dark, 'x y z x y z' [m] or an object's name: what light is there is a leak. For camera
        images. curves: also error over time, of each technique at several budgets and of Cycles; for camera images.
    go: samples of all points that Cycles takes in one step, 0 for all.
    Raises RuntimeError where Cycles refuses or the scene is changed meanwhile, ValueError for results that cannot be
    compared with one another.
    """
    results = {results.job.method: results} if isinstance(results, Result) else results
    result = next(iter(results.values()))
    job = result.job
    if len({_what(r) for r in results.values()}) > 1:
        raise ValueError("results of different targets, objects, sizes, bounces or anti-aliasing cannot be compared")
    if job.target != "image" and (dark or curves):
        raise ValueError("a dark region and error over time are of camera images: compare the target image")
    names, left_out = comparable(result, view_layer)
    if job.target != "image" and not names:
        raise RuntimeError("Cycles bakes meshes only: convert what is baked to one, or add meshes")
    box = dark_box(dark, scene) if dark else None
    work = truth_in_steps(scene, view_layer, job, _size(result), maps(result, names), samples, folder, go)
    found = yield from _staged("cycles", 0, _CYCLES, hookup.unseen_by(work))
    title = f"GI Bake and Cycles: {Path(bpy.data.filepath).stem or scene.name}"
    told = f"{Path(bpy.data.filepath).name}, {scene.name}, frame {scene.frame_current}"
    layer = view_layer.name
    yield _CYCLES, "measure"
    if job.target == "image":
        subjects = _camera(results, found, box)
    else:
        subjects = _objects(results, found, names, view_layer)

    rows, ratios = None, None
    if curves:
        yield _CYCLES, "cycles"
        indirect = next(s for s in subjects if s.kind == "indirect")
        with hookup.muted():
            rows = over_time.curves(scene, view_layer, results, indirect.reference, indirect.mask)
        ratios = over_time.against_cycles(rows, indirect.floor["relmse"])
    techniques = {
        label: {
            "method": r.job.method, "device": r.device, "seconds": sum(r.stages.values()), "stages": r.stages,
            "settings": asdict(r.job.settings), "approximated": list(r.approximated),
            "warnings": [*r.warnings, *left_out],
        }
        for label, r in results.items()
    }  # fmt: skip
    reference = {
        **found.terms, "rendered": found.made + (", kept from an earlier comparison" if found.kept else ""),
        "seconds": found.seconds,
    }  # fmt: skip
    about = {
        "scene": told, "target": job.target,
        "light": "diffuse, without colour: E/π", "version": f"GI Bake {version()}", "seed": job.settings.seed,
        "machine": f"{processor()}, {os.cpu_count()} cores, {platform.system()}",
    }  # fmt: skip
    yield _REPORT, "report"
    paths = write_report(folder, title, subjects, techniques, reference, about, rows, ratios)
    measured = {label: {s.name: s.measures[label] for s in subjects} for label in results}
    return Report((*paths, *_images(found, folder, layer)), measured, found.seconds, tuple(subjects))


compare = whole(compare_in_steps)


def _staged(stage: str, begin: float, end: float, work: Iterator[float]) -> Iterator[tuple[float, str]]:
    """A part's progress as the whole's, with its stage; returns the part's value."""
    return relayed(within(begin, end, work), lambda fraction: (fraction, stage))


def dark_box(text: str, scene: bpy.types.Scene) -> np.ndarray:
    """The region that is to be dark, (2, 3): its lower and upper corner. Raises ValueError for what is no box."""
    try:
        corners = np.array([float(n) for n in box_corners(text, scene).split()]).reshape(2, 3)
    except ValueError:
        raise ValueError(f"the dark region is '{text}': name an object, or give a box as 'x y z x y z'") from None
    return np.sort(corners, axis=0)


def comparable(result: Result, view_layer: bpy.types.ViewLayer) -> tuple[list[str], list[str]]:
    """Names of the objects that Cycles can bake too, and sentences on those that it cannot."""
    every = [place.name for page in result.pages for place in page.places] or list(result.light)
    names = [name for name in every if view_layer.objects[name].type == "MESH"]
    return names, [
        Sentence("{name} is no mesh: not compared", name=name) for name in every if name not in names
    ]


def _what(result: Result) -> tuple:
    """What has to be equal of results that stand side by side."""
    job = result.job
    terms = job.settings.bounces, job.settings.antialias > 1, job.target == "image" or job.settings.light
    domain = job.target == "vertices" and job.settings.domain
    return job.target, _size(result), tuple(result.light), result.pages, job.uv, domain, *terms


def maps(result: Result, names: Iterable[str]) -> dict[str, tuple[str, int]]:
    """The UV map that each object's lightmap lies on, and the side of its square of texels; "" and 0 of vertices."""
    laid = {place.name: (place.uv, place.side) for page in result.pages for place in page.places}
    return {name: laid.get(name, ("", 0)) for name in names}


def _size(result: Result) -> tuple[int, int]:
    """(width, height) of the camera image or of the first lightmap; (0, 0) of light at vertices."""
    if result.layers:
        height, width = result.layers["Combined"].shape[:2]
        return width, height
    return (result.pages[0].width, result.pages[0].height) if result.pages else (0, 0)


def _camera(results: dict[str, Result], found: Truth, box: np.ndarray | None) -> list[Subject]:
    light, noise, first = found.light, found.noise, next(iter(results.values()))
    seen = light["Diffuse Color"].any(-1)
    # Of pixels' centres both see the same; a pixel's mean is another matter where surfaces lie one behind the other.
    mask = seen
    if first.job.settings.antialias > 1:
        mask = seen & smooth(light["Position"], light["Normal"], light["Depth"][..., 0])
    dark = _inside(light["Position"], box) if box is not None else None
    if dark is not None and not (dark & mask).any():
        raise ValueError("the camera sees nothing of the dark region")

    def subject(name, kind, mask, seen, dark=None):
        ours = {label: r.layers[name] for label, r in results.items()}
        return Subject(name, kind, light[name], noise[name], mask, seen, ours, dark)

    indirect, direct = (subject(f"Diffuse {k.title()}", k, mask, seen, dark) for k in ("indirect", "direct"))
    subjects = [indirect, direct, summed(direct, indirect, "Diffuse Direct and Indirect")]
    # Cycles sees more points of a pixel, and of a silhouette's it may be the only one that meets what is glossy.
    shown = np.logical_and.reduce(
        [r.layers.get("Glossy Color", np.zeros((*seen.shape, 3))).any(-1) for r in results.values()]
    )
    if shown.any():
        subjects += [subject(f"Glossy {k.title()}", f"glossy {k}", shown, shown) for k in ("indirect", "direct")]
    return subjects


def _objects(
    results: dict[str, Result], found: Truth, names: list[str], view_layer: bpy.types.ViewLayer
) -> list[Subject]:
    subjects = []
    for name in names:
        kinds = [k for k in ("direct", "indirect") if (name, k) in found.light]
        if next(iter(results.values())).job.target == "lightmap":
            lights = [_lightmap(results, found, name, k) for k in kinds]
        else:
            lights = [_vertices(results, found, view_layer.objects[name], k) for k in kinds]
        lights = [light for light in lights if light]
        subjects += lights
        if len(lights) == 2:
            subjects.append(summed(*lights, f"{name}, direct and indirect"))
    return subjects


def _lightmap(results: dict[str, Result], found: Truth, name: str, kind: str) -> Subject | None:
    """An object's square of its lightmap. None where no texel has a value on both sides."""
    reference, noise = found.light[name, kind], found.noise[name, kind]
    pages = next(iter(results.values())).pages
    [(page, place)] = [(page.name, place) for page in pages for place in page.places if place.name == name]
    light = {label: r.light[page] for label, r in results.items()}
    valid = np.logical_and.reduce([_square(each.centred, place) for each in light.values()])
    # Cycles bakes the texels whose centre a face covers; the others it leaves to the margin.
    valid = valid & (reference[..., 3] > 0)
    ours = {label: _square(getattr(each, kind), place) for label, each in light.items()}
    if not valid.any():
        return None
    return Subject(f"{name}, {kind}", kind, reference[..., :3], noise[..., :3], valid, valid, ours)


def _square(image: np.ndarray, place: Place) -> np.ndarray:
    """An object's square of an image, empty where it leaves it: (h, w, …) -> (side, side, …)."""
    out = np.zeros((place.side, place.side, *image.shape[2:]), image.dtype)
    low = max(0, -place.x), max(0, -place.y)
    part = image[place.y + low[1] : place.y + place.side, place.x + low[0] : place.x + place.side]
    out[low[1] : low[1] + part.shape[0], low[0] : low[0] + part.shape[1]] = part
    return out


def _vertices(results: dict[str, Result], found: Truth, obj: bpy.types.Object, kind: str) -> Subject | None:
    """Light at an object's vertices or corners, as an image of one row. None where nothing has light on both sides.

    Cycles' is that at the corners which count for us: in its own mean those inside of walls count too, as black.
    """
    light = {label: r.light[obj.name] for label, r in results.items()}
    valid = np.logical_and.reduce([each.centred for each in light.values()])
    if not valid.any():
        return None
    first, corners = next(iter(results.values())), next(iter(light.values())).corners
    known = np.logical_and.reduce([each.known for each in light.values()])
    loops = loops_of(obj, corners.vertex)
    reference, noise = (each[obj.name, kind][loops] for each in (found.light, found.noise))
    if first.job.settings.domain == "point":
        reference, noise = (corners.at_vertices(each, known) for each in (reference, noise))
    row = [each[None] for each in (reference, noise, valid, valid)]
    ours = {label: getattr(each, kind)[None] for label, each in light.items()}
    return Subject(f"{obj.name}, {kind}", kind, *row, ours, flat=False)


def _inside(position: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Pixels whose place lies in a box: (h, w) bool."""
    return ((position >= box[0]) & (position <= box[1])).all(-1)


def _images(found: Truth, folder: Path, view_layer: str) -> list[Path]:
    """The reference as EXR: layers of one file for a camera image, a file for each lightmap."""
    if "Position" in found.light:
        path = folder / "reference.exr"
        spread = {f"{name} Noise": found.noise[name] for name in ("Diffuse Direct", "Diffuse Indirect")}
        exr.write_layers(path, found.light | spread, view_layer)
        return [path]
    paths = []
    for number, ((name, kind), pixels) in enumerate(found.light.items()):
        if pixels.ndim == 3:
            paths.append(folder / "reference" / f"{number:03d} {file_stem(name)} {kind}.exr")
            paths[-1].parent.mkdir(exist_ok=True)
            exr.write_image(paths[-1], pixels)
    return paths
