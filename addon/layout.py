# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lightmaps a bake makes, how large, and which objects lie on which: known before any light is worked out."""

from collections.abc import Iterator, Sequence

import bpy
import numpy as np

from ..gi_core.atlas import MOST, Asked, Page, single, together
from ..gi_core.geometry import Geometry
from ..gi_core.settings import SettingError, Settings
from ..gi_core.tiles import parts, whole
from .object_options import object_options

# Side of a lightmap where none is asked for: of one object, of several [texels].
SIDE, ATLAS_SIDE = 256, 1024

# The least side of a lightmap of several that follows from a density.
_SMALL = 64


def is_shared(scene: bpy.types.Scene, settings: Settings) -> bool:
    """Whether any lightmap is for several objects."""
    return settings.atlas != "object" or any(object_options(obj).lightmap_group for obj in scene.objects)


def side(scene: bpy.types.Scene, resolution: int | None, settings: Settings) -> int:
    """Of a lightmap, where nothing else says it [texels]."""
    return resolution or (ATLAS_SIDE if is_shared(scene, settings) else SIDE)


def laying_out(
    geometry: Geometry,
    scene: bpy.types.Scene,
    names: Sequence[str],
    uv: str,
    resolution: int | None,
    settings: Settings,
) -> Iterator[tuple[str, float]]:
    """The lightmaps of objects. A generator of (stage, fraction of it), "layout" and "packing", of which the latter
    touches nothing of Blender; returns a list of Page.

    names: the objects. uv: their UV map, "" for each one's own choice. resolution: side of a lightmap, None for what
    the settings give.
    Raises SettingError where objects do not fit.
    """
    yield "layout", 0.0
    groups = {name: group(scene.objects[name], scene, settings) for name in names}
    factors = {name: object_options(scene.objects[name]).lightmap_factor for name in names}
    yield "packing", 0.0
    asked: dict[tuple[str, str], list[Asked]] = {}
    for name in names:
        asked.setdefault(groups[name], []).append(_asked(geometry, name, uv, factors[name]))
    made = _packed(asked, resolution, settings)
    yield "layout", 1.0
    return made


pages = whole(laying_out)


def _packed(groups: dict[tuple[str, str], list[Asked]], resolution: int | None, settings: Settings) -> list[Page]:
    made: list[Page] = []
    taken: set[str] = set()
    for (kind, label), asked in groups.items():
        name, number = label, 1
        while name in taken:
            number += 1
            name = f"{label} {number}"
        taken.add(name)
        try:
            if kind == "object":
                made.append(single(asked[0], resolution or SIDE, settings.density))
            else:
                made += _shared(name, asked, resolution, settings)
        except ValueError as error:
            raise SettingError(str(error)) from error
    return made


def _shared(name: str, asked: list[Asked], resolution: int | None, settings: Settings) -> list[Page]:
    if resolution or not settings.density:
        return together(name, asked, resolution or ATLAS_SIDE, settings.density, settings.room)
    # The smallest that all fit on, or else as many of the largest as it takes.
    size = _SMALL
    while size < MOST:
        try:
            [page] = together(name, asked, size, settings.density, settings.room)
            return [page]
        except ValueError:
            size *= 2
    return together(name, asked, MOST, settings.density, settings.room)


def group(obj: bpy.types.Object, scene: bpy.types.Scene, settings: Settings) -> tuple[str, str]:
    """Kind and name of the lightmap that an object lies on."""
    if group := object_options(obj).lightmap_group:
        return "group", group
    if settings.atlas == "collection":
        return "collection", next((c.name for c in obj.users_collection), scene.name)
    return ("all", scene.name) if settings.atlas == "all" else ("object", obj.name)


def _asked(geometry: Geometry, name: str, uv: str, factor: float) -> Asked:
    mesh, triangles = geometry.mesh_of(name)
    chosen = uv or mesh.active_uv
    uvs, filled = np.nan_to_num(mesh.uvs[chosen]), 0.0
    for part in parts(len(uvs)):
        a, b = (uvs[part, k].astype(np.float64) - uvs[part, 0] for k in (1, 2))
        filled += float(np.abs(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum() / 2)
    return Asked(
        name,
        chosen,
        area=float(geometry.areas[triangles].sum(dtype=np.float64)),
        filled=filled,
        low=np.clip(uvs.min((0, 1)), 0, 1).astype(np.float64),
        high=np.clip(uvs.max((0, 1)), 0, 1).astype(np.float64),
        factor=factor,
    )
