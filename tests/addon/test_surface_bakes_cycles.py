# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that only Cycles can tell: what our surfaces have against what Cycles shows of them."""

import math

import bpy
import numpy as np
import pytest
from gi_bake.addon.read.surface_bakes import SurfaceBakes
from gi_bake.tests.shader_trees import (
    Tree,
    color_errors,
    image,
    link,
    material,
    overhead_camera,
    read_baked,
    render,
    square,
)


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def compared(tmp_path, objects, width, height=1, tolerance=2.0, **bakes):
    """Renders and reads what is in the file; of each object the colours must agree, in 1/255: on average and at the
    99th percentile. Returns the scene that was read."""
    overhead_camera(width, height)
    passes = render(tmp_path, width * 24, height * 24)
    core = read_baked(**bakes)
    for key, source in (("Diffuse Color", "albedo"), ("Emission", "emission")):
        found = color_errors(core, passes[key], source)
        assert set(found) == {thing.name for thing in objects}
        wrong = {n: (e.mean(), np.percentile(e, 99)) for n, e in found.items()
                 if e.mean() > 1 or np.percentile(e, 99) > tolerance}
        assert not wrong, (key, wrong)
    return core


def noise(tree, scale=3.0, output="Color", **inputs):
    return tree.node("ShaderNodeTexNoise", output, Scale=scale, **inputs)


def diffuse(name, color):
    tree = material(name)
    return tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=color(tree)))


def coordinates(tree, output, **settings):
    return tree.node("ShaderNodeTexCoord", output, settings)


def painted(obj):
    """Gives an object's mesh colours at vertices and at corners, and a grey at faces."""
    mesh, rng = obj.data, np.random.default_rng(3)
    for name, kind, domain, count in (("Vertices", "FLOAT_COLOR", "POINT", len(mesh.vertices)),
                                      ("Corners", "BYTE_COLOR", "CORNER", len(mesh.loops))):
        values = np.insert(rng.random((count, 3)), 3, 1, 1).astype(np.float32)
        mesh.attributes.new(name, kind, domain).data.foreach_set("color", values.ravel())
    mesh.attributes.new("Faces", "FLOAT", "FACE").data.foreach_set("value", rng.random(len(mesh.polygons)))
    mesh.attributes.default_color_name = "Corners"
    return obj


def nested(tree):
    """Noise two groups deep, behind a reroute, its scale set outside."""
    inner, outer = (bpy.data.node_groups.new(name, "ShaderNodeTree") for name in ("inner", "outer"))
    for group in (inner, outer):
        group.interface.new_socket("Scale", in_out="INPUT", socket_type="NodeSocketFloat")
        group.interface.new_socket("Result", in_out="OUTPUT", socket_type="NodeSocketColor")
    for group, kind in ((inner, "ShaderNodeTexNoise"), (outer, "ShaderNodeGroup")):
        given, result, node, reroute = (
            group.nodes.new(k) for k in ("NodeGroupInput", "NodeGroupOutput", kind, "NodeReroute"))
        if group == outer:
            node.node_tree = inner
        group.links.new(given.outputs["Scale"], node.inputs["Scale"])
        group.links.new(node.outputs["Result" if group == outer else "Color"], reroute.inputs[0])
        group.links.new(reroute.outputs[0], result.inputs["Result"])
    return tree.node("ShaderNodeGroup", set={"node_tree": outer}, Scale=4.0)


