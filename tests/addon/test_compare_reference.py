# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""References by Cycles: right where a closed form says what is right, whatever the user's settings are, and the file as
it was."""

import math

import bpy
import numpy as np
import pytest
from gi_bake.addon.compare.reference import camera_reference, lightmap_reference, vertex_reference

POWER, ALBEDO = 30.0, 0.6


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def add(name, data=None, location=(0, 0, 0), rotation=(0, 0, 0)):
    obj = bpy.data.objects.new(name, data)
    obj.location, obj.rotation_euler = location, rotation
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_camera(**where):
    bpy.context.scene.camera = add("Camera", bpy.data.cameras.new("Camera"), **where)
    bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = 16
    return bpy.context.scene.camera


def add_light(kind="POINT", energy=POWER, **where):
    light = bpy.data.lights.new("Lamp", kind)
    light.energy = energy
    if kind == "POINT":
        light.shadow_soft_size = 0
    return add("Lamp", light, **where)


def diffuse(name, color):
    material = bpy.data.materials.new(name)
    if not material.node_tree:
        material.use_nodes = True
    shader = material.node_tree.nodes["Principled BSDF"]
    shader.inputs["Base Color"].default_value = (*color, 1)
    shader.inputs["Specular IOR Level"].default_value = 0
    return material


def add_plane(name, material=None, **where):
    bpy.ops.mesh.primitive_plane_add(size=2, **where)
    obj = bpy.context.object
    obj.name = name
    if material:
        obj.data.materials.append(material)
    return obj


@pytest.fixture
def sphere():
    """An integrating sphere of radius 1, seen from inside, with a point light and the camera in its centre."""
    bpy.ops.mesh.primitive_ico_sphere_add(subdivisions=5, radius=1)
    obj = bpy.context.object
    obj.name = "Sphere"
    obj.data.flip_normals()
    obj.data.materials.append(diffuse("Inside", (ALBEDO,) * 3))
    add_light()
    add_camera()
    return obj


def in_sphere(bounces, albedo=ALBEDO):
    """Light without colour in an integrating sphere: direct E/π is P/(4π²r²), and each bounce brings an albedo more."""
    direct = POWER / (4 * math.pi**2)
    return direct, direct * sum(albedo**k for k in range(1, bounces + 1))


@pytest.fixture
def corner():
    """A floor and a red wall, a lamp, and an orthographic camera that sees the floor as its UV map lies."""
    white = diffuse("White", (0.8, 0.8, 0.8))
    floor = add_plane("Floor", white)
    add_plane("Wall", diffuse("Red", (0.8, 0.1, 0.1)), location=(1, 0, 1), rotation=(0, -math.pi / 2, 0))
    add_light(location=(-0.2, 0.1, 0.9))
    camera = add_camera(location=(0, 0, 3))
    camera.data.type, camera.data.ortho_scale = "ORTHO", 2
    return floor


def layer():
    return bpy.context.scene.view_layers[0]


def settings_of(struct, depth=2):
    """All plain settings of an RNA struct and of the structs inside it."""
    found = {}
    for prop in struct.bl_rna.properties:
        if prop.identifier in {"rna_type", "depsgraph", "display", "use_nodes"}:  # the last two only warn
            continue
        value = getattr(struct, prop.identifier)
        if prop.type == "POINTER":
            if isinstance(value, bpy.types.ID):
                found[prop.identifier] = value.name
            elif value is not None and depth:
                found[prop.identifier] = settings_of(value, depth - 1)
        elif prop.type != "COLLECTION":
            found[prop.identifier] = tuple(value) if getattr(prop, "is_array", False) else value
    return found


def the_file():
    """What a reference could leave behind or change: data-blocks, settings, selection, slots, nodes, attributes."""
    scene = bpy.context.scene
    return {
        "data": sorted((type(i).__name__, i.name, i.users) for i in bpy.data.user_map()),
        "scene": settings_of(scene),
        "layers": [settings_of(x) for x in scene.view_layers],
        "selection": ([o.name for o in bpy.context.selected_objects], bpy.context.object),
        "objects": [
            (o.name, [(s.link, s.material) for s in o.material_slots], o.hide_render, o.hide_viewport)
            for o in bpy.data.objects
        ],
        "nodes": [
            [(n.name, n.select, n == m.node_tree.nodes.active) for n in m.node_tree.nodes]
            for m in bpy.data.materials
            if m.node_tree
        ],
        "meshes": [
            (
                [(a.name, a.domain, a.data_type) for a in m.attributes],
                (m.attributes.active_color_name, m.attributes.default_color_name, m.attributes.active_index),
                [d.value for a in m.attributes if a.name == "material_index" for d in a.data],
                list(m.materials),
            )
            for m in bpy.data.meshes
        ],
    }


@pytest.mark.parametrize("bounces", [0, 1, 3])
def test_camera_reference_in_an_integrating_sphere(sphere, bounces):
    passes = camera_reference(bpy.context.scene, layer(), samples=64, bounces=bounces, seed=0)
    direct, indirect = in_sphere(bounces)
    assert passes["Diffuse Direct"].mean() == pytest.approx(direct, rel=0.01)
    assert passes["Diffuse Indirect"].mean() == pytest.approx(indirect, rel=0.01)
    assert passes["Diffuse Color"] == pytest.approx(ALBEDO, rel=1e-3)
    assert np.linalg.norm(passes["Position"], axis=-1) == pytest.approx(1, abs=0.01)
    assert passes["Diffuse Indirect"].shape == (16, 16, 3)


def test_lightmap_and_vertex_reference_in_an_integrating_sphere(sphere):
    direct, indirect = in_sphere(2)
    arguments = {"samples": 16, "bounces": 2, "seed": 0}
    vertices = vertex_reference(bpy.context.scene, layer(), ["Sphere"], **arguments)["Sphere"]
    assert vertices.shape == (len(sphere.data.loops), 3)
    assert vertices.mean() == pytest.approx(indirect, rel=0.01)
    lightmap = lightmap_reference(
        bpy.context.scene, layer(), {"Sphere": "UVMap"}, 64, passes=("DIRECT", "INDIRECT"), **arguments
    )["Sphere"]
    valid = lightmap[..., 3] == 1
    assert set(np.unique(lightmap[..., 3])) == {0, 1}
    assert lightmap[valid][:, :3].mean() == pytest.approx(direct + indirect, rel=0.01)


def test_glossy_lobes_do_not_darken_diffuse_light(sphere):
    """A layer of clear varnish takes light away, it does not change how a receiver sees what arrives."""
    bpy.ops.mesh.primitive_plane_add(size=0.2, location=(0, 0, -0.5))
    varnished = bpy.context.object
    material = diffuse("Varnish", (0.5, 0.5, 0.5))
    varnished.data.materials.append(material)
    camera = bpy.context.scene.camera
    camera.data.angle = 0.2
    seen = []
    for specular in (0.0, 0.5):
        material.node_tree.nodes["Principled BSDF"].inputs["Specular IOR Level"].default_value = specular
        passes = camera_reference(bpy.context.scene, layer(), samples=128, bounces=1, seed=0)
        seen.append(passes["Diffuse Indirect"].mean())
    assert seen[1] == pytest.approx(seen[0], rel=0.02)


def test_lightmap_lies_as_the_camera_sees_the_floor(corner):
    arguments = {"samples": 256, "bounces": 1, "seed": 0}
    seen = camera_reference(bpy.context.scene, layer(), **arguments)["Diffuse Indirect"]
    baked = lightmap_reference(bpy.context.scene, layer(), {"Floor": "UVMap"}, 16, **arguments)["Floor"]
    assert (baked[..., 3] == 1).all()
    assert baked[..., :3].mean() == pytest.approx(seen.mean(), rel=0.01)
    # Noise of 256 samples; a map that lay in any other way would be far off, the wall being on one side.
    assert np.abs(baked[..., :3] - seen).mean() < 0.05 * seen.mean()
    assert np.abs(baked[:, ::-1, :3] - seen).mean() > 0.3 * seen.mean()


def test_users_settings_do_not_matter(corner):
    scene = bpy.context.scene
    arguments = {"samples": 4, "bounces": 1, "seed": 5}

    def results():
        passes = camera_reference(scene, layer(), resolution=(12, 8), **arguments)
        lightmap = lightmap_reference(scene, layer(), {"Floor": "UVMap"}, 8, **arguments)
        vertices = vertex_reference(scene, layer(), ["Floor"], **arguments)
        return [passes["Diffuse Indirect"], passes["Diffuse Direct"], lightmap["Floor"], vertices["Floor"]]

    expected = results()
    cycles, render = scene.cycles, scene.render
    render.engine = "CYCLES"
    cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_fast_gi = True
    cycles.adaptive_threshold = 0.9
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = 0.001
    cycles.light_sampling_threshold = 1.0
    cycles.film_exposure = 3.0
    cycles.diffuse_bounces = cycles.glossy_bounces = 7
    cycles.sample_offset, cycles.seed, cycles.use_animated_seed = 11, 3, True
    cycles.caustics_reflective = False
    layer().samples = 1
    cycles.use_layer_samples = "USE"
    render.use_border = render.use_crop_to_border = True
    render.border_max_x = 0.5
    render.resolution_percentage = 37
    render.use_motion_blur = render.use_multiview = True
    render.image_settings.file_format = "JPEG"
    render.bake.margin, render.bake.use_selected_to_active = 20, True
    scene.camera.data.dof.use_dof, scene.camera.data.dof.aperture_fstop = True, 0.01
    scene.timeline_markers.new("Cut", frame=scene.frame_current).camera = scene.camera
    cycles.driver_add("samples").driver.expression = "1"
    scene.view_layers.new("Other").use = True
    bpy.context.view_layer.update()
    before = the_file()
    for result, value in zip(results(), expected, strict=True):
        assert np.array_equal(result, value)
    assert the_file() == before


def test_what_the_view_layer_leaves_out_stays_out(corner):
    """A lid over the floor in an excluded collection, another hidden in renders."""
    scene = bpy.context.scene
    arguments = {"samples": 4, "bounces": 1, "seed": 0}
    expected = lightmap_reference(scene, layer(), {"Floor": "UVMap"}, 8, **arguments)["Floor"]
    hidden = bpy.data.collections.new("Hidden")
    scene.collection.children.link(hidden)
    for name in ("Lid", "Other lid"):
        lid = add_plane(name, location=(0, 0, 0.3))
        scene.collection.objects.unlink(lid)
        hidden.objects.link(lid)
    layer().layer_collection.children["Hidden"].exclude = True
    scene.collection.objects.link(bpy.data.objects["Other lid"])
    bpy.data.objects["Other lid"].hide_render = True
    result = lightmap_reference(scene, layer(), {"Floor": "UVMap"}, 8, **arguments)["Floor"]
    assert np.array_equal(result, expected)


def test_same_seed_same_bytes_another_seed_other_noise(corner):
    bake = [
        lightmap_reference(bpy.context.scene, layer(), {"Floor": "UVMap"}, 8, samples=2, bounces=1, seed=seed)["Floor"]
        for seed in (1, 1, 2)
    ]
    assert np.array_equal(bake[0], bake[1])
    assert not np.array_equal(bake[0], bake[2])


def test_goes_of_a_few_samples_together_are_one_of_all(corner):
    corner.data.materials[0] = image = diffuse("Checker", (0.8, 0.8, 0.8))
    checker = image.node_tree.nodes.new("ShaderNodeTexChecker")
    image.node_tree.links.new(checker.outputs["Color"], image.node_tree.nodes["Principled BSDF"].inputs["Base Color"])
    arguments = {"samples": 10, "bounces": 1, "seed": 3}
    references = [
        lambda go: camera_reference(bpy.context.scene, layer(), **arguments, go=go),
        lambda go: lightmap_reference(bpy.context.scene, layer(), {"Wall": "UVMap"}, 16, **arguments, go=go),
        lambda go: vertex_reference(bpy.context.scene, layer(), ["Wall"], **arguments, go=go),
    ]
    whole = [made(0) for made in references]
    # 4, 4 and 2 samples.
    for one, goes in zip(whole, (made(4 * 16 * 16) for made in references)):
        assert one.keys() == goes.keys()
        for name in one:
            assert goes[name] == pytest.approx(one[name], abs=2e-5), name
    assert whole[0]["Diffuse Indirect"].any() and np.ptp(whole[0]["Diffuse Color"]) > 0.5


@pytest.mark.parametrize("material", ["no slot", "empty slot", "without nodes", "of the object", "two slots"])
def test_every_kind_of_material_is_baked_and_put_back(sphere, material):
    """In a sphere the light tells the albedo: Blender's grey, 0.8, where there is no material."""
    mesh = sphere.data
    albedo = 0.8
    if material == "no slot":
        mesh.materials.clear()
        slots = mesh.attributes.get("material_index") or mesh.attributes.new("material_index", "INT", "FACE")
        slots.data[5].value = 3
    elif material == "empty slot":
        mesh.materials[0] = None
    elif material == "without nodes":
        mesh.materials[0] = bpy.data.materials.new("Plain")
        if bpy.app.version >= (5, 0):
            pytest.skip("Blender 5 has no materials without nodes")
        mesh.materials[0].diffuse_color = (0.3, 0.3, 0.3, 1)
        albedo = 0.3
    elif material == "of the object":
        sphere.material_slots[0].link = "OBJECT"
        sphere.material_slots[0].material = diffuse("Own", (0.4,) * 3)
        albedo = 0.4
    else:
        mesh.materials.append(mesh.materials[0])
        mesh.polygons[7].material_index = 1
        albedo = ALBEDO
    before = the_file()
    arguments = {"samples": 16, "bounces": 1, "seed": 0}
    lightmap = lightmap_reference(bpy.context.scene, layer(), {"Sphere": "UVMap"}, 64, **arguments)["Sphere"]
    assert lightmap[lightmap[..., 3] == 1][:, :3].mean() == pytest.approx(in_sphere(1, albedo)[1], rel=0.01)
    assert the_file() == before


