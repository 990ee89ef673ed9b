# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked light shown by the materials that are there, and taken out again.

Behind each diffuse BSDF comes a node group that puts the baked light over it, or adds it: light · colour as emission.
Where an object lies on its lightmap the group reads from the object (see `placement`), so one material stays one
material whatever it is on; light at vertices it reads from the mesh's attribute. Objects without either look as before.
Works in EEVEE and Cycles. Bakes and comparisons see the materials as they are without it.
"""

import contextlib
import logging
from collections.abc import Iterator
from typing import NamedTuple

import bpy

from ..sentence import Sentence
from . import hookup_gltf, lightmap_uvs
from .attributes import ATTRIBUTE, CORNERS
from .images import MARK
from .placement import LIGHT, PLACE, SCENE, Placement, forget, placement, shows_light

NAME = "GI Lightmap"

# On an object: which of a group's sources is its own, from 1.
_PAGE = "gi_lightmap_page"

# On a mesh: its lightmap UVs are a copy of another map, made here.
_COPIED = "gi_lightmap_copied"

# Of irradiance to what images hold.
_OVER_PI = 0.318309886

# Images that one material may choose from: graphics cards have some thirty, and the artist's count too.
_MOST = 8

# BSDFs with a diffuse part: socket of the group -> theirs.
_INPUTS = {
    "BSDF_DIFFUSE": {"Color": "Color"},
    "SUBSURFACE_SCATTERING": {"Color": "Color"},
    "BSDF_PRINCIPLED": {
        "Color": "Base Color",
        "Metallic": "Metallic",
        "Transmission": "Transmission Weight",
        "Alpha": "Alpha",
    },
}

# What a surface sends out by itself: socket of an Emission node -> of the BSDF. The node stands beside the group, since
# Blender's glTF exporter takes the first that it finds, and nothing that lies in groups, for the material's emission.
_GLOW = {"Color": "Emission Color", "Strength": "Emission Strength"}
_GLOWS = "gi_lightmap_glow"

_log = logging.getLogger(__name__)


class HookupError(ValueError):
    """Baked light cannot be shown; the message says why and what helps."""


class Vertices(NamedTuple):
    """Light at vertices. attribute: that it is in. kind: which light it is, as the setting `light` says."""

    attribute: str
    kind: str

    @property
    def name(self) -> str:
        return f"{self.attribute} {self.kind}"


# Where a material may find an object's light.
Source = bpy.types.Image | Vertices


def apply(scene: bpy.types.Scene, gltf: bool = False, vertices: bool = False) -> list[str]:
    """Makes the scene's materials show its lightmaps and light at vertices; names of the materials. Done before, it is
    done anew.

    gltf: lightmaps for Blender's glTF exporter too, as occlusion, see `hookup_gltf`. vertices: objects that have both
    show the light at their vertices.
    Left alone are linked materials, those without nodes and those without a diffuse BSDF.
    Raises HookupError, before anything changes, where there is no light, where one material would have to choose from
    too many images, or where they hold different kinds of light.
    """
    places = {obj: found for obj in scene.objects if (found := placement(obj))}
    lit = {obj: found for obj in scene.objects if (found := vertex_light(obj)) and (vertices or obj not in places)}
    places = {obj: found for obj, found in places.items() if obj not in lit}
    sources = {obj: found.image for obj, found in places.items()} | lit
    if not sources:
        said = Sentence(
            "no object of scene '{scene}' has a lightmap or light at its vertices: bake to lightmaps first, or to "
            "vertices", scene=scene.name,
        )  # fmt: skip
        raise HookupError(said)
    if gltf and not places:
        raise HookupError(Sentence("glTF takes lightmaps only: bake to lightmaps first"))
    wanted = _trees(sources)
    for tree, found in wanted.items():
        if len(found) > _MOST:
            said = Sentence(
                "objects with the material '{material}' lie on {count} lightmaps, and a material can show {most}: bake "
                "with the setting atlas=all", material=tree.name, count=len(found), most=_MOST,
            )  # fmt: skip
            raise HookupError(said)
        if len({_kind(source) for source in found}) > 1:
            said = Sentence(
                "objects with the material '{material}' hold different light: bake them alike", material=tree.name
            )
            raise HookupError(said)
    materials: dict[bpy.types.Material, set] = {}
    for obj, found in places.items() if gltf else ():
        for material in _materials(obj):
            materials.setdefault(material, set()).add(found.image)
    if gltf and (reason := hookup_gltf.why_not(places, materials)):
        raise HookupError(reason)
    uv = _common_uv(places)
    remove(scene)
    if gltf:
        hookup_gltf.add(scene, places, materials)
    if uv == lightmap_uvs.NAME:
        _copy_uvs(places)
    number = {source: 1 + k for k, source in enumerate(_in_order(sources))}
    for obj, source in sources.items():
        obj[_PAGE] = float(number[source])
        obj.update_tag()
    groups: dict[tuple[str, ...], bpy.types.NodeTree] = {}
    changed = set()
    for tree, found in wanted.items():
        nodes = [node for node in tree.nodes if node.type in _INPUTS and node.outputs[0].is_linked]
        if not nodes:
            continue
        key = tuple(source.name for source in found)
        if key not in groups:
            groups[key] = _group(scene, {number[source]: source for source in found}, uv)
        for node in nodes:
            _insert(tree, node, groups[key])
        changed.add(tree)
    return sorted({m.name for obj in sources for m in _materials(obj) if changed & set(_nested(m.node_tree))})


def remove(scene: bpy.types.Scene) -> list[str]:
    """Takes everything away that `apply` made for a scene; names of the materials that it was taken from.

    What the user changed in between stays: where a group stood, what led into it leads on to where it led.
    """
    hookup_gltf.remove(scene)
    groups = {g for g in bpy.data.node_groups if SCENE in g.keys() and g[SCENE] in (scene, None)}
    changed = set()
    for tree in _every_tree():
        for node in [n for n in tree.nodes if n.type == "GROUP" and n.node_tree in groups]:
            _bypass(tree, node)
            changed.add(tree)
    names = sorted(m.name for m in bpy.data.materials if m.node_tree and changed & set(_nested(m.node_tree)))
    bpy.data.batch_remove(list(groups))
    for obj in scene.objects:
        if _PAGE in obj.keys():
            del obj[_PAGE]
            obj.update_tag()
        mesh = obj.data
        if obj.type == "MESH" and _COPIED in mesh.keys():
            del mesh[_COPIED]
            if lightmap_uvs.NAME in mesh.uv_layers:
                mesh.uv_layers.remove(mesh.uv_layers[lightmap_uvs.NAME])
    return names


def clear(scene: bpy.types.Scene) -> list[str]:
    """Takes away what a bake of lightmaps put into the file too: images, UV maps that were made, and what objects
    remember; names of the objects."""
    remove(scene)
    names, images, meshes = [], set(), set()
    for obj in scene.objects:
        found = placement(obj)
        if found:
            images.add(found.image)
        if forget(obj):
            names.append(obj.name)
            meshes.add(obj.data)
    still = {found.image for obj in bpy.data.objects if (found := placement(obj))}
    marks = {image[MARK].removesuffix(" Lightmap") for image in images - still if image.get(MARK)}
    every = {f"{mark} {what}" for mark in marks for what in ("Lightmap", "Coverage", *(f"SH {k}" for k in range(4)))}
    bpy.data.batch_remove([i for i in bpy.data.images if i.get(MARK) in every and i.library is None])
    shared = {obj.data for obj in bpy.data.objects if placement(obj)}
    for mesh in meshes - shared:
        if isinstance(mesh, bpy.types.Mesh) and lightmap_uvs.NAME in mesh.uv_layers and mesh.library is None:
            mesh.uv_layers.remove(mesh.uv_layers[lightmap_uvs.NAME])
    return names


@contextlib.contextmanager
def muted():
    """Materials as they are without baked light."""
    nodes = [node for tree in _every_tree() for node in tree.nodes if shows_light(node) and not node.mute]
    try:
        for node in nodes:
            node.mute = True
        yield
    finally:
        for node in nodes:
            node.mute = False


def unseen_by(work: Iterator) -> Iterator:
    """Work, a generator, whose steps find materials as they are without baked light; between them they show it."""
    try:
        while True:
            with muted():
                try:
                    step = next(work)
                except StopIteration as stop:
                    return stop.value
            yield step
    finally:
        work.close()


def vertex_light(obj: bpy.types.Object) -> Vertices | None:
    """An object's light at vertices, None where it has none."""
    if obj.type != "MESH" or LIGHT not in obj.data.keys():
        return None
    attribute = next((name for name in (ATTRIBUTE, CORNERS) if name in obj.data.attributes), None)
    return attribute and Vertices(attribute, obj.data[LIGHT])


