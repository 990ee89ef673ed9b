# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the reader makes of materials, lights and worlds against what Cycles does with them, in tiny renders."""

import math

import bpy
import numpy as np
import OpenEXR
import pytest
from gi_bake.addon.read import read_scene


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def read():
    return read_scene(bpy.context.scene, bpy.context.view_layer)


def link(data, name="object", **attributes):
    thing = bpy.data.objects.new(name, data)
    for attribute, value in attributes.items():
        setattr(thing, attribute, value)
    bpy.context.scene.collection.objects.link(thing)
    return thing


def square(material=None, size=1.0, **attributes):
    """A square in the plane z = 0 with corners at 0 and `size`, and the UV maps "first" (0…1) and "second" (0…2)."""
    mesh = bpy.data.meshes.new("square")
    mesh.from_pydata([(0, 0, 0), (size, 0, 0), (size, size, 0), (0, size, 0)], [], [(0, 1, 2, 3)])
    corners = np.array([0, 0, 1, 0, 1, 1, 0, 1], np.float32)
    mesh.uv_layers.new(name="first").uv.foreach_set("vector", corners)
    mesh.uv_layers.new(name="second").uv.foreach_set("vector", corners * 2)
    if material:
        mesh.materials.append(material)
    return link(mesh, **attributes)


def overhead_camera(width, height):
    camera = bpy.data.cameras.new("camera")
    camera.type, camera.ortho_scale = "ORTHO", max(width, height)
    bpy.context.scene.camera = link(camera, location=(width / 2, height / 2, 10))


def render(tmp_path, width, height, samples=4, bounces=0):
    """Cycles' passes as arrays with row 0 at the bottom: keys "Combined", "Diffuse Color" and "Emission"."""
    scene = bpy.context.scene
    scene.render.engine = "CYCLES"
    scene.cycles.device, scene.cycles.samples, scene.cycles.max_bounces = "CPU", samples, bounces
    scene.cycles.use_denoising = scene.cycles.use_adaptive_sampling = False
    scene.cycles.filter_width = 0.01
    scene.render.resolution_x, scene.render.resolution_y, scene.render.resolution_percentage = width, height, 100
    bpy.context.view_layer.use_pass_diffuse_color = bpy.context.view_layer.use_pass_emit = True
    settings = scene.render.image_settings
    if bpy.app.version >= (5, 0, 0):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth = "OPEN_EXR_MULTILAYER", "32"
    scene.render.filepath = str(tmp_path / "passes.exr")
    bpy.ops.render.render(write_still=True)
    names = {"DiffCol": "Diffuse Color", "Emit": "Emission"}
    with OpenEXR.File(scene.render.filepath) as file:
        return {
            names.get(key := name.split(".")[1], key): channel.pixels[::-1, :, :3]
            for part in file.parts
            for name, channel in part.channels.items()
        }


class Tree:
    """The node tree of a material, light or world, written in a line or two."""

    def __init__(self, owner):
        if not getattr(owner.bl_rna.properties["use_nodes"], "is_deprecated", False):
            owner.use_nodes = True
        self.owner, self.tree = owner, owner.node_tree
        self.tree.nodes.clear()

    def node(self, kind, output=0, set=(), **inputs):
        """The output of a new node; inputs by name (spaces as underscores) are values or outputs."""
        node = self.tree.nodes.new(kind)
        for attribute, value in dict(set).items():
            setattr(node, attribute, value)
        for name, value in inputs.items():
            socket = next(s for s in node.inputs if s.name == name.replace("_", " ") and not s.is_unavailable)
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            else:
                socket.default_value = (*value, 1.0) if socket.type == "RGBA" and len(value) == 3 else value
        return next(s for s in node.outputs if s.name == output) if isinstance(output, str) else node.outputs[output]

    def surface(self, shader, kind="ShaderNodeOutputMaterial"):
        self.tree.links.new(shader, self.tree.nodes.new(kind).inputs["Surface"])
        return self.owner


def material(name="material"):
    return Tree(bpy.data.materials.new(name))


def image(pixels, name="image", **attributes):
    """A generated image of (h, w, 4) `pixels`."""
    height, width = pixels.shape[:2]
    image = bpy.data.images.new(name, width, height, alpha=True, float_buffer=attributes.pop("float_buffer", False))
    for attribute, value in attributes.items():
        setattr(image, attribute, value)
    image.pixels.foreach_set(pixels.astype(np.float32).ravel())
    image.update()
    return image


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


def lamp(kind, name="lamp", scale=(1, 1, 1), **attributes):
    light = bpy.data.lights.new(name, kind)
    light.energy = 10
    for attribute, value in attributes.items():
        setattr(light, attribute, value)
    return link(light, name, location=(0.05, 0.05, 3), scale=scale)


