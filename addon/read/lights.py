# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lights, with everything that makes them brighter or dimmer folded into their power."""

import math

import bpy
import numpy as np

from ...gi_core.scene import Light
from ..sentence import Sentence
from .images import ImageReader
from .nodes import Reading, node_tree, output_feed
from .sources import mean
from .surfaces import read_surface


def read_lights(depsgraph: bpy.types.Depsgraph, images: ImageReader, notes: list[str]) -> list[Light]:
    """The lights of `depsgraph` that light diffuse surfaces, copies by instancing included."""
    lights = []
    for entry in depsgraph.object_instances:
        source = entry.object
        if source.type != "LIGHT" or not entry.show_self or not _lights_diffuse(source):
            continue
        light = read_light(source, np.array(entry.matrix_world, np.float64), images, notes)
        if light.power.any():
            lights.append(light)
    return lights


def read_light(source: bpy.types.Object, matrix: np.ndarray, images: ImageReader, notes: list[str]) -> Light:
    """`source`, an evaluated object with a light, at `matrix` (4, 4) as a `Light`."""
    data = source.data
    reading = Reading(Sentence("Light '{name}'", name=source.name), images, notes)
    if source.light_linking.receiver_collection or source.light_linking.blocker_collection:
        reading.note("light linking is left out: it shines on everything")
    power = data.energy * 2.0**data.exposure * np.array(data.color[:], np.float64)
    if data.use_temperature:
        power *= data.temperature_color[:]
    power *= _emission(data, reading)
    if not data.normalize:
        power *= _unit(data, matrix)
    shape = {}
    match data.type:
        case "POINT" | "SPOT":
            shape = {"radius": data.shadow_soft_size, "soft_falloff": data.use_soft_falloff}
            if data.type == "SPOT":
                shape |= {"spot_angle": data.spot_size, "spot_blend": data.spot_blend}
        case "AREA":
            kind = "ELLIPSE" if data.shape in {"DISK", "ELLIPSE"} else "RECTANGLE"
            shape = {"shape": kind, "size": _size(data), "spread": data.spread}
        case "SUN":
            shape = {"angle": data.angle}
    return Light(
        name=source.name,
        kind=data.type,
        matrix=matrix,
        power=power.astype(np.float32),
        shadow=data.use_shadow,
        **shape,
    )


def _size(data: bpy.types.AreaLight) -> tuple[float, float]:
    return data.size, data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size


def _unit(data: bpy.types.Light, matrix: np.ndarray) -> float:
    """What Blender's Normalize divides a light's strength by, and which is left in it without: measured on Cycles."""
    match data.type:
        case "AREA":
            full = np.prod(_size(data)) * np.prod(np.linalg.norm(matrix[:3, :2], axis=0))
            return full * (math.pi / 4 if data.shape in {"DISK", "ELLIPSE"} else 1.0)
        case "SUN":
            return math.pi * math.sin(data.angle / 2) ** 2 if data.angle else 1.0
    return 4 * math.pi * data.shadow_soft_size**2 if data.shadow_soft_size else 4.0


def _emission(data: bpy.types.Light, reading: Reading) -> np.ndarray:
    """Colour and strength of the light's Emission node, 1 where it has no nodes: (3,) float64."""
    tree = node_tree(data)
    if not tree:
        return np.ones(3)
    source = output_feed(tree, "OUTPUT_LIGHT", "Surface")
    if source is None:
        return np.zeros(3)
    color = read_surface(source, reading).emission
    if color.texture:
        reading.note(Sentence("its image '{image}' is taken as its mean colour", image=color.texture.name))
    return mean(color)


def _lights_diffuse(source: bpy.types.Object) -> bool:
    """Whether diffuse surfaces get light from it: no portal, which only guides the world's light, nor excluded."""
    return source.visible_diffuse and not (source.data.type == "AREA" and source.data.cycles.is_portal)
