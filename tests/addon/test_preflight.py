# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each thing that would spoil a bake is found, with its code and name; a sound scene gives none."""

from pathlib import Path

import bpy
import numpy as np
import pytest
from gi_bake.addon.preflight import check


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def link(data, name, collection=None, **attributes):
    thing = bpy.data.objects.new(name, data)
    for attribute, value in attributes.items():
        setattr(thing, attribute, value)
    (collection or bpy.context.scene.collection).objects.link(thing)
    return thing


def square(name="square", material=None, **attributes):
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata([(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [], [(0, 1, 2, 3)])
    mesh.uv_layers.new(name="map").uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, 0, 1])
    if material:
        mesh.materials.append(material)
    return link(mesh, name, **attributes)


def light(kind="POINT", name="lamp", **attributes):
    data = bpy.data.lights.new(name, kind)
    for attribute, value in attributes.items():
        setattr(data, attribute, value)
    return link(data, name, location=(0, 0, 3))


def camera(**attributes):
    data = bpy.data.cameras.new("camera")
    for attribute, value in attributes.items():
        setattr(data, attribute, value)
    bpy.context.scene.camera = link(data, "camera", location=(0, 0, 5))
    return bpy.context.scene.camera


@pytest.fixture
def sound():
    """A square under a lamp, seen by a camera; the square."""
    light()
    camera()
    return square()


def node_material(kind, name="material", **values):
    material = bpy.data.materials.new(name)
    if bpy.app.version < (5, 0, 0):
        material.use_nodes = True
    tree = material.node_tree
    tree.nodes.clear()
    node = tree.nodes.new(kind)
    for key, value in values.items():
        node.inputs[key].default_value = value
    tree.links.new(node.outputs[0], tree.nodes.new("ShaderNodeOutputMaterial").inputs["Surface"])
    return material


def found(**arguments):
    findings = check(bpy.context.scene, bpy.context.view_layer, **arguments)
    assert all(f.severity in {"ERROR", "WARNING"} and f.message and f.remedy for f in findings)
    return [(f.code, f.severity, f.object) for f in findings]


@pytest.mark.parametrize("target", ["image", "lightmap", "vertices", "volume"])
def test_a_sound_scene(sound, tmp_path, target):
    assert found(target=target, output=tmp_path / "new" / "folder") == []
    assert found(target=target, objects=("square",)) == []
    assert list(tmp_path.iterdir()) == []


def test_an_empty_file():
    assert found() == [("NO_CAMERA", "ERROR", ""), ("NO_LIGHT", "ERROR", ""), ("NOTHING_TO_BAKE", "ERROR", "")]
    assert ("NO_CAMERA", "ERROR", "") not in found(target="lightmap")


def test_cameras(sound):
    bpy.context.scene.camera.data.type = "PANO"
    assert found() == [("UNSUPPORTED_CAMERA", "ERROR", "camera")]
    bpy.context.scene.camera.data.type = "PERSP"
    bpy.context.scene.camera.rotation_euler = (3, 0, 0)
    assert found() == [("NOTHING_IN_VIEW", "WARNING", "camera")]
    bpy.context.scene.camera.rotation_euler = (0, 0, 0)
    bpy.context.scene.camera.data.clip_end = 4
    assert found() == [("NOTHING_IN_VIEW", "WARNING", "camera")]
    assert found(target="vertices") == []


def test_no_light(sound):
    lamp = bpy.data.objects["lamp"]
    lamp.hide_render = True
    assert found() == [("NO_LIGHT", "ERROR", "")]
    assert "'lamp'" in check(bpy.context.scene, bpy.context.view_layer)[0].message