def brightness(tmp_path):
    """Of a small white square at the origin, at right angles to where lamps are: (3,)."""
    return render(tmp_path, 8, 8, samples=32)["Combined"].mean((0, 1))


@pytest.fixture
def white_square():
    tree = material("white")
    square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=(1.0, 1.0, 1.0))), size=0.1)
    overhead_camera(0.1, 0.1)


def lamp_nodes(light):
    tree = Tree(light.data)
    color = tree.node("ShaderNodeBlackbody", Temperature=4000.0)
    tree.surface(tree.node("ShaderNodeEmission", Color=color, Strength=3.0), "ShaderNodeOutputLight")


@pytest.mark.parametrize("kind", ["POINT", "SPOT", "AREA", "SUN"])
@pytest.mark.parametrize(
    "attributes",
    [
        {"color": (0.2, 0.5, 0.8)},
        {"exposure": -1.5},
        {"use_temperature": True, "temperature": 3000, "color": (0.5, 1, 1)},
        {"normalize": False},
        {"normalize": False, "size": 0.3},
        {"normalize": False, "scale": (2, 0.5, 3)},
        {"normalize": False, "scale": (-2, 2, 1)},
        {"nodes": True},
    ],
    ids=str,
)
def test_what_is_folded_into_the_power_of_a_light(tmp_path, white_square, kind, attributes):
    sizes = {"POINT": "shadow_soft_size", "SPOT": "shadow_soft_size", "AREA": "size", "SUN": "angle"}
    attributes = {sizes[kind] if key == "size" else key: value for key, value in attributes.items()}
    nodes = attributes.pop("nodes", False)
    plain = lamp(kind, **{sizes[kind]: attributes.get(sizes[kind], 0.2)}, scale=attributes.get("scale", (1, 1, 1)))
    expected = brightness(tmp_path)
    plain.hide_render = True
    light = lamp(kind, **{sizes[kind]: 0.2, **attributes})
    if nodes:
        lamp_nodes(light)
    ratio = brightness(tmp_path) / expected
    plain.hide_render = False
    first, second = read().lights
    # A Blackbody node is read through colour matching functions that are not quite those of Cycles.
    assert second.power / first.power == pytest.approx(ratio, rel=0.03 if nodes else 1e-3)


@pytest.mark.parametrize("shape", ["SQUARE", "RECTANGLE", "DISK", "ELLIPSE"])
def test_area_of_lights(tmp_path, white_square, shape):
    """A light's radiance is P/(πA): without Normalize it is in the file and the area is in P."""
    light = lamp("AREA", shape=shape, size=0.3, size_y=0.1, normalize=False, scale=(0.5, 1.5, 1))
    shown = brightness(tmp_path)
    [found] = read().lights
    assert found.size == pytest.approx({"SQUARE": (0.3, 0.3), "DISK": (0.3, 0.3)}.get(shape, (0.3, 0.1)))
    assert found.shape == ("ELLIPSE" if shape in {"DISK", "ELLIPSE"} else "RECTANGLE")
    assert found.power / np.pi / 3**2 / np.pi == pytest.approx(shown, rel=0.01)  # intensity P/π, seen from far away
    light.data.normalize = True
    assert read().lights[0].power == pytest.approx([10, 10, 10])


def test_lights_without_size(tmp_path, white_square):
    for kind, size in (("POINT", "shadow_soft_size"), ("SPOT", "shadow_soft_size"), ("SUN", "angle")):
        light = lamp(kind, **{size: 0.0})
        expected = brightness(tmp_path)
        power = read().lights[0].power
        light.data.normalize = False
        ratio = brightness(tmp_path) / expected
        assert read().lights[0].power / power == pytest.approx(ratio, rel=1e-3)
        bpy.data.objects.remove(light)


def test_lights_that_light_nothing_are_left_out(tmp_path, white_square):
    lamp("POINT").visible_diffuse = False
    lamp("POINT").hide_render = True
    tree = Tree(lamp("POINT").data)
    tree.tree.nodes.new("ShaderNodeOutputLight")
    assert not brightness(tmp_path).any()
    lamp("AREA").data.cycles.is_portal = True  # not rendered: Cycles 5.2 may crash on one without a world
    assert read().lights == ()


def test_fields_of_lights():
    spot = lamp("SPOT", "spot", spot_size=1.1, spot_blend=0.3, shadow_soft_size=0.25, use_soft_falloff=False)
    spot.data.use_shadow = False
    lamp("SUN", "sun", angle=0.4)
    lamp("AREA", "area", spread=0.7)
    spot, sun, area = read().lights
    assert (spot.kind, spot.soft_falloff, spot.shadow) == ("SPOT", False, False)
    assert (spot.spot_angle, spot.spot_blend, spot.radius) == pytest.approx((1.1, 0.3, 0.25))
    assert sun.angle == pytest.approx(0.4) and area.spread == pytest.approx(0.7)
    assert np.allclose(sun.matrix, bpy.data.objects["sun"].matrix_world)