def colors():
    """Name -> function that gives the colour of a tree, each exactly what Cycles has."""
    pixels = np.concatenate([np.random.default_rng(7).random((8, 8, 3)), np.ones((8, 8, 1))], -1)
    file = image(pixels, "pixels")
    log = image(pixels, "log")
    log.colorspace_settings.name = "AgX Log"

    def ramp(tree):
        node = tree.node("ShaderNodeValToRGB").node
        tree.tree.links.new(noise(tree, output=0), node.inputs[0])
        node.color_ramp.elements[0].color, node.color_ramp.elements[1].color = (0.9, 0.2, 0.1, 1), (0.1, 0.3, 0.8, 1)
        return node.outputs[0]

    def curve(tree):
        node = tree.node("ShaderNodeRGBCurve", Color=(0.2, 0.5, 0.8)).node
        node.mapping.curves[3].points.new(0.4, 0.7)
        node.mapping.update()
        return node.outputs[0]

    def mixed(tree):
        return tree.node("ShaderNodeMix", 2, {"data_type": "RGBA", "blend_type": "MULTIPLY"}, Factor=1.0,
                         A=noise(tree), B=tree.node("ShaderNodeTexImage", "Color", {"image": file}))

    def moved(tree):
        vector = tree.node("ShaderNodeMapping", Vector=coordinates(tree, "UV"), Scale=(2, 3, 1), Rotation=(0, 0, 0.5))
        return tree.node("ShaderNodeTexImage", "Color", {"image": file}, Vector=vector)

    def placed(tree):
        node = tree.node("ShaderNodeTexImage", set={"image": file}).node
        node.texture_mapping.scale, node.texture_mapping.translation = (2, 3, 1), (0.3, 0.1, 0)
        return node.outputs[0]

    return {
        "ramp": ramp,
        "curve": curve,
        "mixed": mixed,
        "moved": moved,
        "placed": placed,
        "below nothing": lambda tree: tree.node("ShaderNodeMix", 2, {"data_type": "RGBA", "blend_type": "SUBTRACT"},
                                                Factor=1.0, A=noise(tree), B=(0.6, 0.5, 0.4)),
        "nested": nested,
        "generated": lambda tree: tree.node("ShaderNodeTexMagic", Scale=2.0),
        "object": lambda tree: noise(tree, Vector=coordinates(tree, "Object")),
        "uv": lambda tree: noise(tree, Vector=tree.node("ShaderNodeUVMap", set={"uv_map": "second"})),
        "box": lambda tree: tree.node("ShaderNodeTexImage", "Color", {"image": file, "projection": "BOX"},
                                      Vector=coordinates(tree, "Object")),
        "log": lambda tree: tree.node("ShaderNodeTexImage", "Color", {"image": log}),
        "vertices": lambda tree: tree.node("ShaderNodeVertexColor", set={"layer_name": "Vertices"}),
        "corners": lambda tree: tree.node("ShaderNodeVertexColor"),
        "faces": lambda tree: tree.node("ShaderNodeAttribute", 2, {"attribute_name": "Faces"}),
        "position": lambda tree: noise(tree, Vector=tree.node("ShaderNodeNewGeometry", "Position")),
        "random": lambda tree: tree.node("ShaderNodeCombineColor", Red=tree.node("ShaderNodeObjectInfo", "Random"),
                                         Green=tree.node("ShaderNodeAttribute", 2, {
                                             "attribute_type": "OBJECT", "attribute_name": "own"})),
        "tint": lambda tree: tree.node("ShaderNodeObjectInfo", "Color"),
    }


def test_colours(tmp_path):
    things = []
    for x, (name, color) in enumerate(colors().items()):
        thing = painted(square(diffuse(name, color), name=name, location=(x, 0, 0)))
        thing.color, thing["own"] = (0.3, 0.6, 0.9, 1), 0.4
        things.append(thing)
    assert compared(tmp_path, things, len(things)).approximated == ()


def shaders():
    """Name -> material whose shaders are mixed by textures."""
    made = {}

    def add(name, shader):
        tree = material(name)
        made[name] = tree.surface(shader(tree))

    def mix(tree, share, a, b):
        node = tree.node("ShaderNodeMixShader").node
        for socket, value in zip(node.inputs, (share, a, b)):
            tree.tree.links.new(value, socket)
        return node.outputs[0]

    def bsdf(tree, color):
        return tree.node("ShaderNodeBsdfDiffuse", Color=color)

    add("two", lambda t: mix(t, noise(t, output=0), bsdf(t, noise(t, 5.0)), bsdf(t, (0.1, 0.5, 0.9))))
    add("lit", lambda t: mix(t, noise(t, output=0), bsdf(t, (0.5, 0.5, 0.5)), t.node(
        "ShaderNodeEmission", Color=noise(t, 4.0), Strength=t.node("ShaderNodeTexWave", 1))))
    add("metal", lambda t: t.node("ShaderNodeBsdfPrincipled", Base_Color=noise(t), Metallic=noise(t, 5.0, 0),
                                  Specular_IOR_Level=0.0))
    return made


def test_shaders_mixed_by_textures(tmp_path):
    things = [square(each, name=name, location=(x, 0, 0)) for x, (name, each) in enumerate(shaders().items())]
    told = compared(tmp_path, things, len(things)).approximated
    assert all(sentence.startswith("Reflections") or "Principled" in sentence for sentence in told)


