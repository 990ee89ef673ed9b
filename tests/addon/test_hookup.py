# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Lightmaps shown by materials: what Cycles renders of them, and every trace taken away again."""

import json

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_passes, camera_reference
from gi_bake.addon.job import Job
from gi_bake.addon.result import Light, Result
from gi_bake.addon.write import hookup, lightmap_uvs
from gi_bake.addon.write.attributes import write_corners, write_irradiance
from gi_bake.addon.write.results import store
from gi_bake.gi_core.atlas import Page, Place
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.tiles import finish


def tree_state(tree):
    """All that a node tree says."""
    def value(socket):
        found = getattr(socket, "default_value", None)
        return tuple(found) if hasattr(found, "__len__") and not isinstance(found, str) else found

    nodes = {
        n.name: (
            n.bl_idname, tuple(n.location), n.width, n.label, n.mute, n.hide, n.parent and n.parent.name,
            [(s.identifier, value(s)) for s in n.inputs], [(s.identifier, value(s)) for s in n.outputs],
            {p.identifier: str(getattr(n, p.identifier)) for p in n.bl_rna.properties
             if p.type in {"ENUM", "BOOLEAN", "INT", "FLOAT", "STRING", "POINTER"}
             and p.identifier not in {"select", "location_absolute", "dimensions"} and not p.is_readonly},
        )
        for n in tree.nodes
    }  # fmt: skip
    links = sorted(
        (link.from_node.name, link.from_socket.identifier, link.to_node.name, link.to_socket.identifier)
        for link in tree.links
    )
    return nodes, links, tree.nodes.active and tree.nodes.active.name


def file_state():
    trees = {("material", m.name): tree_state(m.node_tree) for m in bpy.data.materials if m.node_tree}
    trees |= {("group", g.name): tree_state(g) for g in bpy.data.node_groups}
    meshes = {m.name: ([layer.name for layer in m.uv_layers], sorted(m.keys())) for m in bpy.data.meshes}
    slots = {o.name: [(s.link, s.material and s.material.name) for s in o.material_slots] for o in bpy.data.objects}
    return trees, meshes, slots