def _kind(source: Source) -> str:
    """Which light it is."""
    return source.kind if isinstance(source, Vertices) else source.get(LIGHT, "combined")


def _in_order(sources: dict[bpy.types.Object, Source]) -> list[Source]:
    """All of them, in the order of their numbers."""
    return sorted(set(sources.values()), key=lambda source: source.name)


def _materials(obj: bpy.types.Object) -> list[bpy.types.Material]:
    """An object's materials that can be changed."""
    found = []
    for slot in obj.material_slots:
        material = slot.material
        if material is None or material.node_tree is None or not (bpy.app.version >= (5, 0) or material.use_nodes):
            _log.warning("Object '%s': a slot without a material of nodes shows no lightmap", obj.name)
        elif material.library is not None:
            _log.warning("Material '%s' comes from another file and shows no lightmap", material.name)
        else:
            found.append(material)
    return found


def _trees(sources: dict[bpy.types.Object, Source]) -> dict[bpy.types.NodeTree, list[Source]]:
    """The node trees of objects' materials, with what they are to show, in the order of their numbers."""
    shown: dict[bpy.types.NodeTree, set] = {}
    for obj, source in sources.items():
        for material in _materials(obj):
            for tree in _nested(material.node_tree):
                shown.setdefault(tree, set()).add(source)
    order = _in_order(sources)
    return {tree: sorted(found, key=order.index) for tree, found in shown.items()}


