# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What an object remembers of its lightmap: which image, on which UV map, and where on it.

Custom properties of the object, so that they are saved, go along when it is renamed or copied, and shader nodes can
read them: `gi_lightmap` holds scale and offset of the UVs, (u, v) · (x, y) + (z, w).
"""

from dataclasses import dataclass

import bpy

from ...gi_core.atlas import Page, Place

PLACE, IMAGE, UV = "gi_lightmap", "gi_lightmap_image", "gi_lightmap_uv"

# What the object's light was worked out from, see `rebake`.
HASH = "gi_lightmap_hash"

# On an image, or on a mesh with light at its vertices: which light it holds, as the setting `light` says.
LIGHT = "gi_lightmap_light"

# On a node group that shows baked light: the scene whose light it is.
SCENE = "gi_lightmap_scene"


@dataclass(frozen=True)
class Placement:
    """image: the lightmap. uv: name of the UV map. scale, offset: (2,) of the UVs, to those of the image."""

    image: bpy.types.Image
    uv: str
    scale: tuple[float, float]
    offset: tuple[float, float]


def remember(obj: bpy.types.Object, image: bpy.types.Image, page: Page, place: Place) -> None:
    """Writes down where an object lies."""
    width, height = page.width, page.height
    obj[PLACE] = [place.side / width, place.side / height, place.x / width, place.y / height]
    obj[IMAGE], obj[UV] = image, place.uv
    # Shaders and drivers see a new value only once the object is evaluated again.
    obj.update_tag()


def placement(obj: bpy.types.Object) -> Placement | None:
    """Where an object lies, None where it has no lightmap or its image or UV map is gone."""
    image, uv, place = obj.get(IMAGE), obj.get(UV), obj.get(PLACE)
    if obj.type != "MESH" or not isinstance(image, bpy.types.Image) or place is None or uv not in obj.data.uv_layers:
        return None
    x, y, z, w = place
    return Placement(image, uv, (x, y), (z, w))


def shows_light(node: bpy.types.Node) -> bool:
    """Whether a node shows baked light in the place of the shader that its input "Shader" gets, see `hookup`."""
    return node.type == "GROUP" and node.node_tree is not None and SCENE in node.node_tree.keys()


def forget(obj: bpy.types.Object) -> bool:
    """Takes the properties away; whether there were any."""
    there = [key for key in (PLACE, IMAGE, UV, HASH) if key in obj]
    for key in there:
        del obj[key]
    if there:
        obj.update_tag()
    return bool(there)