def test_light_of_a_world_or_a_material_is_light(sound):
    bpy.data.objects["lamp"].hide_render = True
    world = bpy.context.scene.world = bpy.data.worlds.new("world")
    assert found() == []
    if bpy.app.version < (5, 0, 0):
        world.color = (0, 0, 0)
    else:
        world.node_tree.nodes["Background"].inputs["Strength"].default_value = 0
    assert found() == [("NO_LIGHT", "ERROR", "")]
    sound.data.materials.append(node_material("ShaderNodeEmission"))
    assert found() == [("NO_DIFFUSE_SURFACE", "WARNING", "")]


def test_dark_and_flat_lights(sound):
    light(name="off", energy=0)
    light(name="black", color=(0, 0, 0))
    light("AREA", "unsized", size=0)
    light("AREA", "unscaled").scale = (1, 0, 1)
    light("AREA", "hidden", size=0).hide_render = True
    assert found() == [
        ("ZERO_AREA_LIGHT", "ERROR", "unsized"),
        ("ZERO_AREA_LIGHT", "ERROR", "unscaled"),
        ("DARK_LIGHT", "WARNING", "off"),
        ("DARK_LIGHT", "WARNING", "black"),
    ]


def test_geometry_that_is_not_finite(sound):
    sound.data.vertices[2].co.y = np.nan
    square("far").location.x = np.inf
    square("hidden", hide_render=True).data.vertices[0].co.x = np.nan
    assert found() == [("NON_FINITE", "ERROR", "square"), ("NON_FINITE", "ERROR", "far")]
    sound.data.vertices[2].co.y = 0
    bpy.data.objects["far"].location.x = 0
    light(name="nowhere").location.x = np.nan
    assert found() == [("NON_FINITE", "ERROR", "nowhere")]


def test_geometry_without_area(sound):
    square("flat", scale=(1, 0, 1))
    line = square("line")
    line.data.vertices.foreach_set("co", [0, 0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0])
    assert found() == [("ZERO_AREA", "WARNING", "flat"), ("ZERO_AREA", "WARNING", "line")]
    assert found(objects=("line",)) == [("ZERO_AREA", "ERROR", "line"), ("ZERO_AREA", "WARNING", "flat")]


def test_objects_that_cannot_get_results(sound):
    link(bpy.data.meshes.new("empty"), "empty")
    square("hidden", hide_render=True)
    collection = bpy.data.collections.new("excluded")
    bpy.context.scene.collection.children.link(collection)
    link(sound.data.copy(), "excluded", collection)
    bpy.context.view_layer.layer_collection.children["excluded"].exclude = True
    names = ("square", "nobody", "lamp", "empty", "hidden", "excluded")
    assert found(target="vertices", objects=names) == [
        ("UNKNOWN_OBJECT", "ERROR", "nobody"),
        ("NOT_A_SURFACE", "ERROR", "lamp"),
        ("NO_FACES", "ERROR", "empty"),
        ("HIDDEN_IN_RENDER", "ERROR", "hidden"),
        ("HIDDEN_IN_RENDER", "ERROR", "excluded"),
    ]
    assert found(target="vertices") == []


def test_uv_maps(sound):
    bare = square("bare")
    bare.data.uv_layers.remove(bare.data.uv_layers[0])
    for name, corners in {
        "collapsed": [0.5, 0.5] * 4,
        "outside": [0, 0, 2, 0, 2, 2, 0, 2],
    }.items():
        square(name).data.uv_layers["map"].uv.foreach_set("vector", corners)
    twice = square("twice")
    twice.modifiers.new("array", "ARRAY")
    assert found(target="lightmap") == [
        ("NO_UV_MAP", "ERROR", "bare"),
        ("EMPTY_UV_MAP", "ERROR", "collapsed"),
        ("UV_OUTSIDE", "WARNING", "outside"),
        ("UV_OVERLAP", "WARNING", "twice"),
    ]
    # With the share that it is about: here of two triangles the one with twice the other's area.
    bpy.data.objects["outside"].data.uv_layers["map"].uv.foreach_set("vector", [0, 0, 1, 0, 1, 1, -1, 1])
    told = {f.code: f.message for f in check(bpy.context.scene, bpy.context.view_layer, target="lightmap")}
    assert "66.7% of UV map 'map' of 'outside'" in told["UV_OUTSIDE"]
    assert "'twice' overlap on 100.0% of UV map 'map'" in told["UV_OVERLAP"]
    assert found(target="lightmap", objects=("square",)) == []
    assert found(target="lightmap", objects=("square",), uv="other") == [("NO_UV_MAP", "ERROR", "square")]
    assert found(target="image") == []