def _nested(tree: bpy.types.NodeTree) -> Iterator[bpy.types.NodeTree]:
    """A tree and those of the groups in it that can be changed, but not ours."""
    yield tree
    for node in tree.nodes:
        inner = getattr(node, "node_tree", None)
        if node.type == "GROUP" and inner and inner.library is None and SCENE not in inner.keys():
            yield from _nested(inner)


def _every_tree() -> Iterator[bpy.types.NodeTree]:
    """All shader trees of the file that can be changed."""
    yield from (m.node_tree for m in bpy.data.materials if m.node_tree and m.library is None)
    yield from (g for g in bpy.data.node_groups if g.type == "SHADER" and g.library is None)


def _common_uv(places: dict[bpy.types.Object, Placement]) -> str:
    """The UV map that all lightmaps are looked up on. Raises HookupError where a mesh has no room for it."""
    names = {found.uv for found in places.values()}
    if len(names) == 1:
        return names.pop()
    for obj, found in places.items():
        if found.uv != lightmap_uvs.NAME and (reason := lightmap_uvs.why_not(obj.data)):
            raise HookupError(f"'{obj.name}' cannot be given lightmap UVs, {reason[0]}: {reason[1]}")
        if found.uv != lightmap_uvs.NAME and lightmap_uvs.NAME in obj.data.uv_layers and _COPIED not in obj.data.keys():
            raise HookupError(
                f"the lightmap of '{obj.name}' lies on UV map '{found.uv}' and that of others on "
                f"'{lightmap_uvs.NAME}': bake it again on that"
            )
    return lightmap_uvs.NAME


def _copy_uvs(places: dict[bpy.types.Object, Placement]) -> None:
    """Gives meshes whose lightmap lies on another map a copy of it under the common name."""
    for obj, found in places.items():
        if found.uv != lightmap_uvs.NAME and lightmap_uvs.NAME not in obj.data.uv_layers:
            lightmap_uvs.put(obj.data, lightmap_uvs.read(obj.data, found.uv))
            obj.data[_COPIED] = True


def _insert(tree: bpy.types.NodeTree, bsdf: bpy.types.Node, group: bpy.types.NodeTree) -> None:
    """Puts a group behind a BSDF."""
    targets = [link.to_socket for link in bsdf.outputs[0].links]
    node = tree.nodes.new("ShaderNodeGroup")
    node.node_tree, node.name, node.label = group, NAME, NAME
    node.select, node.parent = False, bsdf.parent
    node.location = bsdf.location[0] + bsdf.width + 20, bsdf.location[1]
    glow = tree.nodes.new("ShaderNodeEmission")
    glow[_GLOWS], glow.select, glow.parent, glow.location = True, False, bsdf.parent, node.location
    glow.location[1] -= 200
    glow.inputs["Strength"].default_value = 0.0
    tree.links.new(glow.outputs[0], node.inputs["Emission"])
    for made, names in ((node, _INPUTS[bsdf.type]), (glow, _GLOW)):
        for name, theirs in names.items():
            source = bsdf.inputs.get(theirs)
            if source and source.is_linked:
                tree.links.new(source.links[0].from_socket, made.inputs[name])
            elif source:
                made.inputs[name].default_value = source.default_value
    for target in targets:
        tree.links.new(node.outputs[0], target)
    tree.links.new(bsdf.outputs[0], node.inputs["Shader"])


def _bypass(tree: bpy.types.NodeTree, node: bpy.types.Node) -> None:
    """Takes a group out and joins what it stood between."""
    source = next((link.from_socket for link in node.inputs["Shader"].links), None) if len(node.inputs) else None
    targets = [link.to_socket for output in node.outputs for link in output.links]
    glows = {link.from_node for socket in node.inputs for link in socket.links if _GLOWS in link.from_node.keys()}
    for made in (node, *glows):
        tree.nodes.remove(made)
    for target in targets if source else ():
        tree.links.new(source, target)