def with_lightmaps(scene, atlas="all", light="combined", names=None):
    """Lightmaps of one colour each in the file, as if they were baked: object name -> colour (3,)."""
    names = names or [o.name for o in scene.objects if o.type == "MESH" and not o.hide_render]
    random = np.random.default_rng(5)
    colors = {name: random.uniform(0.2, 1.0, 3).astype(np.float32) for name in names}
    side, n = 8, int(np.ceil(np.sqrt(len(names))))
    uv = {name: scene.objects[name].data.uv_layers.active.name for name in names}
    pages, lights = [], {}
    if atlas == "all":
        cell = side + 2
        image = np.zeros((n * cell, n * cell, 3), np.float32)
        places = [Place(name, uv[name], k % n * cell + 1, k // n * cell + 1, side) for k, name in enumerate(names)]
        for place in places:
            image[place.y - 1 : place.y + side + 1, place.x - 1 : place.x + side + 1] = colors[place.name]
        pages, lights = [Page("all", n * cell, n * cell, tuple(places))], {"all": image}
    else:
        pages = [Page(name, side, side, (Place(name, uv[name], 0, 0, side),)) for name in names]
        lights = {name: np.broadcast_to(colors[name], (side, side, 3)).copy() for name in names}
    whole = {
        k: Light(np.zeros_like(v), v, *(np.ones(v.shape[:2], bool),) * 3) if light != "direct" else
        Light(v, np.zeros_like(v), *(np.ones(v.shape[:2], bool),) * 3)
        for k, v in lights.items()
    }  # fmt: skip
    job = Job(target="lightmap", settings=RsmSettings(light=light))
    store(Result(job, {}, whole, "cpu", {}, (), (), pages=tuple(pages)), scene)
    return colors


@pytest.fixture
def room(sample):
    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    return bpy.context.scene


def seen(scene):
    """What Cycles renders of emission, and which object's colour each pixel has: (h, w, 3) twice."""
    found = camera_reference(scene, bpy.context.view_layer, 1, 1, 3, (64, 64), antialias=False)
    return found["Emission"], found["Diffuse Color"]


@pytest.mark.parametrize("atlas", ["all", "object"])
def test_cycles_shows_each_object_its_own_light_through_one_material(room, atlas):
    _, albedo = seen(room)
    materials = {m.name for m in bpy.data.materials}
    if atlas == "object":
        # Seven images with four materials: each chooses by its object.
        assert len([o for o in room.objects if o.type == "MESH"]) == 7
    colors = with_lightmaps(room, atlas)
    before = file_state()
    names = hookup.apply(room)
    assert names and set(names) <= materials and {m.name for m in bpy.data.materials} == materials
    emission, rest = seen(room)
    # Baked light is all there is, and it is one of the objects' colours times the surface's own.
    lit = albedo.any(-1)
    assert not rest[lit].any() and lit.mean() > 0.9
    ratio = emission[lit] / albedo[lit]
    near = np.min([np.abs(ratio - color).max(-1) for color in colors.values()], axis=0)
    assert np.mean(near < 0.02) > 0.98
    seen_colors = [np.mean(np.abs(ratio - color).max(-1) < 0.02) for color in colors.values()]
    assert sum(share > 0.005 for share in seen_colors) >= 6
    assert hookup.remove(room) == names
    assert file_state() == before
    assert not seen(room)[0].any()


def test_indirect_light_is_added_to_what_is_there(room):
    names = with_lightmaps(room, light="indirect")
    hookup.apply(room)
    emission, albedo = seen(room)
    lit = albedo.any(-1)
    ratio = emission[lit] / albedo[lit]
    near = np.min([np.abs(ratio - color).max(-1) for color in names.values()], axis=0)
    assert lit.mean() > 0.9 and np.mean(near < 0.02) > 0.98


def with_vertex_light(scene, names, domain):
    """Light of one colour for each of some objects, at their vertices: object name -> colour (3,)."""
    random = np.random.default_rng(6)
    colors = {name: random.uniform(0.2, 1.0, 3).astype(np.float32) for name in names}
    meshes = {name: scene.objects[name].data for name in names}
    if domain == "point":
        write_irradiance({k: np.tile(np.pi * colors[k], (len(m.vertices), 1)) for k, m in meshes.items()})
    else:
        for mesh in meshes.values():
            mesh.calc_loop_triangles()
        corners = {k: np.array([t.vertices for t in m.loop_triangles]).ravel() for k, m in meshes.items()}
        write_corners({k: np.tile(np.pi * colors[k], (len(v), 1)) for k, v in corners.items()}, corners)
    for mesh in meshes.values():
        mesh["gi_lightmap_light"] = "combined"
    return colors


@pytest.mark.parametrize("domain", ["point", "corner"])
def test_cycles_shows_light_at_vertices_beside_lightmaps(room, domain):
    _, albedo = seen(room)
    lit = albedo.any(-1)
    maps = with_lightmaps(room, names=["Back wall", "Floor", "Short box"])
    vertices = with_vertex_light(room, ["Ceiling", "Left wall", "Right wall", "Tall box", "Floor"], domain)
    before = file_state()
    for preferred, shown in ((False, vertices | maps), (True, maps | vertices)):
        names = hookup.apply(room, vertices=preferred)
        emission, rest = seen(room)
        ratio = emission[lit] / albedo[lit]
        near = np.array([np.abs(ratio - color).max(-1) < 0.02 for color in shown.values()])
        assert not rest[lit].any() and np.mean(near.any(0)) > 0.98
        assert dict(zip(shown, near.mean(1)))["Floor"] > 0.05
    assert hookup.remove(room) == names and file_state() == before
    bpy.data.meshes["Floor"]["gi_lightmap_light"] = "indirect"
    with pytest.raises(hookup.HookupError, match="different light"):
        hookup.apply(room, vertices=True)


def test_bakes_and_references_see_materials_without_baked_light(room):
    def found():
        job = Job(resolution=16, settings=RsmSettings(samples=4, denoise="none", antialias=1))
        baked = finish(bake(room, bpy.context.view_layer, job)).layers["Combined"]
        work = hookup.unseen_by(camera_passes(room, bpy.context.view_layer, 4, 1, 3, (16, 16), go=2 * 16 * 16))
        next(work)
        assert not any(n.mute for m in bpy.data.materials if m.node_tree for n in m.node_tree.nodes)
        return baked, finish(work)["Diffuse Indirect"]

    baked, cycles = found()
    with_lightmaps(room)
    hookup.apply(room)
    again = found()
    assert baked.any() and np.array_equal(again[0], baked)
    assert cycles.any() and np.array_equal(again[1], cycles)


@pytest.mark.parametrize("name", ["materials", "props"])
def test_every_trace_goes_from_materials_of_all_kinds(sample, name):
    bpy.ops.wm.open_mainfile(filepath=str(sample(name)))
    scene = bpy.context.scene
    if name == "props":
        for obj in scene.objects:
            if obj.type == "MESH" and not obj.data.uv_layers:
                obj.data.uv_layers.new(name="UVMap")
    names = [o.name for o in scene.objects if o.type == "MESH" and o.data.uv_layers and len(o.data.polygons)]
    # Two on a map of their own, and one of which lies on the artist's.
    with_lightmaps(scene, names=names)
    for name in names[:2]:
        obj = scene.objects[name]
        lightmap_uvs.put(obj.data, lightmap_uvs.read(obj.data, obj.data.uv_layers.active.name))
        obj["gi_lightmap_uv"] = lightmap_uvs.NAME
    before = file_state()
    changed = hookup.apply(scene)
    assert len(changed) > 3 and file_state() != before
    assert hookup.apply(scene) == changed
    hookup.remove(scene)
    assert file_state() == before
    assert hookup.remove(scene) == []


def test_what_the_user_edits_in_between_stays(room):
    with_lightmaps(room)
    material = bpy.data.objects["Floor"].material_slots[0].material
    tree = material.node_tree
    hookup.apply(room)
    [group] = [n for n in tree.nodes if n.type == "GROUP"]
    output = next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL")
    # A mix behind the group, a copy of the material, a node of the user's, an object renamed, another deleted.
    mix = tree.nodes.new("ShaderNodeMixShader")
    tree.links.new(group.outputs[0], mix.inputs[1])
    tree.links.new(mix.outputs[0], output.inputs["Surface"])
    copy = material.copy()
    bpy.data.objects["Floor"].name = "Ground"
    bpy.data.objects.remove(next(o for o in room.objects if o.type == "MESH" and o.name != "Ground"))
    hookup.apply(room)
    hookup.remove(room)
    for tree in (material.node_tree, copy.node_tree):
        assert not [n for n in tree.nodes if n.type == "GROUP"]
        mix = next(n for n in tree.nodes if n.type == "MIX_SHADER")
        assert mix.inputs[1].links[0].from_node.type.startswith("BSDF")
    assert not bpy.data.node_groups and not [o for o in bpy.data.objects if "gi_lightmap_page" in o.keys()]
    # A group that was cut off leaves no link behind, and one whose tree is gone no error.
    hookup.apply(room)
    group = next(n for n in material.node_tree.nodes if n.type == "GROUP")
    material.node_tree.links.remove(group.inputs["Shader"].links[0])
    hookup.remove(room)
    assert not [n for n in material.node_tree.nodes if n.type == "GROUP"]


def test_what_cannot_be_shown_is_refused_before_anything_changes(room):
    with pytest.raises(hookup.HookupError, match="bake to lightmaps first"):
        hookup.apply(room)
    white = bpy.data.objects["Floor"].material_slots[0].material
    for k in range(9):
        copy = bpy.data.objects["Floor"].copy()
        copy.name = f"Floor {k}"
        room.collection.objects.link(copy)
        copy.material_slots[0].material = white
    with_lightmaps(room, atlas="object")
    before = file_state()
    with pytest.raises(hookup.HookupError, match="atlas=all"):
        hookup.apply(room)
    assert file_state() == before


def exported(folder):
    """The file that Blender's exporter writes, and its binary part."""
    path = folder / "scene.glb"
    bpy.ops.export_scene.gltf(filepath=str(path), export_format="GLB")
    data = path.read_bytes()
    size = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + size]), data[28 + size :]


