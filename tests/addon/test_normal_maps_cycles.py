# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Normal and bump maps against Cycles: the normals themselves, what light they catch, and what they send on."""

from dataclasses import replace

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference, lightmap_reference
from gi_bake.addon.job import Job
from gi_bake.gi_core import surfels
from gi_bake.gi_core.direct import from_lamps
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.lpv.settings import LpvSettings
from gi_bake.gi_core.rsm.settings import RsmSettings
from gi_bake.gi_core.ssgi.settings import SsgiSettings
from gi_bake.gi_core.surfels import camera_rays
from gi_bake.gi_core.tiles import finish
from gi_bake.gi_core.trace import Tracer
from gi_bake.tests.shader_trees import image, lamp, link, material, overhead_camera, read_baked, render, square
from mathutils import Euler, Matrix, Vector

SIDE = 64


@pytest.fixture(autouse=True)
def empty_file():
    bpy.ops.wm.read_homefile(use_empty=True)


def waves():
    """A picture of normals that tilt by up to 40°, data."""
    x, y = np.meshgrid(*2 * [np.arange(64) / 64])
    slopes = 0.6 * np.sin(4 * np.pi * x), 0.6 * np.cos(6 * np.pi * y)
    normal = np.dstack([*slopes, np.ones_like(x)])
    normal /= np.linalg.norm(normal, axis=-1, keepdims=True)
    pixels = np.dstack([normal / 2 + 0.5, np.ones_like(x)]).astype(np.float32)
    picture = image(pixels, "waves", float_buffer=True)
    picture.colorspace_settings.name = "Non-Color"  # which takes the pixels away
    picture.pixels.foreach_set(pixels.ravel())
    picture.update()
    return picture


def mapped(tree, picture, space="TANGENT", uv="", **inputs):
    settings = {"space": space, "uv_map": uv}
    return tree.node("ShaderNodeNormalMap", set=settings, Color=tree.node("ShaderNodeTexImage", set={"image": picture}),
                     **inputs)  # fmt: skip


def bumped(tree, scale, distance, **inputs):
    height = tree.node("ShaderNodeTexNoise", Scale=scale, Detail=0.0, Vector=tree.node("ShaderNodeTexCoord", "Object"))
    return tree.node("ShaderNodeBump", Distance=distance, Height=height, **inputs)


def displaced(tree, scale, distance, **settings):
    """Leaves the shader's normal alone: relief by the material's displacement."""
    height = tree.node("ShaderNodeTexNoise", Scale=scale, Detail=0.0, Vector=tree.node("ShaderNodeTexCoord", "Object"))
    relief = tree.node("ShaderNodeDisplacement", set=settings, Height=height, Scale=distance)
    tree.tree.links.new(relief, tree.tree.nodes.new("ShaderNodeOutputMaterial").inputs["Displacement"])


def diffuse(tree, normal):
    inputs = {} if normal is None else {"Normal": normal}
    return tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=(0.8, 0.8, 0.8), **inputs))


def grouped(tree, normal):
    """A normal that comes through a node group."""
    group = bpy.data.node_groups.new("group", "ShaderNodeTree")
    for kind in ("INPUT", "OUTPUT"):
        group.interface.new_socket("Normal", in_out=kind, socket_type="NodeSocketVector")
    inside, outside = group.nodes.new("NodeGroupInput"), group.nodes.new("NodeGroupOutput")
    group.links.new(inside.outputs[0], outside.inputs[0])
    return tree.node("ShaderNodeGroup", set={"node_tree": group}, Normal=normal)


def weakly(tree, normal):
    """Half of a normal, by arithmetic, in the world."""
    own = tree.node("ShaderNodeNewGeometry", "Normal")
    return tree.node("ShaderNodeMix", 1, {"data_type": "VECTOR"}, Factor=0.5, A=own, B=normal)