def test_alpha(tmp_path):
    """Cycles shows a surface's colour by how solid it is."""
    tree = material("veil")
    mix = tree.node("ShaderNodeMixShader")
    tree.tree.links.new(noise(tree, 4.0, 0), mix.node.inputs[0])
    tree.tree.links.new(tree.node("ShaderNodeBsdfTransparent"), mix.node.inputs[1])
    tree.tree.links.new(tree.node("ShaderNodeBsdfDiffuse", Color=(0.9, 0.5, 0.2)), mix.node.inputs[2])
    veil = square(tree.surface(mix), name="veil")
    overhead_camera(1, 1)
    bpy.context.scene.cycles.transparent_max_bounces = 8
    alone = render(tmp_path, 48, 48)["Diffuse Color"]
    core = read_baked()
    assert core.materials[0].albedo.value == pytest.approx([0.9, 0.5, 0.2]) and core.materials[0].alpha.texture
    shown = color_errors(core, alone, "alpha", np.array([0.9, 0.5, 0.2]))[veil.name]
    assert shown.mean() < 1 and np.percentile(shown, 99) < 3


def test_each_object_has_its_own_where_it_matters(tmp_path):
    """Six objects of one mesh; of two materials one depends on the place."""
    here = diffuse("here", lambda tree: noise(tree, Vector=tree.node("ShaderNodeNewGeometry", "Position")))
    mesh = square(here).data
    mesh.materials.append(diffuse("everywhere", lambda tree: noise(tree)))
    bpy.data.objects.remove(bpy.data.objects["object"])
    mesh.vertices.add(4)
    mesh.loops.add(4)
    mesh.polygons.add(1)
    for k, (x, y) in enumerate(((0, 1), (1, 1), (1, 2), (0, 2))):
        mesh.vertices[4 + k].co, mesh.loops[4 + k].vertex_index = (x, y, 0), 4 + k
    mesh.polygons[1].loop_start, mesh.polygons[1].material_index = 4, 1
    mesh.update(calc_edges=True)
    things = [link(mesh, f"o{x}", location=(x, 0, 0)) for x in range(6)]
    things[2].scale, things[2].location = (-1, 1, 1), (3, 0, 0)
    core = compared(tmp_path, things, 6, 2)
    names = [m.name for m in core.materials]
    assert names.count("here") == 6 and names.count("everywhere") == 1


def test_modifiers(tmp_path):
    """Generated coordinates are those of the mesh at rest; triangles are those of the evaluated one."""
    bent = square(diffuse("bent", lambda tree: noise(tree, 6.0)), name="bent")
    for kind, settings in (("SUBSURF", {"subdivision_type": "SIMPLE", "levels": 1, "render_levels": 3}),
                           ("SIMPLE_DEFORM", {"deform_method": "TAPER", "factor": 0.6, "deform_axis": "X"})):
        modifier = bent.modifiers.new(kind, kind)
        for name, value in settings.items():
            setattr(modifier, name, value)
    keyed = square(diffuse("keyed", lambda tree: noise(tree, 6.0)), name="keyed", location=(1, 0, 0))
    keyed.shape_key_add(name="Basis")
    keyed.shape_key_add(name="moved").data[2].co = (0.6, 0.6, 0)
    keyed.data.shape_keys.key_blocks["moved"].value = 1
    core = compared(tmp_path, [bent, keyed], 2)
    assert len(core.meshes[0].triangles) == 2 * 4**3


def test_copies_by_instancing(tmp_path):
    collection = bpy.data.collections.new("shown")
    thing = square(diffuse("random", lambda tree: tree.node("ShaderNodeMix", 2, {"data_type": "RGBA"}, Factor=tree.node(
        "ShaderNodeObjectInfo", "Random"), A=noise(tree), B=(0.0, 0.1, 0.9))), name="thing")
    bpy.context.scene.collection.objects.unlink(thing)
    collection.objects.link(thing)
    for x in range(3):
        link(None, f"empty {x}", location=(x, 0, 0), instance_type="COLLECTION", instance_collection=collection)
    core = compared(tmp_path, [thing], 3)
    assert len(core.materials) == 3


def test_values_that_change_with_time(tmp_path):
    tree = material("driven")
    color = noise(tree, 3.0)
    curve = color.node.inputs["Scale"].driver_add("default_value")
    curve.driver.expression = "frame / 2"
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=color)), name="driven")
    for frame in (4, 9):
        bpy.context.scene.frame_set(frame)
        compared(tmp_path, [bpy.data.objects["driven"]], 1)