def test_objects_that_share_material_and_mesh_get_maps_of_their_own(corner):
    """On the UV map that was named for each, also where they are hidden in the viewport."""
    twin = bpy.data.objects.new("Twin", corner.data)
    twin.location = (0, 0, -1)
    twin.hide_viewport = True
    bpy.context.scene.collection.objects.link(twin)
    half = corner.data.uv_layers.new(name="Half")
    coordinates = np.empty(8, np.float32)
    half.uv.foreach_get("vector", coordinates)
    half.uv.foreach_set("vector", coordinates * np.float32([0.5, 1] * 4))
    before = the_file()
    baked = lightmap_reference(
        bpy.context.scene,
        layer(),
        {"Floor": "UVMap", "Twin": "Half"},
        16,
        samples=4,
        bounces=1,
        seed=0,
        passes=("DIRECT",),
    )
    assert (baked["Floor"][..., 3] == 1).all()
    assert baked["Floor"][..., :3].min() > 0
    assert (baked["Twin"][..., 3] == (np.arange(16) < 8)).all()
    assert baked["Twin"][..., :3].max() == 0  # below the floor
    assert the_file() == before


def test_vertices_of_the_mesh_before_modifiers(corner):
    corner.modifiers.new("Subdivide", "SUBSURF").subdivision_type = "SIMPLE"
    baked = vertex_reference(bpy.context.scene, layer(), ["Floor"], samples=64, bounces=1, seed=0)["Floor"]
    assert baked.shape == (4, 3)
    near_wall = np.array([corner.data.vertices[loop.vertex_index].co.x > 0 for loop in corner.data.loops])
    assert baked[near_wall, 0].min() > 1.2 * baked[~near_wall, 0].max()