def world():
    """The node tree of a new world, and a function that gives it a Background."""
    bpy.context.scene.world = bpy.data.worlds.new("world")
    tree = Tree(bpy.context.scene.world)
    return tree, lambda **inputs: tree.surface(tree.node("ShaderNodeBackground", **inputs), "ShaderNodeOutputWorld")


def seen_around(tmp_path):
    """Directions (n, 3) and what Cycles shows of the world along them (n, 3)."""
    directions, colors = [], []
    camera = link(bpy.data.cameras.new("camera"))
    camera.data.lens, camera.data.sensor_width = 18, 36
    bpy.context.scene.world.cycles.sampling_method = "NONE"  # spares the map of where light comes from
    bpy.context.scene.camera = camera
    for turn in ((math.pi / 2, 0, 0), (math.pi / 2, 0, 2), (math.pi / 2, 0, -2), (0, 0, 0), (math.pi, 0, 0)):
        camera.rotation_euler = turn
        shown = render(tmp_path, 8, 8)["Combined"]
        across = (np.arange(8) + 0.5) / 4 - 1
        x, y = np.meshgrid(across, across)
        local = np.stack([x, y, np.full_like(x, -1)], -1).reshape(-1, 3)
        local /= np.linalg.norm(local, axis=1, keepdims=True)
        directions.append(local @ np.array(camera.matrix_world)[:3, :3].T)
        colors.append(shown.reshape(-1, 3))
    return np.concatenate(directions), np.concatenate(colors)


def direction_image():
    """An equirectangular image whose colour is (1 + direction)/2."""
    row, column = np.indices((128, 256))
    up, around = np.pi * ((row + 0.5) / 128 - 0.5), -2 * np.pi * ((column + 0.5) / 256 - 0.5)
    direction = np.stack([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)], -1)
    return image(np.concatenate([(1 + direction) / 2, np.ones((128, 256, 1))], -1), "around", float_buffer=True)


@pytest.mark.parametrize(
    "mapping",
    [None, {}, {"vector_type": "TEXTURE"}, {"vector_type": "VECTOR"}, {"vector_type": "NORMAL"}],
    ids=str,
)
def test_world_image(tmp_path, mapping):
    tree, background = world()
    settings = {"image": direction_image()}
    vector = {}
    if mapping is not None:
        coordinates = tree.node("ShaderNodeTexCoord", "Generated")
        vector["Vector"] = tree.node("ShaderNodeMapping", set=mapping, Vector=coordinates, Rotation=(0.3, -0.5, 1.2))
    background(Color=tree.node("ShaderNodeTexEnvironment", set=settings, **vector), Strength=1.5)
    directions, shown = seen_around(tmp_path)
    scene = read()
    assert scene.environment.color == pytest.approx([1.5] * 3) and not scene.approximated
    sought = directions @ scene.environment.rotation.T
    away = np.abs(sought[:, 2]) < 0.999  # Cycles mixes the two poles in the last half texel
    assert np.allclose(1.5 * (1 + sought[away]) / 2, shown[away], atol=5e-3)


def test_plain_worlds(tmp_path):
    _, background = world()
    background(Color=(0.2, 0.4, 0.8), Strength=2.0)
    _, shown = seen_around(tmp_path)
    assert read().environment.color == pytest.approx(shown.mean(0), rel=1e-4)
    assert read().approximated == ()


def test_world_for_the_camera_is_not_that_which_lights(tmp_path, white_square):
    """The usual trick: a Light Path node gives the camera another world than surfaces get their light from."""
    tree, _ = world()
    mix = tree.node("ShaderNodeMixShader")
    tree.tree.links.new(tree.node("ShaderNodeLightPath", "Is Camera Ray"), mix.node.inputs[0])
    for slot, color in ((1, (0.1, 0.2, 0.3)), (2, (5.0, 5.0, 5.0))):
        tree.tree.links.new(tree.node("ShaderNodeBackground", Color=color), mix.node.inputs[slot])
    tree.surface(mix, "ShaderNodeOutputWorld")
    scene = read()
    assert scene.environment.color == pytest.approx(brightness(tmp_path), rel=0.01)
    assert "World 'world'" in scene.approximated[0]


def test_world_that_diffuse_surfaces_do_not_see_is_black(tmp_path, white_square):
    _, background = world()
    background(Color=(0.2, 0.4, 0.8)).cycles_visibility.diffuse = False
    assert not brightness(tmp_path).any()
    assert not read().environment.color.any()


def test_no_world():
    assert not read().environment.color.any()


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
                           Coat_Weight=0.1, Normal=tree.node("ShaderNodeNormalMap"))
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
