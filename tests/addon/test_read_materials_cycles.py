# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the reader makes of materials against what Cycles does with them, in tiny renders."""

import bpy
import numpy as np
import pytest
from gi_bake.tests.shader_trees import image, material, overhead_camera, read, render, square


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def looked_up(color, uv):
    """A `ColorSource` at `uv` (…, 2), without interpolation."""
    if color.texture is None:
        return np.broadcast_to(color.value, (*uv.shape[:-1], 3))
    height, width = color.texture.pixels.shape[:2]
    size = np.array([width, height])
    cell = np.floor(uv * size).astype(int)
    outside = ((cell < 0) | (cell >= size)).any(-1)
    folded = np.where(cell // size % 2, size - 1 - cell % size, cell % size)
    column, row = np.moveaxis({"MIRROR": folded, "REPEAT": cell % size}.get(
        color.texture.extension, np.clip(cell, 0, size - 1)), -1, 0)
    pixels = color.texture.pixels[row, column]
    if color.texture.extension == "CLIP":
        pixels = np.where(outside[..., None], 0, pixels)
    return color.value * pixels


@pytest.fixture
def images():
    """Byte images of the same random pixels, by what is special about them, and a float one."""
    pixels = np.random.default_rng(7).random((4, 4, 4))
    made = {name: image(pixels, name, alpha_mode=name) for name in ("STRAIGHT", "CHANNEL_PACKED", "NONE")}
    made["DATA"] = bpy.data.images.new("DATA", 4, 4, alpha=True, is_data=True)
    made["DATA"].pixels.foreach_set(pixels.astype(np.float32).ravel())
    pixels[..., 3] = 1
    made["OPAQUE"] = image(pixels, "OPAQUE")
    made["FLOAT"] = image(pixels * [3, 3, 3, 1], "FLOAT", float_buffer=True)
    return made


def plain_materials(images):
    """Name -> material of which the reader should take everything exactly; names that hold "second" use that map."""
    made = {}

    def diffuse(name, color):
        tree = material(name)
        made[name] = tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=color(tree)))

    def lookup(tree, image, uv=None, **settings):
        settings = {"image": image, "interpolation": "Closest", **settings}
        vector = {"Vector": tree.node("ShaderNodeUVMap", set={"uv_map": uv})} if uv else {}
        return tree.node("ShaderNodeTexImage", "Color", set=settings, **vector)

    def tinted(tree, a, b):
        return tree.node("ShaderNodeMix", 2, {"data_type": "RGBA", "blend_type": "MULTIPLY"}, Factor=1.0, A=a, B=b)

    made["none"] = None
    diffuse("diffuse", lambda tree: (0.1, 0.5, 0.9))
    for name, file in images.items():
        diffuse(f"image {name}", lambda tree, file=file: lookup(tree, file))
    for extension in ("REPEAT", "EXTEND", "CLIP", "MIRROR"):
        diffuse(f"second {extension}", lambda tree, extension=extension: lookup(
            tree, images["OPAQUE"], "second", extension=extension))
    diffuse("tinted", lambda tree: tinted(tree, lookup(tree, images["OPAQUE"]), (0.2, 0.4, 0.8)))
    diffuse("tinted, other way", lambda tree: tinted(tree, (0.2, 0.4, 0.8), lookup(tree, images["OPAQUE"])))
    diffuse("muted", lambda tree: mute(tree.node("ShaderNodeInvert", Color=lookup(tree, images["OPAQUE"]))))
    diffuse("grouped", lambda tree: grouped(tree, lookup(tree, images["OPAQUE"]), (0.3, 0.6, 0.9)))
    diffuse("computed", lambda tree: tree.node("ShaderNodeMix", 2, {"data_type": "RGBA"}, Factor=tree.node(
        "ShaderNodeMath", set={"operation": "MULTIPLY"}, Value=0.5), A=(0.2, 0.4, 0.6), B=(1.0, 0.0, 0.5)))
    color = {"Color": (0.7, 0.2, 0.1)}
    diffuse("hue", lambda tree: tree.node("ShaderNodeHueSaturation", Hue=0.6, Saturation=0.7, Value=0.8, **color))
    diffuse("saturated", lambda tree: tree.node("ShaderNodeHueSaturation", Saturation=1.9, **color))
    diffuse("inverted", lambda tree: tree.node("ShaderNodeInvert", **color))
    diffuse("gamma", lambda tree: tree.node("ShaderNodeGamma", Gamma=1.7, **color))
    diffuse("contrast", lambda tree: tree.node("ShaderNodeBrightContrast", Contrast=0.4, **color))
    diffuse("separated", lambda tree: tree.node("ShaderNodeCombineColor", Red=tree.node(
        "ShaderNodeSeparateColor", "Green", Color=(0.1, 0.7, 0.3)), Green=0.5, Blue=0.25))

    tree = material("emission")
    made["emission"] = tree.surface(tree.node("ShaderNodeEmission", Color=lookup(tree, images["OPAQUE"]), Strength=3.0))
    tree = material("principled emission")
    made["principled emission"] = tree.surface(tree.node(
        "ShaderNodeBsdfPrincipled", Base_Color=(0.0, 0.0, 0.0), Emission_Color=(0.2, 0.5, 1.0), Emission_Strength=7.0))
    tree = material("mixed")
    mix = tree.node("ShaderNodeMixShader")
    mix.node.inputs[0].default_value = 0.25
    tree.tree.links.new(tree.node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.4, 0.2)), mix.node.inputs[1])
    tree.tree.links.new(tree.node("ShaderNodeEmission", Color=(1.0, 2.0, 3.0)), mix.node.inputs[2])
    made["mixed"] = tree.surface(mix)
    tree = material("added")
    add = tree.node("ShaderNodeAddShader")
    tree.tree.links.new(tree.node("ShaderNodeBsdfDiffuse", Color=(0.3, 0.2, 0.1)), add.node.inputs[0])
    tree.tree.links.new(tree.node("ShaderNodeBsdfDiffuse", Color=(0.1, 0.2, 0.3)), add.node.inputs[1])
    made["added"] = tree.surface(add)
    tree = material("nothing")
    tree.tree.nodes.new("ShaderNodeOutputMaterial")
    made["nothing"] = tree.owner
    return made


