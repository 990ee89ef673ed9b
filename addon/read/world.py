# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The world: a constant colour, an equirectangular image or what Cycles makes of its nodes as the surroundings."""

import bpy
import numpy as np
from mathutils import Euler

from ...gi_core.scene import Environment, Texture
from ..sentence import Sentence
from .colors import read_number
from .constants import estimate
from .images import ImageReader
from .nodes import Feed, Reading, node_tree, output_feed
from .sources import mean
from .surfaces import read_surface


def wants_panorama(world: bpy.types.World | None, images: ImageReader) -> bool:
    """Whether only a render can tell what light comes from where: of a sky, a gradient, a mix of images."""
    tree = world and node_tree(world)
    source = tree and output_feed(tree, "OUTPUT_WORLD", "Surface")
    if not source or not world.cycles_visibility.diffuse or not _has_texture(tree):
        return False
    return _image(source, Reading(f"World '{world.name}'", images, [])) is None


def _has_texture(tree: bpy.types.NodeTree) -> bool:
    """Whether anything in the tree or its groups may depend on the direction."""
    return any(
        node.type.startswith("TEX_") or (node.type == "GROUP" and node.node_tree and _has_texture(node.node_tree))
        for node in tree.nodes
    )


def read_environment(
    depsgraph: bpy.types.Depsgraph, images: ImageReader, notes: list[str], panorama: Texture | None = None
) -> Environment:
    """The world of `depsgraph` as an `Environment`; black where there is none.

    panorama: what the world looks like all around, where it `wants_panorama`; without it the mean colour is taken.
    """
    world = depsgraph.view_layer_eval.world_override or depsgraph.scene_eval.world
    if world is None:
        return Environment(np.zeros(3, np.float32))
    tree = node_tree(world)
    if not tree:
        return Environment(np.array(world.color[:], np.float32))
    reading = Reading(Sentence("World '{name}'", name=world.name), images, notes)
    source = output_feed(tree, "OUTPUT_WORLD", "Surface")
    if source is None or not world.cycles_visibility.diffuse:  # the latter: Cycles lights diffuse surfaces without it
        return Environment(np.zeros(3, np.float32))
    if panorama is not None:
        height, width = panorama.pixels.shape[:2]
        reading.note(
            Sentence("its nodes are taken as an image of {width} × {height} pixels", width=width, height=height)
        )
        return Environment(np.ones(3, np.float32), panorama)
    return _image(source, reading) or Environment(_mean_color(source, reading))


def _mean_color(source: Feed, reading: Reading) -> np.ndarray:
    color = read_surface(source, reading).emission
    if color.texture:
        reading.note(Sentence("image '{image}' is taken as its mean colour", image=color.texture.name))
    return mean(color).astype(np.float32)


def _image(source: Feed, reading: Reading) -> Environment | None:
    """The `Environment` of a Background node with an equirectangular image; None where the shader is anything else."""
    if source.node.type != "BACKGROUND":
        return None
    image = source.input("Color")
    if image.node is None or image.node.type != "TEX_ENVIRONMENT" or image.node.projection != "EQUIRECTANGULAR":
        return None
    rotation = _rotation(image.input("Vector"), reading)
    if rotation is None or image.node.image is None or image.node.image.source not in {"FILE", "GENERATED"}:
        return None
    strength = read_number(source.input("Strength"), reading, "its strength")
    return Environment(np.full(3, strength, np.float32), reading.images.texture(image.node, reading), rotation)


def _rotation(vector: Feed, reading: Reading) -> np.ndarray | None:
    """(3, 3) float64 from world directions to those the image is looked up at; None where it is no rotation."""
    node = vector.node
    match node and node.type:
        case None:
            return np.eye(3)
        case "TEX_COORD" if vector.socket.name in {"Generated", "Object"} and node.object is None:
            return np.eye(3)
        case "NEW_GEOMETRY" if vector.socket.name == "Position":
            return np.eye(3)
        case "MAPPING":
            inner = _rotation(vector.input("Vector"), reading)
            angles, doubt = estimate(vector.input("Rotation"), reading)
            scale, scale_doubt = estimate(vector.input("Scale"), reading)
            # A scale that is the same along each axis changes no direction.
            if inner is None or doubt or scale_doubt or not np.allclose(scale, scale[0]) or scale[0] <= 0:
                return None
            if node.vector_type in {"POINT", "TEXTURE"} and estimate(vector.input("Location"), reading)[0].any():
                return None
            turn = np.array(Euler(angles).to_matrix(), np.float64)
            return (turn.T if node.vector_type == "TEXTURE" else turn) @ inner
    return None