def test_vertices_that_cannot_take_results(sound):
    link(sound.data, "twin")
    square("smooth").modifiers.new("levels", "SUBSURF")
    square("bent").modifiers.new("bend", "SIMPLE_DEFORM")
    link(bpy.data.curves.new("words", "FONT"), "words").data.body = "x"
    assert found(target="vertices") == [
        ("VERTICES_NOT_WRITABLE", "ERROR", "square"),
        ("VERTICES_NOT_WRITABLE", "ERROR", "twin"),
        ("VERTICES_MODIFIED", "ERROR", "smooth"),
        ("VERTICES_NOT_WRITABLE", "ERROR", "words"),
    ]
    assert found(target="vertices", objects=("bent",)) == found(target="image") == []


def test_missing_images(sound, tmp_path):
    material = node_material("ShaderNodeBsdfDiffuse", "wall")
    tree = material.node_tree
    image = tree.nodes.new("ShaderNodeTexImage")
    sound.data.materials.append(material)
    image.image = bpy.data.images.new("gone", 4, 4)
    image.image.source, image.image.filepath = "FILE", "//not/there.png"
    assert found() == []  # not linked, so not read
    tree.links.new(image.outputs["Color"], tree.nodes["Diffuse BSDF"].inputs["Color"])
    assert found() == [("MISSING_IMAGE", "ERROR", "gone")]
    assert "not/there.png" in check(bpy.context.scene, bpy.context.view_layer)[0].message
    (tmp_path / "broken.png").write_bytes(b"\x89PNG no more")
    image.image.filepath = str(tmp_path / "broken.png")
    assert found() == [("MISSING_IMAGE", "ERROR", "gone")]
    image.image = None
    assert found() == [("MISSING_IMAGE", "ERROR", "Image Texture")]
    sound.hide_render = True
    square("other")
    assert found() == []


def test_output_folder(sound, tmp_path):
    assert found(output=Path("//baked")) == [("UNSAVED_RELATIVE_PATH", "ERROR", "")]
    (tmp_path / "file").write_text("")
    assert found(output=tmp_path / "file" / "folder") == [("OUTPUT_NOT_WRITABLE", "ERROR", "")]
    assert found(output=str(tmp_path / "file")) == [("OUTPUT_NOT_WRITABLE", "ERROR", "")]


def test_output_folder_relative_to_a_saved_file(sound, tmp_path):
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    assert found(output="//baked") == []


def test_missing_library(sound, tmp_path):
    library = tmp_path / "library.blend"
    bpy.data.libraries.write(str(library), {sound})
    with bpy.data.libraries.load(str(library), link=True) as (_, linked):
        linked.objects = ["square"]
    bpy.context.scene.collection.objects.link(linked.objects[0])
    bpy.ops.wm.save_as_mainfile(filepath=str(tmp_path / "saved.blend"))
    library.unlink()
    bpy.ops.wm.open_mainfile(filepath=str(tmp_path / "saved.blend"))
    assert found() == [("MISSING_LIBRARY", "WARNING", "library.blend")]


def test_the_file_on_disk_and_in_memory_stay(sound, tmp_path):
    path = tmp_path / "saved.blend"
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    before, engine = path.read_bytes(), bpy.context.scene.render.engine
    blocks = [block.name for block in bpy.data.user_map()]
    found(target="lightmap", output=tmp_path / "out")
    assert path.read_bytes() == before and bpy.context.scene.render.engine == engine
    assert [block.name for block in bpy.data.user_map()] == blocks