KINDS = {
    "tangent space": lambda t, p: mapped(t, p),
    "weak": lambda t, p: mapped(t, p, Strength=0.4),
    "another UV map": lambda t, p: mapped(t, p, uv="second"),
    "object space": lambda t, p: mapped(t, p, "OBJECT"),
    "world space": lambda t, p: mapped(t, p, "WORLD"),
    "bump": lambda t, p: bumped(t, 0.4, 2.0),
    "bump on a map": lambda t, p: bumped(t, 0.4, 1.0, Normal=mapped(t, p)),
    "displacement as bump": lambda t, p: displaced(t, 0.4, 2.0),
    "displacement as bump, world": lambda t, p: displaced(t, 0.4, 2.0, space="WORLD"),
    "group": lambda t, p: grouped(t, mapped(t, p)),
    "arithmetic": lambda t, p: weakly(t, mapped(t, p)),
}

# Stretched, mirrored, turned, and all of it.
PLACES = [
    Matrix(),
    Euler((0.3, 0.2, 0.9)).to_matrix().to_4x4(),
    Matrix.Diagonal((1, 0.6, 1.4, 1)),
    Matrix.Diagonal((-1, 1, 1, 1)),
    Matrix.Diagonal((-1, 0.7, 1, 1)) @ Euler((0.3, 0.3, 0.5)).to_matrix().to_4x4(),
]


def test_normals_and_direct_light_wherever_objects_stand(tmp_path):
    """A square of each kind of material at each kind of place, from above under a sun."""
    hold_against_cycles(tmp_path, KINDS, PLACES)


def test_relief_from_behind(tmp_path):
    """Maps show their back there, bumps stand out, on others and on maps too."""
    names = "tangent space", "object space", "bump", "bump on a map", "displacement as bump"
    kinds = {name: KINDS[name] for name in names}
    kinds["two bumps"] = lambda t, p: bumped(t, 0.4, 1.0, Normal=bumped(t, 0.6, 0.5))
    hold_against_cycles(tmp_path, kinds, [Euler((np.pi, 0, 0)).to_matrix().to_4x4() @ place for place in PLACES[1:]])


def hold_against_cycles(tmp_path, kinds, places):
    picture, sharp = waves(), 3
    for row, (name, kind) in enumerate(kinds.items()):
        tree = material(name)
        made = square(diffuse(tree, kind(tree, picture)), size=6.0, name=f"{name} 0")
        for column, place in enumerate(places):
            thing = link(made.data, f"{name} {column}") if column else made
            thing.matrix_world = Matrix.Translation((8 * column + 4, 8 * row + 4, 0)) @ place @ Matrix.Translation(
                (-3, -3, 0))  # fmt: skip
    width, height = 8 * len(places), 8 * len(kinds)
    overhead_camera(width, height)
    lamp("SUN", angle=0.0, energy=3.0).rotation_euler = 0.5, 0.6, 0
    layer = bpy.context.view_layer
    layer.use_pass_normal = layer.use_pass_diffuse_direct = True
    shown = render(tmp_path, sharp * width, sharp * height, samples=1)
    core = read_baked()
    assert not core.approximated
    camera = replace(core.camera, resolution=(sharp * width, sharp * height))
    tracer = Tracer(Geometry(core))
    hits = tracer.closest(*camera_rays(camera))
    hit = np.flatnonzero(hits.triangle >= 0)
    names = np.array([i.name for i in core.instances])[tracer.geometry.instance[hits.triangle[hit]]]
    here = surfels.from_camera(tracer, camera)
    normal, direct = (shown[key].reshape(-1, 3)[hit] for key in ("Normal", "Diffuse Direct"))
    ours = from_lamps(tracer, here, 1, 0) / np.pi
    angle = np.degrees(np.arccos(np.clip(np.sum(normal * here.normal, -1), -1, 1)))
    tilt = np.degrees(np.arccos(np.clip(np.sum(here.face * here.normal, -1), -1, 1)))
    for name in kinds:
        for column in range(len(places)):
            own = names == f"{name} {column}"
            assert own.sum() > 100 and tilt[own].mean() > 8
            # Cycles' bumps are differences over a pixel, which here is a tenth of a wave.
            limits = (1.5, 4.0, 0.03) if "bump" in name else (0.05, 0.2, 0.002)
            error = np.sqrt(np.mean((ours[own] - direct[own]) ** 2)) / direct[own].mean()
            assert angle[own].mean() < limits[0] and np.quantile(angle[own], 0.99) < limits[1], (name, column)
            assert error < limits[2] and abs(ours[own].mean() / direct[own].mean() - 1) < 0.003, (name, column)


