# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects and meshes as the reader gives them, against what a render shows and Blender's own numbers."""

import time

import bpy
import numpy as np
import pytest
from gi_bake.addon.read import meshes, objects, read_scene
from mathutils import Matrix


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def read():
    return read_scene(bpy.context.scene, bpy.context.view_layer)


def link(data, name="object", collection=None, **attributes):
    thing = bpy.data.objects.new(name, data)
    for attribute, value in attributes.items():
        setattr(thing, attribute, value)
    (collection or bpy.context.scene.collection).objects.link(thing)
    return thing


def cube():
    mesh = bpy.data.meshes.new("cube")
    corners = [(x, y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    mesh.from_pydata(corners, [], [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return mesh


def world_area(scene, instance):
    mesh = scene.meshes[instance.mesh]
    points = mesh.vertices[mesh.triangles] @ instance.matrix[:3, :3].T
    return np.linalg.norm(np.cross(points[:, 1] - points[:, 0], points[:, 2] - points[:, 0]), axis=1).sum() / 2


def test_what_renders_is_read_and_nothing_else():
    scene = bpy.context.scene
    link(cube(), "plain")
    link(cube(), "eye").hide_set(True)
    link(cube(), "screen", hide_viewport=True)
    link(cube(), "no render", hide_render=True)
    flags = {"shown": None, "hidden": "hide_render", "excluded": "exclude", "off screen": "hide_viewport"}
    for name, flag in flags.items():
        collection = bpy.data.collections.new(name)
        scene.collection.children.link(collection)
        link(cube(), f"in {name}", collection)
        if flag == "hide_render":
            collection.hide_render = True
        elif flag:
            setattr(bpy.context.view_layer.layer_collection.children[name], flag, True)
    assert {instance.name for instance in read().instances} == {
        "plain", "eye", "screen", "in shown", "in off screen"
    }


def test_modifiers_are_those_of_the_render():
    thing = link(cube())
    levels = thing.modifiers.new("levels", "SUBSURF")
    levels.levels, levels.render_levels = 0, 2
    screen_only = thing.modifiers.new("screen", "MIRROR")
    screen_only.show_render = False
    render_only = thing.modifiers.new("render", "TRIANGULATE")
    render_only.show_viewport = False
    [mesh] = read().meshes
    assert len(mesh.triangles) == 6 * 4**2 * 2
    assert (levels.levels, render_only.show_viewport) == (0, False)


def test_curves_texts_surfaces_and_metaballs_are_their_surfaces():
    bpy.ops.object.text_add()
    bpy.ops.object.metaball_add()
    bpy.ops.surface.primitive_nurbs_surface_sphere_add(radius=2)
    bpy.ops.curve.primitive_bezier_circle_add()
    bpy.context.object.data.bevel_depth = 0.1
    scene = read()
    assert [instance.name for instance in scene.instances] == [o.name for o in bpy.context.scene.objects]
    assert not any(instance.is_copy for instance in scene.instances)
    depsgraph = bpy.context.evaluated_depsgraph_get()
    sphere = next(instance for instance in scene.instances if instance.name.startswith("Surf"))
    evaluated = bpy.data.objects[sphere.name].evaluated_get(depsgraph)
    expected = sum(polygon.area for polygon in evaluated.to_mesh().polygons)
    assert world_area(scene, sphere) == pytest.approx(expected, rel=0.01)  # triangles of bent quads differ


def test_a_mesh_is_converted_once(monkeypatch):
    converted = []
    real = meshes.read_mesh
    monkeypatch.setattr(objects, "read_mesh", lambda mesh, name: converted.append(name) or real(mesh, name))
    shared = cube()
    for index in range(60):
        link(shared, f"copy {index}", location=(index, 0, 0))
    set_of_two = bpy.data.collections.new("set")
    link(shared, "in set", set_of_two)
    for index in range(10):
        link(None, f"empty {index}", instance_type="COLLECTION", instance_collection=set_of_two)
    # An unused modifier stack makes Blender evaluate this one for itself.
    link(shared, "modified").modifiers.new("bevel", "BEVEL")
    scene = read()
    assert len(scene.instances) == 71
    assert sorted(converted) == ["cube", "cube"] and len(scene.meshes) == 2


def subdivided(mesh, name, levels=1, **attributes):
    thing = link(mesh, name, **attributes)
    modifier = thing.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = 0, levels
    return thing


def test_linked_duplicates_are_subdivided_once():
    mesh = cube()
    for name in ("a", "b", "viewport apart"):
        subdivided(mesh, name)
    bpy.data.objects["viewport apart"].modifiers[0].show_viewport = False
    subdivided(mesh, "finer", 2)
    subdivided(mesh, "pinched").modifiers.new("Pinch", "CAST").factor = 1
    subdivided(mesh, "left out").modifiers[0].show_render = False
    scene = read()
    of = {instance.name: instance.mesh for instance in scene.instances}
    assert of["a"] == of["b"] and len(scene.meshes) == len(set(of.values())) == 5
    counts = {name: len(scene.meshes[index].triangles) for name, index in of.items()}
    assert counts == {"a": 48, "b": 48, "viewport apart": 48, "finer": 192, "pinched": 48, "left out": 12}
    away = {name: np.linalg.norm(scene.meshes[index].vertices, axis=1) for name, index in of.items()}
    assert np.ptp(away["pinched"]) < 1e-4 < np.ptp(away["a"])


def test_what_bends_an_object_bends_it_alone():
    lattice = link(bpy.data.lattices.new("lattice"), "lattice")
    mesh = cube()
    subdivided(mesh, "free")
    subdivided(mesh, "bent").parent = lattice
    bpy.data.objects["bent"].parent_type = "LATTICE"
    lattice.data.points[0].co_deform.x -= 3
    scene = read()
    low = {i.name: scene.meshes[i.mesh].vertices[:, 0].min() for i in scene.instances}
    assert low["bent"] < low["free"] - 0.5


def test_copies_by_instancing():
    collection = bpy.data.collections.new("set")
    link(cube(), "inner", collection, location=(0, 0, 1))
    link(bpy.data.curves.new("words", "FONT"), "text", collection).data.body = "x"
    link(None, "empty", instance_type="COLLECTION", instance_collection=collection, location=(5, 0, 0))
    parent = link(cube(), "carrier", instance_type="VERTS", show_instancer_for_render=False, location=(0, 9, 0))
    link(cube(), "carried", parent=parent)
    found = sorted((instance.name, instance.is_copy, *instance.matrix[:3, 3]) for instance in read().instances)
    assert found[:8] == [("carried", True, x, 9 + y, z) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
    assert found[8:] == [("inner", True, 5, 0, 1), ("text", True, 5, 0, 0)]


def test_objects_of_a_background_set_get_no_results():
    other = bpy.data.scenes.new("set")
    other.collection.objects.link(bpy.data.objects.new("wall", cube()))
    bpy.context.scene.background_set = other
    link(cube(), "own")
    assert {instance.name: instance.is_copy for instance in read().instances} == {"wall": True, "own": False}


def test_copies_by_nodes_belong_to_their_object():
    tree = bpy.data.node_groups.new("copies", "GeometryNodeTree")
    for way in ("INPUT", "OUTPUT"):
        tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
    names = ("NodeGroupInput", "GeometryNodeMeshCube", "GeometryNodeInstanceOnPoints", "GeometryNodeJoinGeometry",
             "NodeGroupOutput")
    start, box, spread, join, end = (tree.nodes.new(name) for name in names)
    tree.links.new(start.outputs[0], spread.inputs["Points"])
    tree.links.new(box.outputs[0], spread.inputs["Instance"])
    tree.links.new(spread.outputs[0], join.inputs[0])
    tree.links.new(start.outputs[0], join.inputs[0])
    tree.links.new(join.outputs[0], end.inputs[0])
    thing = link(cube(), "carrier")
    thing.modifiers.new("nodes", "NODES").node_group = tree
    scene = read()
    assert [instance.is_copy for instance in scene.instances].count(False) == 1
    assert [instance.name for instance in scene.instances] == ["carrier"] * 9
    assert len(scene.meshes) == 2


def test_ten_thousand_instances_cost_no_conversion_each(monkeypatch):
    converted = []
    real = meshes.read_mesh
    monkeypatch.setattr(objects, "read_mesh", lambda mesh, name: converted.append(name) or real(mesh, name))
    points = bpy.data.meshes.new("points")
    points.from_pydata(np.random.default_rng(0).random((10_000, 3)).tolist(), [], [])
    parent = link(points, "points", instance_type="VERTS")
    link(cube(), "carried", parent=parent)
    assert len(read().instances) == 10_000
    assert len(converted) == 2  # the points too, which have no triangle


def test_matrix_with_negative_scale():
    thing = link(cube(), location=(1, 2, 3), rotation_euler=(0.3, 0.5, 0.7), scale=(-2, 0.5, 1))
    parent = link(None, "parent", scale=(1, 3, 1))
    thing.parent = parent
    scene = read()
    assert np.allclose(scene.instances[0].matrix, thing.matrix_world, atol=1e-6)
    assert np.linalg.det(scene.instances[0].matrix[:3, :3]) < 0


def test_corner_normals():
    flat, smooth = cube(), cube()
    smooth.shade_smooth()
    custom = cube()
    custom.shade_smooth()
    wanted = np.random.default_rng(3).normal(size=(24, 3))
    wanted /= np.linalg.norm(wanted, axis=1, keepdims=True)
    custom.normals_split_custom_set(wanted.tolist())
    for mesh in (flat, smooth, custom):
        link(mesh)
    of_flat, of_smooth, of_custom = read().meshes

    corners = of_flat.vertices[of_flat.triangles]
    face = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    face /= np.linalg.norm(face, axis=1, keepdims=True)
    assert np.allclose(of_flat.normals, face[:, None], atol=1e-6)

    outwards = of_smooth.vertices[of_smooth.triangles] / np.sqrt(3)
    assert np.allclose(of_smooth.normals, outwards, atol=1e-6)

    custom.calc_loop_triangles()
    loops = np.array([list(triangle.loops) for triangle in custom.loop_triangles])
    assert np.allclose(of_custom.normals, wanted[loops], atol=2e-3)  # Blender keeps custom normals in 16 bits


def test_uv_maps():
    mesh = cube()
    values = np.random.default_rng(5).random((2, 24, 2)).astype(np.float32)
    for name, value in zip(("first", "second"), values):
        mesh.uv_layers.new(name=name).uv.foreach_set("vector", value.ravel())
    mesh.uv_layers["second"].active_render = True
    link(mesh)
    [found] = read().meshes
    mesh.calc_loop_triangles()
    loops = np.array([list(triangle.loops) for triangle in mesh.loop_triangles])
    assert list(found.uvs) == ["first", "second"] and found.render_uv == "second"
    assert np.array_equal(found.uvs["first"], values[0][loops])
    assert np.array_equal(found.uvs["second"], values[1][loops])


def test_material_slots():
    first, second, own = (bpy.data.materials.new(name) for name in ("first", "second", "own"))
    mesh = cube()
    for material in (first, None, second):
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", [0, 1, 2, 2, 1, 0])
    one = link(mesh, "one")
    other = link(mesh, "other")
    other.material_slots[0].link, other.material_slots[0].material = "OBJECT", own
    scene = read()
    names = {instance.name: [scene.materials[i].name for i in instance.materials] for instance in scene.instances}
    assert names == {one.name: ["first", "", "second"], other.name: ["own", "", "second"]}
    [found] = scene.meshes
    assert found.slots.tolist() == [0, 0, 1, 1, 2, 2, 2, 2, 1, 1, 0, 0]
    assert len(scene.materials) == 4


def test_faces_beyond_the_slots_take_the_last():
    mesh = cube()
    for name in ("first", "second"):
        mesh.materials.append(bpy.data.materials.new(name))
    mesh.attributes.new("material_index", "INT", "FACE").data.foreach_set("value", [7] * 6)
    link(mesh)
    scene = read()
    assert {scene.materials[scene.instances[0].materials[slot]].name for slot in scene.meshes[0].slots} == {"second"}


def test_material_override_of_the_view_layer():
    override = bpy.context.view_layer.material_override = bpy.data.materials.new("override")
    mesh = cube()
    mesh.materials.append(bpy.data.materials.new("own"))
    link(mesh)
    assert [material.name for material in read().materials] == [override.name]


def test_the_frame_is_the_current_one():
    thing = link(cube())
    thing.keyframe_insert("location", frame=1)
    thing.location = (8, 0, 0)
    thing.keyframe_insert("location", frame=9)
    bpy.context.scene.frame_set(9)
    assert read().instances[0].matrix[0, 3] == pytest.approx(8)


def test_edit_mode_is_read_as_it_stands():
    thing = link(cube())
    bpy.context.view_layer.objects.active = thing
    bpy.ops.object.mode_set(mode="EDIT")
    bpy.ops.mesh.select_all(action="SELECT")
    bpy.ops.mesh.subdivide()
    assert len(read().meshes[0].triangles) == 48
    assert thing.mode == "EDIT"


def test_what_is_left_out_is_told():
    link(bpy.data.volumes.new("smoke"), "smoke")
    link(cube(), "unseen", visible_shadow=False)
    hairy = link(cube(), "hairy")
    hairy.modifiers.new("hair", "PARTICLE_SYSTEM").particle_system.settings.type = "HAIR"
    link(cube(), "plain")
    told = read().approximated
    assert [name for sentence in told for name in ("smoke", "unseen", "hairy", "plain") if f"'{name}'" in sentence] == [
        "smoke", "unseen", "hairy"
    ]


def test_a_view_layer_that_does_not_render_can_be_read():
    scene = bpy.context.scene
    scene.view_layers.new("other")
    link(cube())
    collection = bpy.data.collections.new("only in one")
    scene.collection.children.link(collection)
    link(cube(), "more", collection)
    scene.view_layers["other"].layer_collection.children[0].exclude = True
    scene.view_layers["other"].use = False
    assert len(read_scene(scene, scene.view_layers["other"]).instances) == 1
    assert len(read_scene(scene, scene.view_layers[0]).instances) == 2
    assert [layer.use for layer in scene.view_layers] == [True, False]


def test_another_scene_keeps_its_frame():
    other = bpy.data.scenes.new("other")
    thing = bpy.data.objects.new("thing", cube())
    other.collection.objects.link(thing)
    for frame in (1, 9):
        thing.location.x = frame
        thing.keyframe_insert("location", frame=frame)
    other.frame_set(9)
    assert read_scene(other, other.view_layers[0]).instances[0].matrix[0, 3] == pytest.approx(9)
    assert (other.frame_current, bpy.context.scene.frame_current) == (9, 1)


def test_stereo_and_post_processing_do_not_get_in_the_way(monkeypatch):
    link(cube())
    scene = bpy.context.scene
    scene.render.use_multiview = scene.render.use_persistent_data = True
    scene.sequence_editor_create()
    strips = scene.sequence_editor.strips if bpy.app.version >= (5, 0, 0) else scene.sequence_editor.sequences
    strips.new_effect("colour", "COLOR", 1, 1, **{"frame_end" if bpy.app.version < (5, 0, 0) else "length": 10})
    calls = []
    real = objects.read_mesh
    monkeypatch.setattr(objects, "read_mesh", lambda mesh, name: calls.append(name) or real(mesh, name))
    assert len(read().instances) == 1 and len(calls) == 1
    assert len(read().instances) == 1


def test_a_sponza_of_triangles_in_two_seconds():
    """262 144 triangles with smooth normals and a UV map, at most 2 s (0.15 s on two cores)."""
    side = 363
    x, y = np.meshgrid(np.arange(side), np.arange(side))
    corner = (np.arange(side - 1)[:, None] * side + np.arange(side - 1)).ravel()
    mesh = bpy.data.meshes.new("grid")
    mesh.from_pydata(
        np.stack([x, y, np.sin(x / 9) * np.cos(y / 7)], -1).reshape(-1, 3),
        [],
        np.stack([corner, corner + 1, corner + side + 1, corner + side], -1),
    )
    mesh.shade_smooth()
    mesh.uv_layers.new(name="map")
    link(mesh)
    begin = time.perf_counter()
    [found] = read().meshes
    assert time.perf_counter() - begin < 2
    assert len(found.triangles) == 2 * 362**2


def test_reading_leaves_the_file_as_it_was():
    scene = bpy.context.scene
    link(cube(), matrix_world=Matrix.Translation((1, 2, 3)))
    scene.render.engine = "CYCLES"
    scene.render.resolution_x = 123
    scene.render.use_compositing = scene.render.use_sequencer = True

    def state():
        data = {name: [block.name for block in getattr(bpy.data, name)] for name in dir(bpy.data)
                if isinstance(getattr(bpy.data, name), bpy.types.bpy_prop_collection)}
        return data, scene.render.engine, scene.render.use_compositing, scene.render.use_sequencer, scene.camera

    before = state()
    read()
    assert state() == before


def test_the_last_render_stays(tmp_path):
    scene = bpy.context.scene
    scene.camera = link(bpy.data.cameras.new("camera"))
    scene.render.engine, scene.cycles.samples = "CYCLES", 1
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.world = bpy.data.worlds.new("world")
    scene.world.color = (0.2, 0.4, 0.8)
    bpy.ops.render.render()
    result = bpy.data.images["Render Result"]
    slots = len(result.render_slots)

    def picture(name):
        result.save_render(str(tmp_path / name))
        return (tmp_path / name).read_bytes()

    before = picture("before.png")
    read()
    assert picture("after.png") == before
    assert (len(result.render_slots), result.render_slots.active_index) == (slots, 0)


def test_errors_come_out_of_the_render(monkeypatch):
    link(cube())

    def fail(mesh, name):
        raise ValueError("no such luck")

    monkeypatch.setattr(objects, "read_mesh", fail)
    with pytest.raises(ValueError, match="no such luck"):
        read()
    assert bpy.context.scene.render.engine != "GI_BAKE_READ"
    assert not hasattr(bpy.types, "GI_BAKE_READ")
