# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmap UVs where a mesh has none: Blender's own unwrapper and packer, in a UV map beside the artist's.

A mesh lacks them where its active UV map is missing, leaves the unit square or has faces on each other, as maps for
tiled textures do. The new map is made on a copy of the mesh in a scene of its own, in the size that the mesh has in
the world, so that texels are as dense everywhere.
"""

import contextlib
import math
from collections.abc import Iterator, Sequence

import bpy
import numpy as np

from ...gi_core.atlas import expected_sides
from ...gi_core.scene import LIGHTMAP_UV as NAME
from ...gi_core.settings import Settings
from ...gi_core.texels import outside, overlap
from ...gi_core.tiles import whole
from .. import layout
from ..object_options import object_options

# Angles between faces up to which they lie on one island [degrees]. The larger the fewer islands, but on some shapes
# faces then come to lie on each other: then the next is tried.
_ANGLES = (66, 45, 20, 1)

# Share of what a UV map covers that may lie on each other, or outside.
TOLERANCE = 0.002

# Samples along a side that tell so much.
ROUGHLY = 256

# What stays free around islands follows from a lightmap's size, and that from how well they fill it: rounds of both,
# with what is given more than asked for, and the share of its square that a mesh fills to begin with.
_ROUNDS, _SPARE, _FILLED = 4, 1.1, 0.5

# With less of its square filled than this, a mesh has too many islands to keep them apart on a small lightmap.
_LEAST = 0.1


def make(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    objects: Sequence[str],
    resolution: int | None = None,
    padding: int = Settings().room,
    density: float = 0.0,
    together: bool = False,
) -> list[str]:
    """Gives the objects' meshes the UV map NAME where they lack one for lightmaps; the names of the objects it is for.

    objects: their names, empty for all meshes that render. resolution: side of a lightmap [texels]. padding: texels
    that stay free around each island. density: texels per metre, 0 for what the resolution gives. together: the objects
    share one lightmap.
    Left out are meshes that cannot be changed: linked ones, those in edit mode, those with eight UV maps.
    """
    made = unwrapped(scene, view_layer, objects, resolution or layout.SIDE, padding, density, together)
    put_all(made)
    return [obj.name for obj in scene.objects if obj.type == "MESH" and obj.data in made]


@contextlib.contextmanager
def lent(made: dict[bpy.types.Mesh, np.ndarray]) -> Iterator[None]:
    """Has UV maps in the file for a while: mesh -> (corners, 2)."""
    before = {mesh: mesh.uv_layers.get(NAME) and read(mesh, NAME) for mesh in made}
    try:
        for mesh, uvs in made.items():
            put(mesh, uvs)
        yield
    finally:
        for mesh, uvs in before.items():
            if uvs is not None:
                put(mesh, uvs)
            elif NAME in mesh.uv_layers:
                mesh.uv_layers.remove(mesh.uv_layers[NAME])


def unwrapping(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    objects: Sequence[str],
    resolution: int,
    padding: int,
    density: float,
    together: bool,
) -> Iterator[tuple[str, float]]:
    """Lightmap UVs for the meshes that lack them, (corners, 2) float32 each; arguments as for `make`. A generator of
    (stage, fraction of it), "unwrap" and "overlaps"; what follows the latter touches nothing of Blender.

    Nothing in the file changes.
    """
    users = [
        obj
        for obj in view_layer.objects
        if obj  # just deleted
        and obj.type == "MESH"
        and (obj.name in objects if objects else object_options(obj).use and not obj.hide_render)
        and obj.data.polygons
    ]
    lacking = yield from _lacking([m for m in {obj.data: None for obj in users} if why_not(m) is None])
    if not lacking:
        return {}
    areas = np.array([_area(obj) for obj in users])
    factors = np.array([object_options(obj).lightmap_factor for obj in users])
    filled, uvs, margins = dict.fromkeys(lacking, _FILLED), {}, {}
    for round_ in range(_ROUNDS):
        if together or density:
            fills = np.array([filled.get(obj.data) or _filled(obj.data) for obj in users])
            sides = expected_sides(areas, fills, factors, resolution, density)
        else:
            sides = resolution * factors
        for k, mesh in enumerate(lacking):
            # Where several share a mesh the least of their lightmaps needs the widest gaps.
            side = min(side for obj, side in zip(users, sides) if obj.data == mesh)
            if padding / side > margins.get(mesh, 0):
                yield "unwrap", (round_ + k / len(lacking)) / _ROUNDS
                margins[mesh] = _SPARE * padding / side
                with _workplace() as place, _copy(next(o for o in users if o.data == mesh), place) as copy:
                    uvs[mesh], filled[mesh] = _unwrap(copy, margins[mesh], place)
    return uvs


unwrapped = whole(unwrapping)


def _lacking(meshes: list[bpy.types.Mesh]) -> Iterator[tuple[str, float]]:
    """The meshes on whose map lightmaps cannot lie. A generator of progress."""
    names = [chosen(mesh) for mesh in meshes]
    maps = [_triangles(mesh, read(mesh, name)) if name else None for mesh, name in zip(meshes, names)]
    fit = []
    for k, uvs in enumerate(maps):
        yield "overlaps", k / len(maps)
        fit.append(uvs is not None and _usable(uvs))
    yield "unwrap", 0.0
    return [mesh for mesh, fits in zip(meshes, fit) if not fits]


def why_not(mesh: bpy.types.Mesh, name: str = NAME) -> tuple[str, str] | None:
    """Why a mesh cannot be given a UV map, and the remedy; None where it can."""
    if mesh.library is not None or mesh.override_library is not None:
        return "its mesh comes from another file", "Unwrap it there, or make it local."
    if mesh.is_editmode:
        return "it is in edit mode", "Leave edit mode."
    if name not in mesh.uv_layers and len(mesh.uv_layers) >= 8:
        return "it has eight UV maps, and Blender allows no more", "Remove one."
    return None


def put_all(made: dict[bpy.types.Mesh, np.ndarray]) -> None:
    """Stores UV maps, mesh -> (corners, 2) float32. Raises ValueError before the first is touched where a mesh has
    another number of corners, or cannot be given a map."""
    for mesh, uvs in made.items():
        if reason := why_not(mesh):
            raise ValueError(f"the mesh '{mesh.name}' cannot be given lightmap UVs, {reason[0]}: {reason[1]}")
        if len(uvs) != len(mesh.loops):
            raise ValueError(f"the mesh '{mesh.name}' was changed while it was baked: bake it again")
    for mesh, uvs in made.items():
        put(mesh, uvs)


def put(mesh: bpy.types.Mesh, uvs: np.ndarray, name: str = NAME) -> None:
    """Stores (corners, 2) float32 as a UV map; the active one and the one that renders stay as they are."""
    layer = mesh.uv_layers.get(name) or mesh.uv_layers.new(name=name, do_init=False)
    layer.uv.foreach_set("vector", np.ascontiguousarray(uvs, np.float32).ravel())
    mesh.update()


def read(mesh: bpy.types.Mesh, name: str) -> np.ndarray:
    """A UV map's coordinates, (corners, 2) float32."""
    uvs = np.empty((len(mesh.loops), 2), np.float32)
    mesh.uv_layers[name].uv.foreach_get("vector", uvs.ravel())
    return uvs