@pytest.mark.parametrize("tilt", [20, 50, 95])
def test_relief_shades_as_in_cycles(tmp_path, tilt):
    """A square of one tilted normal, under suns from all sides, from grazing and from below."""
    tree = material()
    normal = np.array([np.sin(np.radians(tilt)), 0, np.cos(np.radians(tilt))])
    color = tuple(normal / 2 + 0.5)
    square(diffuse(tree, tree.node("ShaderNodeNormalMap", set={"space": "OBJECT"}, Color=color)), size=4.0)
    overhead_camera(4, 4)
    sun = lamp("SUN", angle=0.0, energy=1.0)
    bpy.context.view_layer.use_pass_diffuse_direct = True
    found = []
    for degrees in (-75, -30, 30, 60, 80, 88, 93, 110):
        sun.rotation_euler = 0, np.radians(degrees), 0
        expected = render(tmp_path, 4, 4, samples=1)["Diffuse Direct"].mean()
        core = read_baked()
        tracer = Tracer(Geometry(core))
        ours = from_lamps(tracer, surfels.from_camera(tracer, replace(core.camera, resolution=(4, 4))), 1, 0) / np.pi
        found.append((ours.mean(), expected))
    ours, expected = np.array(found).T
    np.testing.assert_allclose(ours, expected, rtol=2e-3, atol=1e-6)
    assert np.count_nonzero(expected) == (0 if tilt > 90 else 5 if tilt > 45 else 6 if tilt > 30 else 5)


def court():
    """A floor of three strips, each with relief of its own, before two coloured walls, under a sun and a lamp."""
    picture = waves()
    bpy.context.scene.world = bpy.data.worlds.new("World")
    bpy.context.scene.world.color = 0, 0, 0
    for k, name in enumerate(("tangent space", "object space", "bump")):
        tree = material(name)
        normal = bumped(tree, 1.2, 0.7) if name == "bump" else KINDS[name](tree, picture)
        strip = square(diffuse(tree, normal), size=3.0, name=name, location=(k, 0, 0))
        strip.scale = 1 / 3, 1, 1
    for name, color, turn, place in (("red", (0.8, 0.2, 0.1), (0, -np.pi / 2, 0), (3, 0, 0)),
                                     ("blue", (0.1, 0.3, 0.8), (np.pi / 2, 0, 0), (0, 3, 0))):  # fmt: skip
        tree = material(name)
        wall = square(tree.surface(tree.node("ShaderNodeBsdfDiffuse", Color=color)), size=3.0, name=name)
        wall.rotation_euler, wall.location = turn, place
    overhead_camera(3, 3)
    bpy.context.scene.render.resolution_x = bpy.context.scene.render.resolution_y = SIDE
    lamp("SUN", angle=0.05, energy=3.0).rotation_euler = 0.5, -0.7, 0
    link(bpy.data.lights.new("bulb", "POINT"), "bulb", location=(1.2, 1.3, 1.6)).data.energy = 60
    bpy.data.lights["bulb"].shadow_soft_size = 0.1