def saved(folder, name, color):
    made = image(np.broadcast_to(np.array([*color, 1.0]), (4, 4, 4)), name)
    made.filepath_raw, made.file_format = str(folder / name), "PNG"
    made.save()
    bpy.data.images.remove(made)


@pytest.mark.parametrize("packed", [False, True])
def test_tiles_and_sequences(tmp_path, packed):
    shades = ((0.8, 0.2, 0.1), (0.1, 0.7, 0.2), (0.2, 0.3, 0.9))
    for k, shade in enumerate(shades):
        saved(tmp_path, f"tile.{1001 + k}.png", shade)
        saved(tmp_path, f"frame.{1 + k:04d}.png", shade)
    tiled = bpy.data.images.load(str(tmp_path / "tile.1001.png"))
    tiled.source = "TILED"
    tiled.filepath = str(tmp_path / "tile.<UDIM>.png")
    for k in (1, 2):
        tiled.tiles.new(1001 + k)
    frames = bpy.data.images.load(str(tmp_path / "frame.0001.png"))
    if packed:  # of a sequence one frame, which Blender never shows
        tiled.pack()
        frames.pack()
        for file in tmp_path.glob("tile.*.png"):
            file.unlink()
    frames.source = "SEQUENCE"

    def sequence(tree):
        node = tree.node("ShaderNodeTexImage", set={"image": frames}).node
        node.image_user.frame_duration, node.image_user.use_auto_refresh = 3, True
        return node.outputs[0]

    wide = square(diffuse("tiled", lambda tree: tree.node("ShaderNodeTexImage", set={
        "image": tiled, "interpolation": "Closest"})), name="tiled")
    for loop in wide.data.uv_layers["first"].uv:
        loop.vector.x *= 3
    play = square(diffuse("sequence", sequence), name="sequence", location=(1, 0, 0))
    found = []
    for frame in (1, 3):
        bpy.context.scene.frame_set(frame)
        # Where tiles meet, a texel may show either.
        core = compared(tmp_path, [wide, play], 2, tolerance=200)
        found.append(core.materials[1].albedo.value)
    assert np.abs(found[0] - found[1]).max() > 0.1 and core.materials[0].albedo.texture
    (tmp_path / "frame.0003.png").unlink()
    with pytest.raises(ValueError, match=r"frame.*relink it"):
        read_baked()


def test_packed_and_generated_images(tmp_path):
    """As they are and through a node, without their files."""
    pixels = np.insert(np.random.default_rng(2).random((4, 4, 3)), 3, 1, -1)
    files = []
    for name in ("packed", "tile.1001", "tile.1002"):
        made = image(pixels if name == "packed" else pixels[::-1], name)
        files.append(tmp_path / f"{name}.png")
        made.filepath_raw, made.file_format = str(files[-1]), "PNG"
        made.save()
        bpy.data.images.remove(made)
    pictures = {"packed": bpy.data.images.load(str(files[0])), "tiled": bpy.data.images.load(str(files[1]))}
    pictures["tiled"].source = "TILED"
    pictures["tiled"].filepath = str(tmp_path / "tile.<UDIM>.png")
    pictures["tiled"].tiles.new(1002)
    for picture in pictures.values():
        picture.pack()
    for file in files:
        file.unlink()
    for kind in ("UV_GRID", "COLOR_GRID"):
        pictures[kind] = bpy.data.images.new(kind, 40, 40)  # of whose texels none ends at a pixel's centre
        pictures[kind].generated_type = kind
    things = []
    for name, picture in pictures.items():
        for through in (False, True):
            def color(tree, picture=picture, through=through):
                found = tree.node("ShaderNodeTexImage", set={"image": picture, "interpolation": "Closest"})
                return tree.node("ShaderNodeGamma", Color=found, Gamma=1.5) if through else found

            title = f"{name} {through}"
            things.append(square(diffuse(title, color), name=title, location=(len(things), 0, 0)))
    for thing in things[2:4]:
        for loop in thing.data.uv_layers["first"].uv:
            loop.vector.x *= 2
    # Where texels meet, a pixel may show either.
    core = compared(tmp_path, things, len(things), tolerance=200)
    assert not core.approximated


def test_what_depends_on_the_view_is_told():
    tree = material("rim")
    mix = tree.node("ShaderNodeMix", 2, {"data_type": "RGBA"}, Factor=tree.node("ShaderNodeLayerWeight", "Facing"),
                    A=noise(tree), B=(1.0, 0.0, 0.0))
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=mix)))
    core = read_baked()
    assert core.materials[0].albedo.texture
    assert [note for note in core.approximated if "Layer Weight' depends on the view" in note]