def _usable(uvs: np.ndarray) -> bool:
    """Whether lightmaps can lie on a map, of UV triangles (t, 3, 2)."""
    return bool(_area_of(uvs) > 0 and outside(uvs) <= TOLERANCE and overlap(uvs, ROUGHLY) <= TOLERANCE)


def chosen(mesh: bpy.types.Mesh) -> str:
    """Name of the map that lightmaps are put on, "" where there is none."""
    return next((layer.name for layer in (mesh.uv_layers.get(NAME), mesh.uv_layers.active) if layer), "")


def _filled(mesh: bpy.types.Mesh) -> float:
    """Share of the unit square that a mesh's lightmap UVs cover."""
    name = chosen(mesh)
    return _area_of(_triangles(mesh, read(mesh, name))) if name else _FILLED


def _area_of(uvs: np.ndarray) -> float:
    """Of UV triangles (t, 3, 2)."""
    a, b = uvs[:, 1] - uvs[:, 0], uvs[:, 2] - uvs[:, 0]
    return float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(dtype=np.float64) / 2)


def _triangles(mesh: bpy.types.Mesh, uvs: np.ndarray) -> np.ndarray:
    mesh.calc_loop_triangles()
    corners = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("loops", corners.ravel())
    return uvs[corners]


def _area(obj: bpy.types.Object) -> float:
    """Of an object's surface in the world, before modifiers [m²]."""
    mesh = obj.data
    points = np.empty((len(mesh.vertices), 3), np.float32)
    mesh.vertices.foreach_get("co", points.ravel())
    points = points @ np.array(obj.matrix_world, np.float32)[:3, :3].T
    mesh.calc_loop_triangles()
    corners = np.empty((len(mesh.loop_triangles), 3), np.int32)
    mesh.loop_triangles.foreach_get("vertices", corners.ravel())
    a, b, c = np.moveaxis(points[corners], 1, 0)
    return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum(dtype=np.float64) / 2)