def mute(socket):
    socket.node.mute = True
    return socket


def grouped(tree, color, tint):
    """`color` times `tint` in a node group of its own, behind a reroute."""
    group = bpy.data.node_groups.new("tint", "ShaderNodeTree")
    group.interface.new_socket("Tint", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Color", in_out="INPUT", socket_type="NodeSocketColor")
    group.interface.new_socket("Result", in_out="OUTPUT", socket_type="NodeSocketColor")
    inputs, output = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    mix = group.nodes.new("ShaderNodeMix")
    mix.data_type, mix.blend_type = "RGBA", "MULTIPLY"
    mix.inputs[0].default_value = 1.0
    group.links.new(inputs.outputs["Tint"], mix.inputs[6])
    group.links.new(inputs.outputs["Color"], mix.inputs[7])
    group.links.new(mix.outputs[2], output.inputs["Result"])
    reroute = tree.tree.nodes.new("NodeReroute")
    tree.tree.links.new(color, reroute.inputs[0])
    return tree.node("ShaderNodeGroup", set={"node_tree": group}, Tint=tint, Color=reroute.outputs[0])


def test_plain_materials(tmp_path, images):
    made = plain_materials(images)
    for index, (name, each) in enumerate(made.items()):
        square(each, name=name, location=(index, 0, 0))
    overhead_camera(len(made), 1)
    passes = render(tmp_path, len(made) * 8, 8)
    scene = read()
    assert [instance.name for instance in scene.instances] == list(made)
    centre = (np.arange(8) + 0.5) / 8
    wrong = []
    for instance in scene.instances:
        index = list(made).index(instance.name)
        surface = scene.materials[instance.materials[0]]
        for key, color in (("Diffuse Color", surface.albedo), ("Emission", surface.emission)):
            assert not color.texture or color.uv == ("second" if "second" in instance.name else "")
            uv = np.stack(np.meshgrid(centre, centre), -1) * (2 if color.uv else 1)
            patch = passes[key][:, index * 8 : index * 8 + 8]
            # Cycles rounds to bytes after multiplying by alpha. Since 5.0 no material means a Principled BSDF, which is
            # brighter from above than on average.
            tolerance = {"image STRAIGHT": 0.01, "none": 0.03}.get(instance.name, 2e-3)
            if not np.allclose(looked_up(color, uv), patch, atol=tolerance, rtol=2e-3):
                wrong.append((instance.name, key, looked_up(color, uv)[0, 0], patch[0, 0]))
    assert not wrong, "\n".join(map(str, wrong))
    assert scene.approximated == (
        "Reflections in glossy surfaces are not baked; they light other surfaces as if they were diffuse.",
        "What a Principled BSDF reflects diffusely depends on the view; its mean over all views is taken.",
    )


def ball(material=None):
    mesh = bpy.data.meshes.new("ball")
    bpy.ops.mesh.primitive_uv_sphere_add(segments=96, ring_count=48, location=(1, 1, 0))
    mesh = bpy.context.object.data
    mesh.shade_smooth()
    if material:
        mesh.materials.append(material)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"Roughness": 0.0},
        {"Roughness": 0.25},
        {"Roughness": 1.0},
        {"IOR": 1.2, "Roughness": 0.0},
        {"IOR": 2.0, "Roughness": 0.3},
        {"Specular_IOR_Level": 0.0},
        {"Specular_IOR_Level": 1.0, "Roughness": 0.1},
        {"Metallic": 0.3, "Transmission_Weight": 0.25},
        {"Metallic": 1.0},
        {"Subsurface_Weight": 1.0, "Subsurface_Radius": (0.0, 0.0, 0.0)},
        None,
    ],
)
def test_principled_albedo_is_the_mean_over_views(tmp_path, values):
    """A ball seen from far away shows each direction of a hemisphere in proportion to its cosine."""
    if values is None:
        ball()
    else:
        tree = material()
        ball(tree.surface(tree.node("ShaderNodeBsdfPrincipled", Base_Color=(0.9, 0.6, 0.3), **values)))
    overhead_camera(2, 2)
    shown = render(tmp_path, 64, 64)["Diffuse Color"]
    mean = shown.sum((0, 1)) / (64 * 64 * np.pi / 4)
    [surface] = read().materials
    assert surface.albedo.value == pytest.approx(mean, abs=0.012)


