# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Files with linked data, hidden collections, thousands of copies and meshes without faces bake, or say why not."""

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import Refused, bake
from gi_bake.addon.job import Job
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.tiles import finish
from gi_bake.tests.shader_trees import link, material, read_baked, square


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def noise(name="noise", vector=None):
    tree = material(name)
    inputs = {"Vector": tree.node("ShaderNodeTexCoord", vector)} if vector else {}
    return tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=tree.node("ShaderNodeTexNoise", "Color", **inputs)))


def baked(**job):
    link(bpy.data.lights.new("sun", "SUN"), "sun", location=(0, 0, 5))
    settings = RsmSettings(samples=4, map_resolution=8)
    return finish(bake(bpy.context.scene, bpy.context.view_layer, Job(settings=settings, **job)))


@pytest.fixture
def library(tmp_path):
    """A file with a collection of one square, whose material has noise in a linked group."""
    thing = square(noise("library noise"), name="linked")
    collection = bpy.data.collections.new("furniture")
    bpy.context.scene.collection.objects.unlink(thing)
    collection.objects.link(thing)
    path = tmp_path / "library.blend"
    bpy.data.libraries.write(str(path), {collection})
    bpy.ops.wm.read_homefile(use_empty=True)
    return path


@pytest.mark.parametrize("way", ["linked", "instanced", "override"])
def test_linked_objects(library, way):
    with bpy.data.libraries.load(str(library), link=True) as (_, to):
        to.collections = ["furniture"]
    collection = to.collections[0]
    scene = bpy.context.scene
    if way == "linked":
        scene.collection.children.link(collection)
    elif way == "instanced":
        link(None, "empty", instance_type="COLLECTION", instance_collection=collection)
    else:
        collection.override_hierarchy_create(scene, bpy.context.view_layer)
    square(name="floor", size=4.0, location=(-1, -1, -1))
    result = baked(target="vertices", objects=("floor",))
    assert result.light["floor"].valid.all()
    assert not [note for note in result.approximated if "library" in note]
    core = read_baked()
    [made] = [m for m in core.materials if m.name == "library noise"]
    assert made.albedo.texture.pixels.std() > 0.01
    assert all(m.library for m in bpy.data.materials if m.name == "library noise")


def test_hidden_and_excluded_collections():
    shown = square(noise(), name="shown")
    for name, hide in (("hidden", lambda c, layer: setattr(c, "hide_render", True)),
                       ("excluded", lambda c, layer: setattr(layer, "exclude", True)),
                       ("only in the viewport", lambda c, layer: setattr(layer, "hide_viewport", True))):
        collection = bpy.data.collections.new(name)
        bpy.context.scene.collection.children.link(collection)
        thing = square(noise(name), name=f"{name} thing", location=(0, 0, 1))
        collection.objects.link(thing)
        bpy.context.scene.collection.objects.unlink(thing)
        hide(collection, bpy.context.view_layer.layer_collection.children[name])
    result = baked(target="vertices")
    assert set(result.light) == {"shown", "only in the viewport thing"}
    assert shown.name in bpy.context.view_layer.objects
    with pytest.raises(Refused, match="HIDDEN_IN_RENDER"):
        baked(target="vertices", objects=("hidden thing",))


def test_thousands_of_copies():
    """One mesh, once read and once baked, at each vertex of another."""
    points = bpy.data.meshes.new("points")
    points.vertices.add(2000)
    points.vertices.foreach_set("co", np.random.default_rng(0).uniform(-5, 5, 6000))
    parent = link(points, "points", instance_type="VERTS", show_instancer_for_render=False)
    square(noise(vector="Object"), name="copied", size=0.1, parent=parent)
    square(name="floor", size=10.0, location=(-5, -5, -6))
    core = read_baked()
    assert len(core.instances) == 2001 and len(core.meshes) == 2 and len(core.materials) == 2
    assert baked(target="vertices", objects=("floor",)).light["floor"].valid.all()


def test_an_object_that_was_just_deleted():
    """Until Blender looks at its view layer again it is in there as nothing."""
    square(name="floor", size=4.0)
    gone = square(name="gone")
    baked(target="lightmap", resolution=16)
    bpy.data.objects.remove(gone)
    assert None in list(bpy.context.view_layer.objects)
    job = Job(target="lightmap", resolution=16, settings=RsmSettings(samples=4, map_resolution=8))
    assert set(finish(bake(bpy.context.scene, bpy.context.view_layer, job)).light) == {"floor"}


def test_meshes_without_faces():
    empty = bpy.data.meshes.new("empty")
    edges = bpy.data.meshes.new("edges")
    edges.from_pydata([(0, 0, 0), (1, 0, 0)], [(0, 1)], [])
    for mesh in (empty, edges):
        mesh.materials.append(noise(mesh.name))
        link(mesh, mesh.name)
    square(noise(), name="floor")
    assert set(baked(target="vertices").light) == {"floor"}
    for name in ("empty", "edges"):
        with pytest.raises(Refused, match="NO_FACES"):
            baked(target="vertices", objects=(name,))
