# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What baking materials leaves alone, and what it keeps for the next time."""

import bpy
import numpy as np
import pytest
from gi_bake.addon import preflight
from gi_bake.addon.bake import bake
from gi_bake.addon.job import Job
from gi_bake.addon.read import read_scene, surface_bakes, with_bakes
from gi_bake.addon.read.surface_bakes import SurfaceBakes
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.tiles import finish
from gi_bake.tests.shader_trees import image, link, material, read_baked, square


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def procedural(name="noise", scale=3.0):
    """A material with noise in a group, times the random number of the object."""
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    group.interface.new_socket("Result", in_out="OUTPUT", socket_type="NodeSocketColor")
    node, output = group.nodes.new("ShaderNodeTexNoise"), group.nodes.new("NodeGroupOutput")
    node.inputs["Scale"].default_value = scale
    group.links.new(node.outputs["Color"], output.inputs["Result"])
    tree = material(name)
    return tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=tree.node(
        "ShaderNodeMix", 2, {"data_type": "RGBA", "blend_type": "MULTIPLY"}, Factor=1.0,
        A=tree.node("ShaderNodeGroup", set={"node_tree": group}), B=tree.node("ShaderNodeObjectInfo", "Random"))))


def everything():
    """All that the file says, as text: every property of every data-block, and what is selected and active."""
    def described(value, depth):
        if isinstance(value, bpy.types.ID) and depth:
            return value.name_full
        if isinstance(value, bpy.types.bpy_prop_collection):
            return [described(each, depth + 1) for each in value]
        if isinstance(value, bpy.types.bpy_struct):
            if depth > 7:
                return type(value).__name__
            left_out = {"rna_type", "session_uid", "depsgraph", "storage_type"}  # the last one reading changes
            names = [name for name in value.bl_rna.properties.keys() if name not in left_out]
            return [(n, described(getattr(value, n, None), depth + 1)) for n in names]
        try:
            return np.array(value).tolist() if hasattr(value, "__len__") and not isinstance(value, str) else repr(value)
        except (TypeError, ValueError):
            return repr(value)

    kinds = ("objects", "meshes", "materials", "node_groups", "images", "scenes", "collections", "lights", "worlds",
             "shape_keys", "actions", "cameras", "textures")
    file = {kind: [described(block, 0) for block in getattr(bpy.data, kind)] for kind in kinds}
    context = bpy.context
    return repr((file, context.scene.name, context.mode, context.object and context.object.name,
                 [thing.name for thing in context.selected_objects]))


def users():
    return {(kind, block.name): block.users for kind in ("materials", "node_groups", "images", "meshes", "objects")
            for block in getattr(bpy.data, kind)}


@pytest.mark.parametrize("mode", ["OBJECT", "EDIT", "VERTEX_PAINT"])
@pytest.mark.parametrize("end", ["done", "cancelled", "failed"])
def test_the_file_is_as_it_was(monkeypatch, mode, end):
    noise = procedural()
    things = [square(noise, name=f"thing {k}", location=(k, 0, 0)) for k in range(3)]
    things[0].shape_key_add(name="Basis")
    things[0].shape_key_add(name="moved").value = 0.5
    light = link(bpy.data.lights.new("sun", "SUN"), "sun")
    things[1].select_set(True)
    bpy.context.view_layer.objects.active = things[1]
    if mode != "OBJECT":
        bpy.ops.object.mode_set(mode=mode)
    bpy.context.scene.render.engine = "BLENDER_WORKBENCH"
    bpy.context.view_layer.update()
    before, counts = everything(), users()
    assert "thing 1" in before and "ShaderNodeTexNoise" in before
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    bakes = SurfaceBakes(None)
    if end == "failed":
        def fail(*_):
            raise RuntimeError("no")

        monkeypatch.setattr(surface_bakes._Studio, "_run", fail)
    work = with_bakes(read_scene(scene, view_layer, bakes=bakes), scene, view_layer, bakes)
    if end == "failed":
        with pytest.raises(RuntimeError, match="no"):
            finish(work)
    elif end == "cancelled":
        for _ in range(3):
            next(work)
        assert len(bpy.data.scenes) == 2
        work.close()
    else:
        assert len(finish(work).materials) == 3
    after = everything()
    if after != before:
        k = next(k for k, (a, b) in enumerate(zip(after, before)) if a != b)
        raise AssertionError((before[k - 150 : k + 100], after[k - 150 : k + 100]))
    assert users() == counts
    assert light.name in bpy.data.objects


