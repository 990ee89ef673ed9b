# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the properties of a scene ask for: the job, its folder, and how much it is."""

import math
from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path

import bpy

from ..gi_core.atlas import MOST
from ..gi_core.lpv.grid import memory
from ..gi_core.receivers import POINT_BYTES
from ..gi_core.settings import Settings
from ..gi_core.techniques import METHODS
from . import layout
from .job import Job
from .object_options import SURFACES
from .rna import own_fields, values


def settings(scene: bpy.types.Scene, method: str) -> Settings:
    """The settings of a technique, "rsm", "lpv" or "ssgi", as the scene has them. Raises SettingError."""
    group, kind = scene.gi_bake, METHODS[method].settings
    own = own_fields(kind)
    return kind(**values(group, fields(Settings)), **values(getattr(group, method), own))


def job(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    method: str = "",
    target: str = "",
    objects: tuple[str, ...] = (),
    resolution: int = 0,
    uv: str = "",
    device: str = "auto",
) -> Job:
    """The job that the scene's properties ask for; what is given here counts instead.

    device: what the setting "auto" stands for. Raises SettingError and NotThere.
    """
    group = scene.gi_bake
    method, target = method or group.method.lower(), target or group.target.lower()
    chosen = settings(scene, method)
    if target != "image" and chosen.glossy:
        # The panel shows it for the camera image only.
        chosen = replace(chosen, glossy=False)
    if chosen.device == "auto":
        chosen = replace(chosen, device=device)
    if target == "image":
        own = None if group.use_render_size else group.image_resolution
    else:
        own = group.resolution
    if target in {"lightmap", "vertices"}:
        objects = objects or chosen_objects(scene, view_layer)
    return Job(method, target, objects, resolution or own, uv or group.uv, chosen)


def chosen_objects(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[str, ...]:
    """Names of the objects that get light; empty where all that render do."""
    selected = scene.gi_bake.scope == "SELECTED"
    there = surfaces(view_layer)
    names = tuple(o.name for o in there if o.gi_bake.use and (not selected or o.select_get(view_layer=view_layer)))
    return () if len(names) == len(there) and not selected else names


def surfaces(view_layer: bpy.types.ViewLayer) -> list[bpy.types.Object]:
    """The objects with a surface that render, each once."""
    found: dict[str, bpy.types.Object] = {}
    for collection in _collections(view_layer.layer_collection):
        for obj in collection.objects:
            if obj.type in SURFACES and not obj.hide_render and _has_faces(obj):
                found[obj.name] = obj
    return list(found.values())


def _has_faces(obj: bpy.types.Object) -> bool:
    return obj.type != "MESH" or bool(obj.data.polygons or obj.modifiers)


def _collections(layer: bpy.types.LayerCollection) -> Iterator[bpy.types.Collection]:
    """Collections that render, from one on down."""
    if layer.exclude or layer.collection.hide_render:
        return
    yield layer.collection
    for child in layer.children:
        yield from _collections(child)


def output(scene: bpy.types.Scene, folder: str = "") -> Path:
    """The folder for files, where they belong beside the .blend or were asked for."""
    return Path(bpy.path.abspath(folder or scene.gi_bake.folder))


def needs_folder(scene: bpy.types.Scene, target: str) -> bool:
    """Whether a bake writes files."""
    return target == "volume" or (scene.gi_bake.keep == "FILES" and target != "vertices")


@dataclass(frozen=True)
class Extent:
    """How much a bake is. objects: that get light, 0 for an image. points: pixels, texels or vertices; cells of a
    volume. size: resolution, as text. memory: bytes, about. images: lightmaps."""

    objects: int
    points: int
    size: str
    memory: int
    images: int = 0


def extent(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Extent:
    """How much the scene's properties ask for; made to be drawn, so no modifier is counted and nothing is read."""
    group = scene.gi_bake
    method, target = group.method.lower(), group.target.lower()
    volume = memory(settings(scene, "lpv")) if method == "lpv" else 0
    if target == "volume":
        return Extent(0, volume // 108, f"{group.lpv.cells} × {group.lpv.cascades}", volume)
    if target == "image":
        width, height = image_size(scene)
        points = width * height * group.antialias**2
        return Extent(0, points, f"{width} × {height}", volume + _working(points, group.memory))
    there = surfaces(view_layer)
    names = chosen_objects(scene, view_layer)
    chosen = [o for o in there if o.name in set(names)] if names or group.scope == "SELECTED" else there
    if target == "vertices":
        # Corners of triangles.
        points = sum(3 * (len(o.data.loops) - 2 * len(o.data.polygons)) for o in chosen if o.type == "MESH")
        return Extent(len(chosen), points, str(points), volume + _working(points, group.memory))
    sides = _sides(chosen, scene, settings(scene, method))
    points = sum(side**2 for side in sides)
    low, high = min(sides, default=group.resolution), max(sides, default=group.resolution)
    size = f"{high} × {high}" if low == high else f"{low}² … {high}²"
    taken = volume + _working(points, group.memory) + 16 * points
    return Extent(len(chosen), points, size, taken, len(sides))


def _sides(objects: list[bpy.types.Object], scene: bpy.types.Scene, chosen: Settings) -> list[int]:
    """Sides of the lightmaps of objects [texels], one by one. At a density they are guessed by the boxes around the
    objects."""
    lightmaps: dict[tuple[str, str], list[bpy.types.Object]] = {}
    for obj in objects:
        lightmaps.setdefault(layout.group(obj, scene, chosen), []).append(obj)
    found, resolution = [], scene.gi_bake.resolution
    for (kind, _), members in lightmaps.items():
        if kind == "object":
            factor = members[0].gi_bake.lightmap_factor
            found.append(_dense(members[0], chosen.density) if chosen.density else max(4, round(resolution * factor)))
        else:
            texels = sum(_dense(obj, chosen.density) ** 2 for obj in members)
            found += [resolution] * max(1, math.ceil(texels / resolution**2))
    return found


def _dense(obj: bpy.types.Object, density: float) -> int:
    """Side of an object's lightmap at so many texels per metre, about: flat ones fill theirs, others half of it."""
    x, y, z = sorted(obj.dimensions)
    texels = y * z if x < 0.01 * z else 2 * (x * y + y * z + z * x) / 0.5
    side = math.sqrt(texels) * density * obj.gi_bake.lightmap_factor
    return min(-(-math.ceil(side) // 4) * 4, MOST)


def image_size(scene: bpy.types.Scene) -> tuple[int, int]:
    """Width and height of the camera image [px]."""
    render, group = scene.render, scene.gi_bake
    share = render.resolution_percentage / 100
    width, height = (max(1, int(n * share)) for n in (render.resolution_x, render.resolution_y))
    if group.use_render_size:
        return width, height
    longer = max(width, height)
    return tuple(max(1, round(n * group.image_resolution / longer)) for n in (width, height))


def _working(points: int, limit: int) -> int:
    return min(points * POINT_BYTES, limit << 20)