def approximated(make):
    """The material that `make(tree)` gives, as it is read, and what is told of it."""
    tree = material()
    square(make(tree))
    scene = read()
    assert all(sentence.startswith("Material 'material': ") for sentence in scene.approximated)
    return scene.materials[0], scene.approximated


def test_procedural_colours_become_constants():
    surface, told = approximated(lambda tree: tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=tree.node(
        "ShaderNodeTexChecker", "Color", Color1=(0.2, 0.4, 0.6), Color2=(0.4, 0.8, 1.0)))))
    assert surface.albedo.value == pytest.approx([0.3, 0.6, 0.8])
    assert len(told) == 1 and "Checker Texture" in told[0] and "(0.3, 0.6, 0.8)" in told[0]


def test_images_in_other_places_become_their_mean(images):
    def make(tree):
        vector = tree.node("ShaderNodeMapping", Vector=tree.node("ShaderNodeTexCoord", "Object"))
        return tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=tree.node(
            "ShaderNodeTexImage", "Color", {"image": images["FLOAT"]}, Vector=vector)))

    surface, told = approximated(make)
    mean = np.array(images["FLOAT"].pixels).reshape(-1, 4)[:, :3].mean(0)
    assert surface.albedo.texture is None
    assert surface.albedo.value == pytest.approx(np.minimum(mean, 1), rel=1e-4)
    assert "Image Texture" in told[0]


def test_other_colour_spaces_are_told(images):
    images["OPAQUE"].colorspace_settings.name = "AgX Log"

    def make(tree):
        texture = tree.node("ShaderNodeTexImage", "Color", {"image": images["OPAQUE"]})
        return tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=texture))

    assert "AgX Log" in approximated(make)[1][0]


def test_glossy_shaders_have_no_diffuse_part():
    surface, told = approximated(lambda tree: tree.surface(tree.node("ShaderNodeBsdfGlass")))
    assert not surface.albedo.value.any() and "Glass BSDF" in told[0]


def test_what_principled_has_besides_is_told():
    def make(tree):
        socket = tree.node("ShaderNodeBsdfPrincipled", Base_Color=(0.0, 0.0, 0.0), Transmission_Weight=0.5, Alpha=0.5,
                           Coat_Weight=0.1, Normal=tree.node("ShaderNodeNormalMap", Color=(0.9, 0.5, 0.8)))
        material = tree.surface(socket)
        volume = tree.node("ShaderNodeVolumeAbsorption")
        tree.tree.links.new(volume, tree.tree.nodes["Material Output"].inputs["Volume"])
        return material

    tree = material()
    square(make(tree))
    told = " ".join(read().approximated)
    for word in ("coat", "50% of it is glass", "normal or bump", "volume", "Reflections"):
        assert word in told


def test_an_image_is_read_once(images, monkeypatch):
    from gi_bake.addon.read import images as reader

    reads = []
    real = reader.read_pixels
    monkeypatch.setattr(reader, "read_pixels", lambda image, *alpha: reads.append(image.name) or real(image, *alpha))
    for _ in range(5):
        tree = material()
        texture = tree.node("ShaderNodeTexImage", "Color", {"image": images["OPAQUE"]})
        square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=texture)))
    scene = read()
    assert reads == ["OPAQUE"]
    assert len({id(surface.albedo.texture) for surface in scene.materials}) == 1


def test_missing_images_are_named(tmp_path):
    tree = material("wall")
    gone = bpy.data.images.new("gone", 4, 4)
    gone.source, gone.filepath = "FILE", str(tmp_path / "not there.png")
    texture = tree.node("ShaderNodeTexImage", "Color", {"image": gone})
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=texture)))
    with pytest.raises(ValueError, match=r"'gone'.*not there\.png"):
        read()
    texture.node.image = None
    with pytest.raises(ValueError, match="Material 'wall'"):
        read()