def test_a_failure_leaves_the_file_as_it_was(corner, monkeypatch):
    wall = bpy.data.objects["Wall"]
    wall.data.uv_layers.remove(wall.data.uv_layers[0])
    wall.hide_render = True
    corner.data.color_attributes.new("Mine", "BYTE_COLOR", "CORNER")
    scene = bpy.context.scene
    before = the_file()
    arguments = {"samples": 1, "bounces": 1, "seed": 0}
    with pytest.raises(ValueError, match="'Wall' has no UV map 'UVMap'"):
        lightmap_reference(scene, layer(), {"Floor": "UVMap", "Wall": "UVMap"}, 8, **arguments)
    with pytest.raises(ValueError, match="'Lamp' is no mesh"):
        vertex_reference(scene, layer(), ["Lamp"], **arguments)
    with pytest.raises(RuntimeError, match="not enabled for rendering"):
        vertex_reference(scene, layer(), ["Floor", "Wall"], **arguments)
    monkeypatch.setattr("gi_bake.gi_core.exr.read_layers", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        camera_reference(scene, layer(), **arguments)
    assert the_file() == before
    scene.camera = None
    with pytest.raises(ValueError, match="'Scene' has no camera"):
        camera_reference(scene, layer(), **arguments)


def test_a_rigid_body_simulation_is_refused_once_it_has_moved_things(corner):
    bpy.context.view_layer.objects.active = corner
    bpy.ops.rigidbody.object_add()
    scene = bpy.context.scene
    arguments = {"samples": 1, "bounces": 1, "seed": 0}
    vertex_reference(scene, layer(), ["Floor"], **arguments)
    scene.frame_set(2)
    with pytest.raises(ValueError, match=r"'Scene'.*Bake to Keyframes"):
        vertex_reference(scene, layer(), ["Floor"], **arguments)