@pytest.mark.parametrize("light", ["combined", "indirect"])
def test_gltf_gets_lightmaps_as_occlusion(room, tmp_path, light):
    for tree in {o.active_material.node_tree for o in room.objects if o.type == "MESH"}:
        # The exporter knows of no other surfaces.
        [diffuse] = [n for n in tree.nodes if n.type == "BSDF_DIFFUSE"]
        surface = tree.nodes.new("ShaderNodeBsdfPrincipled")
        surface.inputs["Base Color"].default_value = diffuse.inputs["Color"].default_value
        tree.links.new(surface.outputs[0], diffuse.outputs[0].links[0].to_socket)
        tree.nodes.remove(diffuse)
    glowing = room.objects["Tall box"].active_material.node_tree.nodes["Principled BSDF"]
    glowing.inputs["Emission Color"].default_value = 0.1, 0.4, 0, 1
    glowing.inputs["Emission Strength"].default_value = 1
    plain, _ = exported(tmp_path)
    with_lightmaps(room, light=light)
    before = file_state(), sorted(bpy.data.images.keys())
    hookup.apply(room, gltf=True)
    document, binary = exported(tmp_path)

    def array(index):
        accessor = document["accessors"][index]
        view = document["bufferViews"][accessor["bufferView"]]
        start = view.get("byteOffset", 0) + accessor.get("byteOffset", 0)
        return np.frombuffer(binary, np.float32, 2 * accessor["count"], start).reshape(-1, 2)

    surfaces = {m["name"]: m for m in plain["materials"]}
    assert len({str(m["pbrMetallicRoughness"]["baseColorFactor"]) for m in plain["materials"]}) > 2
    places = {obj.name: obj["gi_lightmap"] for obj in room.objects if "gi_lightmap" in obj}
    nodes = [node for node in document["nodes"] if node["name"] in places]
    assert len(nodes) == 7
    occlusions = {}
    assert any(np.allclose(m.get("emissiveFactor", 0), (0.1, 0.4, 0)) for m in document["materials"])
    for node in nodes:
        [primitive] = document["meshes"][node["mesh"]]["primitives"]
        material = document["materials"][primitive["material"]]
        occlusion = material.pop("occlusionTexture") if "occlusionTexture" in material else occlusions[material["name"]]
        occlusions[material["name"]] = occlusion
        # All else is as it was.
        assert material == surfaces[material["name"]]
        uvs = array(primitive["attributes"][f"TEXCOORD_{occlusion['texCoord']}"])
        width, height, x, y = places[node["name"]]
        # glTF counts from the top.
        low, high = np.array([x, 1 - y - height]), np.array([x + width, 1 - y])
        assert (uvs >= low - 1e-4).all() and (uvs <= high + 1e-4).all() and np.ptp(uvs, axis=0).min() > 0.5 * width
        texture = document["textures"][occlusion["index"]]
        assert document["images"][texture["source"]]["name"].startswith("all Lightmap glTF")
    assert len(document["images"]) == 1
    hookup.remove(room)
    assert (file_state(), sorted(bpy.data.images.keys())) == before
    assert not any("occlusionTexture" in m for m in exported(tmp_path)[0]["materials"])


