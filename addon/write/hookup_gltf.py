# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmaps where Blender's glTF exporter looks for them: as occlusion, through its group "glTF Material Output".

glTF has no lightmaps, but a texture of how much light arrives from around, on a UV map of its own: engines take that
as one. It is grey, 0…1, and a material has one, looked up where the mesh says and not the object. So each mesh gets a
UV map with its place on the image, and each image a picture of its light at one exposure for all.
"""

import logging
from collections.abc import Iterable

import bpy
import numpy as np

from ...gi_core import display
from . import lightmap_uvs
from .placement import Placement

UV = "GI glTF"

# What the exporter knows the group by, whatever follows in its name.
GROUP, _OLD, _INPUT = "glTF Material Output", "glTF Settings", "Occlusion"

# On what is made here: nodes, images and groups, with the scene whose lightmaps they show; meshes with the UV map.
_MADE = "gi_lightmap_gltf"

_log = logging.getLogger(__name__)

Materials = dict[bpy.types.Material, set[bpy.types.Image]]


def why_not(places: dict[bpy.types.Object, Placement], materials: Materials) -> str:
    """Why the exporter cannot be given the lightmaps of objects, and what helps; "" where it can."""
    for material, images in materials.items():
        if len(images) > 1:
            return (
                f"objects with the material '{material.name}' lie on {len(images)} lightmaps, and a glTF material has "
                "one: bake with the setting atlas=all"
            )
    for obj, found in places.items():
        other = next((o for o, p in places.items() if o.data == obj.data and p != found), None)
        if other:
            return (
                f"'{obj.name}' and '{other.name}' share a mesh and lie in different places of a lightmap, which glTF "
                "cannot tell: make them single-user (Object > Relations > Make Single User)"
            )
        reason = lightmap_uvs.why_not(obj.data, UV)
        if reason:
            return f"'{obj.name}' cannot be given UVs for glTF, {reason[0]}: {reason[1]}"
        if UV in obj.data.uv_layers and _MADE not in obj.data.keys():
            return f"'{obj.name}' has a UV map '{UV}' of its own: rename it"
    return ""


def add(scene: bpy.types.Scene, places: dict[bpy.types.Object, Placement], materials: Materials) -> None:
    """Puts lightmaps into the materials' trees for the exporter. A material with an occlusion of its own keeps it."""
    for obj, found in places.items():
        uvs = lightmap_uvs.read(obj.data, found.uv) * np.float32(found.scale) + np.float32(found.offset)
        lightmap_uvs.put(obj.data, uvs, UV)
        obj.data[_MADE] = scene
    pictures = _pictures(scene, {found.image for found in places.values()})
    for material, images in materials.items():
        tree = material.node_tree
        output = _output(scene, tree)
        if output.inputs[_INPUT].is_linked:
            _log.warning("Material '%s' has an occlusion of its own, which glTF gets", material.name)
            continue
        texture, uv = _node(scene, tree, "ShaderNodeTexImage"), _node(scene, tree, "ShaderNodeUVMap")
        texture.image, uv.uv_map = pictures[next(iter(images))], UV
        texture.location = output.location[0] - 300, output.location[1]
        uv.location = texture.location[0] - 200, texture.location[1]
        tree.links.new(uv.outputs[0], texture.inputs[0])
        tree.links.new(texture.outputs[0], output.inputs[_INPUT])


def remove(scene: bpy.types.Scene) -> None:
    """Takes all that `add` made for a scene away."""

    def ours(block) -> bool:
        return _MADE in block.keys() and block[_MADE] in (scene, None)

    for tree in [m.node_tree for m in bpy.data.materials if m.node_tree and m.library is None]:
        for node in [n for n in tree.nodes if ours(n)]:
            tree.nodes.remove(node)
    bpy.data.batch_remove([b for kind in (bpy.data.images, bpy.data.node_groups) for b in kind if ours(b)])
    for mesh in [m for m in bpy.data.meshes if ours(m)]:
        del mesh[_MADE]
        if UV in mesh.uv_layers:
            mesh.uv_layers.remove(mesh.uv_layers[UV])


def _pictures(scene: bpy.types.Scene, images: Iterable[bpy.types.Image]) -> dict[bpy.types.Image, bpy.types.Image]:
    """Each lightmap as the exporter can write it: luminance, 8 bits, white at the brightest hundredth of all."""
    read = {image: np.empty((image.size[1] * image.size[0], 4), np.float32) for image in images}
    for image, pixels in read.items():
        image.pixels.foreach_get(pixels.ravel())
    every = np.concatenate(list(read.values()))
    exposure = display.exposure_of(every, every[:, 3] > 0)
    made = {}
    for image, pixels in read.items():
        picture = bpy.data.images.new(f"{image.name} glTF", *image.size, is_data=True)
        picture[_MADE] = scene
        grey = np.clip(pixels[:, :3] @ display.LUMINANCE * np.float32(exposure), 0, 1)
        picture.pixels.foreach_set(np.column_stack([grey, grey, grey, np.ones_like(grey)]).ravel().astype(np.float32))
        picture.pack()
        made[image] = picture
    return made


def _output(scene: bpy.types.Scene, tree: bpy.types.NodeTree) -> bpy.types.Node:
    """The tree's own node that the exporter looks at, or one that is made."""
    for node in tree.nodes:
        if node.type == "GROUP" and node.node_tree and _INPUT in node.inputs:
            if node.node_tree.name.lower().startswith((GROUP.lower(), _OLD.lower())):
                return node
    group = bpy.data.node_groups.get((GROUP, None))
    if group is None or not any(socket.name == _INPUT for socket in group.interface.items_tree):
        group = bpy.data.node_groups.new(GROUP, "ShaderNodeTree")
        group[_MADE] = scene
        group.interface.new_socket(_INPUT, in_out="INPUT", socket_type="NodeSocketFloat")
        group.nodes.new("NodeGroupInput")
    node = _node(scene, tree, "ShaderNodeGroup")
    node.node_tree = group
    node.location = max((n.location[0] for n in tree.nodes), default=0), min(n.location[1] for n in tree.nodes) - 300
    return node


def _node(scene: bpy.types.Scene, tree: bpy.types.NodeTree, kind: str) -> bpy.types.Node:
    node = tree.nodes.new(kind)
    node[_MADE], node.select = scene, False
    return node