def counted(monkeypatch):
    """Counts bakes from now on."""
    bakes, real = [], surface_bakes._Studio.baked
    monkeypatch.setattr(surface_bakes._Studio, "baked", lambda *a: bakes.append(a[1].material.name) or real(*a))
    return bakes


def test_textures_are_kept_until_something_changes(tmp_path, monkeypatch):
    made = counted(monkeypatch)
    file = image(np.random.default_rng(0).random((4, 4, 4)), "image")
    tree = material("mapped")
    vector = tree.node("ShaderNodeMapping", Vector=tree.node("ShaderNodeTexCoord", "UV"), Scale=(2, 2, 2))
    ramp = tree.node("ShaderNodeValToRGB").node
    tree.tree.links.new(tree.node("ShaderNodeTexImage", set={"image": file}, Vector=vector), ramp.inputs[0])
    thing = square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=ramp.outputs[0])))
    other = square(procedural("other"), location=(2, 0, 0))

    def baked():
        made.clear()
        core = read_baked(SurfaceBakes(tmp_path / "kept"))
        return [*made], [m.albedo.texture.pixels for m in core.materials]

    names, first = baked()
    assert names == ["mapped", "other"]
    names, second = baked()
    assert names == [] and all(np.array_equal(a, b) for a, b in zip(first, second))

    file.pixels[0] += 0.1
    file.update()
    assert baked()[0] == ["mapped"]
    ramp.color_ramp.elements[1].color = (1, 0, 0, 1)
    assert baked()[0] == ["mapped"]
    vector.node.inputs["Scale"].default_value = (3, 2, 2)
    assert baked()[0] == ["mapped"]
    thing.data.uv_layers["first"].uv[0].vector = (0.1, 0)
    assert baked()[0] == ["mapped"]
    bpy.data.node_groups["group"].nodes["Noise Texture"].inputs["Scale"].default_value = 7
    assert baked()[0] == ["other"]
    thing.location.x = 0.5
    assert baked()[0] == []
    other.data.vertices[2].co = (1.2, 1.1, 0)
    assert baked()[0] == ["other"]
    tree.tree.nodes["Diffuse BSDF"].inputs["Roughness"].default_value = 0.3
    assert baked()[0] == []


def test_a_damaged_or_missing_folder_only_costs_time(tmp_path):
    square(procedural())
    (tmp_path / "file").write_text("")
    expected = read_baked(SurfaceBakes(None)).materials[0].albedo.texture.pixels
    assert np.array_equal(
        read_baked(SurfaceBakes(tmp_path / "file")).materials[0].albedo.texture.pixels, expected)
    for _ in range(2):
        found = read_baked(SurfaceBakes(tmp_path / "kept")).materials[0].albedo.texture.pixels
        assert np.array_equal(found, expected)
        for kept in (tmp_path / "kept").iterdir():
            kept.write_bytes(kept.read_bytes()[:50])


def test_the_oldest_textures_make_room(tmp_path, monkeypatch):
    square(procedural("one", 1.0))
    square(procedural("two", 2.0))
    read_baked(SurfaceBakes(tmp_path))
    sizes = [file.stat().st_size for file in tmp_path.glob("*.npy")]
    monkeypatch.setattr("gi_bake.addon.read.texture_cache._LIMIT", sum(sizes) - 1)
    made = counted(monkeypatch)
    square(procedural("three", 3.0))
    read_baked(SurfaceBakes(tmp_path))
    assert "three" in made and sum(file.stat().st_size for file in tmp_path.glob("*.npy")) < sum(sizes)
    assert not list(tmp_path.glob(".*"))


def test_the_preflight_bakes_nothing(monkeypatch):
    made = counted(monkeypatch)
    square(procedural())
    link(bpy.data.lights.new("sun", "SUN"), "sun")
    assert preflight.check(bpy.context.scene, bpy.context.view_layer, target="vertices") == [] and not made