def test_gltf_refuses_what_it_cannot_tell_and_keeps_the_artists_occlusion(room, tmp_path):
    with_lightmaps(room, atlas="object")
    before = file_state()
    with pytest.raises(hookup.HookupError, match=r"lie on \d lightmaps, and a glTF material has one.*atlas=all"):
        hookup.apply(room, gltf=True)
    assert file_state() == before
    hookup.clear(room)
    tree = room.objects["Floor"].active_material.node_tree
    group = bpy.data.node_groups.new("glTF Material Output.001", "ShaderNodeTree")
    group.interface.new_socket("Occlusion", in_out="INPUT", socket_type="NodeSocketFloat")
    own, mine = tree.nodes.new("ShaderNodeGroup"), tree.nodes.new("ShaderNodeTexImage")
    own.node_tree, mine.image = group, bpy.data.images.new("mine", 4, 4)
    link = tree.links.new(mine.outputs[0], own.inputs["Occlusion"])
    with_lightmaps(room)
    before = file_state()
    hookup.apply(room, gltf=True)
    assert own.inputs["Occlusion"].links[0].from_node == mine
    hookup.remove(room)
    assert file_state() == before
    # One that is there and free is used, and is free again.
    tree.links.remove(link)
    before = file_state()
    hookup.apply(room, gltf=True)
    assert own.inputs["Occlusion"].links[0].from_node.image.name == "all Lightmap glTF"
    hookup.remove(room)
    assert file_state() == before
    room.objects["Short box"].data = room.objects["Tall box"].data
    with pytest.raises(hookup.HookupError, match="share a mesh"):
        hookup.apply(room, gltf=True)