def blocks(values):
    """Means of blocks of 8 × 8 pixels, but for those at the border, whose pixels see the walls' edges."""
    return values.reshape(SIDE // 8, 8, SIDE // 8, 8, -1).mean((1, 3))[:-1, :-1]


def baked(method, settings):
    work = bake(bpy.context.scene, bpy.context.view_layer, Job(method, resolution=SIDE, settings=settings))
    return finish(work)


def test_direct_and_indirect_light_of_relief():
    court()
    scene, layer = bpy.context.scene, bpy.context.view_layer
    truth = camera_reference(scene, layer, 512, 2, 5, (SIDE, SIDE), False)
    smooth = {"denoise": "none", "antialias": 1, "bounces": 2}
    methods = {
        "rsm": RsmSettings(samples=64, light_samples=16, **smooth),
        "ssgi": SsgiSettings(mode="ray_traced", samples=64, frames=1, light_samples=16, **smooth),
        "lpv": LpvSettings(light_samples=16, **smooth),
    }
    # A volume of nine harmonics makes a fifth of it too much here, and an eighth of a floor without relief.
    limits = {"rsm": (0.02, 0.1), "ssgi": (0.025, 0.12), "lpv": (0.25, 0.5)}
    for method, settings in methods.items():
        result = baked(method, settings)
        assert not [note for note in result.approximated if "normal" in note]
        for key, limit in (("Diffuse Direct", (0.005, 0.02)), ("Diffuse Indirect", limits[method])):
            ours, expected = blocks(result.layers[key]), blocks(truth[key])
            error = np.abs(ours - expected) / expected.mean()
            assert error.mean() < limit[0] and error.max() < limit[1], (method, key, error.mean(), error.max())
        cosine = np.sum(result.layers["Normal"] * truth["Normal"], -1)[2:-2, 2:-2]
        assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean() < 1


def test_the_screen_lights_relief():
    """A floor of relief with what the screen alone shows of the walls, by its horizons and by marching."""
    court()
    scene, layer, side = bpy.context.scene, bpy.context.view_layer, 40
    camera = scene.camera
    camera.data.type, camera.data.angle, camera.location = "PERSP", 0.9, (-1.5, -1.5, 4)
    camera.rotation_euler = (Vector((1.7, 1.7, 0.5)) - camera.location).to_track_quat("-Z", "Y").to_euler()
    truth = camera_reference(scene, layer, 256, 1, 5, (side, side), False)
    floor = (np.abs(truth["Position"][..., 2]) < 0.01) & truth["Diffuse Color"].any(-1)
    assert floor.sum() > 300
    for tracer in ("march", "bitmask"):
        settings = SsgiSettings(mode="screen_space", tracer=tracer, fallback="none", samples=64, frames=1, bounces=1,
                                light_samples=16, denoise="none", antialias=1)  # fmt: skip
        work = bake(scene, layer, Job("ssgi", resolution=side, settings=settings))
        ours = finish(work).layers["Diffuse Indirect"]
        assert abs(ours[floor].mean() / truth["Diffuse Indirect"][floor].mean() - 1) < 0.06, tracer


def test_lightmaps_take_relief_and_vertices_do_not():
    """A lightmap is as Cycles bakes it, with four normals too; a vertex is no place of a normal map's."""
    court()
    scene, layer = bpy.context.scene, bpy.context.view_layer
    name, side = "tangent space", 64
    layer.update()
    truth = lightmap_reference(scene, layer, {name: "first"}, side, 64, 1, 3, ("DIRECT",))[name][..., :3]
    smooth = {"denoise": "none", "bounces": 1, "samples": 4, "light_samples": 16, "light": "direct"}
    for directional in (False, True):
        settings = RsmSettings(**smooth, directional=directional)
        job = Job("rsm", "lightmap", (name,), side, "first", settings)
        light = next(iter(finish(bake(scene, layer, job)).light.values()))
        inside = (slice(2, -2), slice(2, -2))
        error = light.direct[inside] - truth[inside]
        assert np.abs(error).mean() < 0.02 * truth[inside].mean()  # noise of soft lamps
        assert abs(error.mean()) < 0.005 * truth[inside].mean()
    assert np.std(truth) > 0.2 * np.mean(truth)
    job = Job("rsm", "vertices", (name,), settings=RsmSettings(**smooth))
    at = finish(bake(scene, layer, job)).light[name]
    for tree in [block.node_tree for block in bpy.data.materials]:
        for wire in [wire for wire in tree.links if wire.to_socket.name == "Normal"]:
            tree.links.remove(wire)
    flat = finish(bake(scene, layer, job)).light[name]
    np.testing.assert_allclose(at.direct, flat.direct, rtol=1e-5)