@contextlib.contextmanager
def _workplace() -> Iterator[bpy.types.Scene]:
    """A scene to edit in, without anything of the user's."""
    place = bpy.data.scenes.new("GI Bake")
    # What is selected on the mesh is selected on its UVs.
    place.tool_settings.use_uv_select_sync = True
    try:
        yield place
    finally:
        bpy.data.scenes.remove(place)


@contextlib.contextmanager
def _copy(obj: bpy.types.Object, place: bpy.types.Scene) -> Iterator[bpy.types.Object]:
    """An object's mesh as it is in the world, with one UV map."""
    mesh = obj.data.copy()
    stand_in = bpy.data.objects.new("GI Bake", mesh)
    try:
        place.collection.objects.link(stand_in)
        stand_in.shape_key_clear()
        mesh.transform(obj.matrix_world)
        while mesh.uv_layers:
            mesh.uv_layers.remove(mesh.uv_layers[0])
        mesh.uv_layers.new(name=NAME)
        yield stand_in
    finally:
        bpy.data.objects.remove(stand_in)
        bpy.data.meshes.remove(mesh)


def _unwrap(copy: bpy.types.Object, margin: float, place: bpy.types.Scene) -> tuple[np.ndarray, float]:
    """Lightmap UVs of a mesh, (corners, 2), and their area; margin: what stays free around each island.

    Where the islands have no room it is less.
    """
    for angle in _ANGLES:
        while True:
            _project(copy, angle, margin, place)
            uvs = read(copy.data, NAME)
            triangles = _triangles(copy.data, uvs)
            filled = _area_of(triangles)
            if (filled >= _LEAST and not outside(triangles)) or not margin:
                break
            margin = margin * 0.7 if margin > 1e-4 else 0.0
        if not overlap(triangles):
            break
    return uvs, filled


def _project(copy: bpy.types.Object, angle: float, margin: float, place: bpy.types.Scene) -> None:
    layer = place.view_layers[0]
    for obj in place.objects:
        obj.select_set(obj == copy, view_layer=layer)
    layer.objects.active = copy
    chosen = {"active_object": copy, "object": copy, "selected_objects": [copy]}
    with bpy.context.temp_override(scene=place, view_layer=layer, **chosen):
        bpy.ops.object.mode_set(mode="EDIT")
        with bpy.context.temp_override(edit_object=copy):
            bpy.ops.mesh.reveal()
            bpy.ops.mesh.select_all(action="SELECT")
            bpy.ops.uv.smart_project(angle_limit=math.radians(angle), island_margin=margin, margin_method="FRACTION")
        bpy.ops.object.mode_set(mode="OBJECT")