def test_what_tells_sides_apart_or_is_too_fine_is_told():
    def sided(tree):
        side = tree.node("ShaderNodeNewGeometry", "Backfacing")
        return tree.node("ShaderNodeMix", 2, {"data_type": "RGBA"}, Factor=side, A=(0.8, 0.1, 0.1), B=(0.1, 0.8, 0.1))

    square(diffuse("sided", sided))
    for name, scale in (("coarse", 3.0), ("fine", 3000.0)):
        square(diffuse(name, lambda tree, scale=scale: noise(tree, scale)))
    core = read_baked()
    assert core.materials[0].albedo.value == pytest.approx([0.8, 0.1, 0.1], abs=1e-3)
    assert [note.split("'")[1] for note in core.approximated] == ["sided", "fine"]
    assert "tells sides apart" in core.approximated[0] and "finer detail" in core.approximated[1]


def test_emission_below_nothing_is_none_and_told():
    tree = material("dark")
    color = tree.node("ShaderNodeMix", 2, {"data_type": "RGBA", "blend_type": "SUBTRACT"}, Factor=1.0, A=noise(tree),
                      B=(0.5, 0.5, 0.5))  # fmt: skip
    square(tree.surface(tree.node("ShaderNodeEmission", Color=color)))
    tree = material("negative")
    square(tree.surface(tree.node("ShaderNodeEmission", Color=(1.0, 0.5, 0.2), Strength=-2.0)))
    core = read_baked()
    pixels = core.materials[0].emission.texture.pixels
    assert pixels.min() == 0 < pixels.max() and not core.materials[1].emission.value.any()
    assert [note.split("'")[1] for note in core.approximated if "below nothing" in note] == ["dark", "negative"]


def test_more_objects_than_textures_take_turns(monkeypatch):
    monkeypatch.setattr("gi_bake.addon.read.surface_bakes._OBJECTS", 3)
    thing = square(diffuse("random", lambda tree: tree.node("ShaderNodeObjectInfo", "Random")))
    for x in range(6):
        link(thing.data, location=(x, 0, 0))
    core = read_baked()
    assert len(core.materials) == 3 and len({i.materials for i in core.instances}) == 3
    assert [note for note in core.approximated if "all but 3" in note]


def test_a_mesh_of_too_many_triangles_has_the_constant(monkeypatch):
    monkeypatch.setattr("gi_bake.addon.read.surface_bakes._TRIANGLES", 1)
    square(diffuse("checker", lambda tree: tree.node("ShaderNodeTexChecker", Color1=(0.2, 0.4, 0.6),
                                                     Color2=(0.4, 0.8, 1.0))))
    core = read_baked()
    assert core.materials[0].albedo.value == pytest.approx([0.3, 0.6, 0.8])
    assert "too many triangles" in core.approximated[0] and "(0.3, 0.6, 0.8)" in core.approximated[1]


def test_the_frame_of_a_sphere_has_no_seams(tmp_path):
    """Any shape of triangle: what is seen of a ball."""
    bpy.ops.mesh.primitive_uv_sphere_add(segments=32, ring_count=16, radius=0.5, location=(0.5, 0.5, 0))
    ball = bpy.context.object
    ball.data.shade_smooth()
    ball.rotation_euler = (0.3, 0.8, math.pi / 3)
    ball.data.materials.append(diffuse("ball", lambda tree: noise(tree, 4.0)))
    compared(tmp_path, [ball], 1)


def test_textures_fit_the_bound(monkeypatch):
    monkeypatch.setattr("gi_bake.addon.read.surface_bakes._ALL", 18)
    for x in range(8):
        square(diffuse(f"noise {x}", lambda tree, x=x: noise(tree, 3.0 + x)), location=(x, 0, 0))
    core = read_baked()
    assert sum(m.albedo.texture.pixels.size // 3 for m in core.materials) <= 1 << 18


def test_nothing_is_baked_without_need(monkeypatch):
    def fail(*_):
        raise AssertionError

    monkeypatch.setattr("gi_bake.addon.read.surface_bakes._Studio.baked", fail)
    tree = Tree(bpy.data.materials.new("plain"))
    square(tree.surface(tree.node("ShaderNodeBsdfPrincipled", Alpha=tree.node("ShaderNodeLightPath", "Is Camera Ray"))))
    bakes = SurfaceBakes(None)
    read_baked(bakes=bakes)
    assert not bakes.patches