def _group(scene: bpy.types.Scene, sources: dict[int, Source], uv: str) -> bpy.types.NodeTree:
    """The node group that shows some light, number -> source."""
    tree = bpy.data.node_groups.new(NAME, "ShaderNodeTree")
    tree[SCENE] = scene
    sockets = tree.interface
    sockets.new_socket("Shader", in_out="OUTPUT", socket_type="NodeSocketShader")
    sockets.new_socket("Shader", in_out="INPUT", socket_type="NodeSocketShader")
    sockets.new_socket("Emission", in_out="INPUT", socket_type="NodeSocketShader")
    for name, kind, value in (
        ("Color", "NodeSocketColor", (0.8, 0.8, 0.8, 1.0)),
        ("Metallic", "NodeSocketFloat", 0.0),
        ("Transmission", "NodeSocketFloat", 0.0),
        ("Alpha", "NodeSocketFloat", 1.0),
    ):
        sockets.new_socket(name, in_out="INPUT", socket_type=kind).default_value = value
    nodes, link = tree.nodes, tree.links.new

    def node(kind, column, *inputs, **attributes):
        made = nodes.new(kind)
        made.location = 200 * column, -160 * sum(1 for n in nodes if n.location[0] == 200 * column)
        for name, value in attributes.items():
            setattr(made, name, value)
        for socket, value in zip((s for s in made.inputs if s.enabled), inputs):
            if isinstance(value, bpy.types.NodeSocket):
                link(value, socket)
            elif value is not None:
                socket.default_value = value
        return made

    def math(operation, column, *inputs):
        return node("ShaderNodeMath", column, *inputs, operation=operation).outputs[0]

    def vector(operation, column, *inputs):
        return node("ShaderNodeVectorMath", column, *inputs, operation=operation).outputs[0]

    given = node("NodeGroupInput", 0).outputs
    place = node("ShaderNodeAttribute", 0, attribute_type="OBJECT", attribute_name=PLACE).outputs
    number = node("ShaderNodeAttribute", 0, attribute_type="OBJECT", attribute_name=_PAGE).outputs["Fac"]
    x, y, z = node("ShaderNodeSeparateXYZ", 1, place["Vector"]).outputs
    scale = node("ShaderNodeCombineXYZ", 2, x, y).outputs[0]
    offset = node("ShaderNodeCombineXYZ", 2, z, place["Alpha"]).outputs[0]
    there = vector("MULTIPLY_ADD", 3, node("ShaderNodeUVMap", 2, uv_map=uv).outputs[0], scale, offset)
    light, has = None, None
    for page, source in sources.items():
        own = math("COMPARE", 4, number, float(page), 0.5)
        if isinstance(source, Vertices):
            found = node("ShaderNodeAttribute", 3, attribute_name=source.attribute).outputs["Color"]
            found = vector("MULTIPLY", 4, found, (_OVER_PI,) * 3)
        else:
            found = node("ShaderNodeTexImage", 4, there, image=source, extension="EXTEND").outputs["Color"]
        here = node("ShaderNodeVectorMath", 5, found, operation="SCALE")
        link(own, here.inputs["Scale"])
        light = here.outputs[0] if light is None else vector("ADD", 6, light, here.outputs[0])
        has = own if has is None else math("ADD", 6, has, own)

    diffuse = math("MULTIPLY", 7, math("SUBTRACT", 6, 1.0, given["Metallic"]),
                   math("SUBTRACT", 6, 1.0, given["Transmission"]))  # fmt: skip
    share = math("MULTIPLY", 8, diffuse, has)
    reflected = vector("MULTIPLY", 7, light, given["Color"])
    if _kind(next(iter(sources.values()))) == "combined":
        light = node("ShaderNodeEmission", 8, reflected).outputs[0]
        baked = node("ShaderNodeAddShader", 9, given["Emission"], light).outputs[0]
        clear = node("ShaderNodeBsdfTransparent", 9).outputs[0]
        solid = node("ShaderNodeMixShader", 10, given["Alpha"], clear, baked).outputs[0]
        shown = node("ShaderNodeMixShader", 11, share, given["Shader"], solid).outputs[0]
    else:
        strength = math("MULTIPLY", 9, share, given["Alpha"])
        added = node("ShaderNodeEmission", 10, reflected, strength).outputs[0]
        # That glows already.
        glowing = node("ShaderNodeMixShader", 10, 0.0, given["Shader"], given["Emission"]).outputs[0]
        shown = node("ShaderNodeAddShader", 11, glowing, added).outputs[0]
    node("NodeGroupOutput", 12, shown)
    return tree