def test_a_stage_of_the_bake():
    square(procedural())
    link(bpy.data.lights.new("sun", "SUN"), "sun")
    job = Job(target="vertices", settings=RsmSettings(samples=4, map_resolution=8))
    said = []
    work = bake(bpy.context.scene, bpy.context.view_layer, job)
    try:
        while True:
            said.append(next(work))
    except StopIteration as stop:
        result = stop.value
    assert "materials" in [stage for _, stage in said] and result.stages["materials"] > 0
    assert [fraction for fraction, _ in said] == sorted(fraction for fraction, _ in said)
    assert result.approximated == ()


def relief(tree, space="TANGENT", **inputs):
    """A normal map of noise."""
    color = tree.node("ShaderNodeTexNoise", "Color")
    return tree.node("ShaderNodeNormalMap", set={"space": space}, Color=color, **inputs)


@pytest.mark.parametrize("space, bakes", [("TANGENT", 3), ("OBJECT", 3), ("WORLD", 5)])
def test_objects_share_normals_that_turn_with_them(tmp_path, monkeypatch, space, bakes):
    made = counted(monkeypatch)
    tree = material()
    thing = square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Normal=relief(tree, space))))
    for k, (turn, scale) in enumerate([((0, 0, 0), (1, 1, 1)), ((1, 2, 3), (1, 1, 1)), ((0, 0, 1), (2, 1, 1)),
                                       ((0, 0, 0), (-1, 1, 1))]):  # fmt: skip
        link(thing.data, f"copy {k}", location=(k, 2, 0), rotation_euler=turn, scale=scale)
    core = read_baked(SurfaceBakes(tmp_path))
    assert len(made) == len(core.materials) == bakes and not core.approximated
    assert all(m.normal.texture is not None for m in core.materials)
    made.clear()
    again = read_baked(SurfaceBakes(tmp_path))
    assert not made
    assert all(np.array_equal(a.normal.texture.pixels, b.normal.texture.pixels)
               for a, b in zip(again.materials, core.materials))  # fmt: skip


def test_normals_that_are_the_meshes_own_are_not_baked(monkeypatch):
    made = counted(monkeypatch)
    idle = [
        lambda t: t.node("ShaderNodeNormalMap"),
        lambda t: t.node("ShaderNodeBump"),
        lambda t: t.node("ShaderNodeNewGeometry", "Normal"),
        lambda t: relief(t, Strength=0.0),
        lambda t: t.node("ShaderNodeBump", Strength=0.0, Height=t.node("ShaderNodeTexNoise")),
        lambda t: t.node("ShaderNodeBump", Normal=t.node("ShaderNodeNormalMap")),
    ]
    for make in idle:
        tree = material()
        square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Normal=make(tree))))
    core = read_baked()
    assert not made and len(core.materials) == len(idle) and all(m.normal is None for m in core.materials)
    tree = material()
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Normal=tree.node("ShaderNodeBump", Normal=relief(tree)))))
    assert read_baked().materials[-1].normal is not None and len(made) == 1


def test_of_shaders_with_different_normals_the_brightest_counts():
    def mixed(first, second):
        tree = material()
        normal = relief(tree, "OBJECT", Strength=0.5)
        shaders = [tree.node("ShaderNodeBsdfDiffuse", Color=(c, c, c), **({"Normal": normal} if mapped else {}))
                   for c, mapped in (first, second)]  # fmt: skip
        mix = tree.node("ShaderNodeMixShader")
        mix.node.inputs[0].default_value = 0.5
        for shader, socket in zip(shaders, mix.node.inputs[1:]):
            tree.tree.links.new(shader, socket)
        square(tree.surface(mix))
        core = read_baked()
        bpy.ops.wm.read_homefile(use_empty=True)
        return core.materials[0].normal is not None, "different normals" in " ".join(core.approximated)

    assert mixed((0.8, True), (0.2, False)) == (True, True)
    assert mixed((0.2, True), (0.8, False)) == (False, True)
    assert mixed((0.2, True), (0.8, True)) == (True, False)
    assert mixed((0.8, True), (0.0, False)) == (True, False)
