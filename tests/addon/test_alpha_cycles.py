# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Materials that let light through, as read and as baked, against Cycles: a sheet over a floor, seen from above."""

import math

import bpy
import numpy as np
import pytest
from gi_bake.addon.bake import bake
from gi_bake.addon.compare.reference import camera_reference
from gi_bake.addon.job import Job
from gi_bake.addon.read import read_scene
from gi_bake.gi_core import metrics, tiles
from gi_bake.gi_core.rsm.settings import RsmSettings


class Nodes:
    """The node tree of a new material."""

    def __init__(self, name):
        self.material = bpy.data.materials.new(name)
        if bpy.app.version < (5, 0, 0):
            self.material.use_nodes = True
        self.tree = self.material.node_tree
        self.tree.nodes.clear()

    def add(self, kind, *inputs, **attributes):
        """A new node; inputs in order are values or the sockets that they are linked to, None is left alone."""
        node = self.tree.nodes.new("ShaderNode" + kind)
        for name, value in attributes.items():
            setattr(node, name, value)
        for socket, value in zip(node.inputs, inputs):
            if isinstance(value, bpy.types.NodeSocket):
                self.tree.links.new(value, socket)
            elif value is not None:
                socket.default_value = value
        return node

    def image(self):
        """An image node with a cell pattern in all of its channels, each cell its own."""
        image = bpy.data.images.new("cells", 8, 8, alpha=True, is_data=True)
        image.alpha_mode = "CHANNEL_PACKED"
        image.pixels.foreach_set(np.random.default_rng(5).random((8, 8, 4)).astype(np.float32).ravel())
        image.pack()
        return self.add("TexImage", image=image, interpolation="Closest")

    def diffuse(self):
        return self.add("BsdfDiffuse", (0.8, 0.5, 0.2, 1)).outputs[0]

    def done(self, shader):
        self.add("OutputMaterial", shader)
        return self.material


def principled(alpha):
    def make(nodes):
        node = nodes.add("BsdfPrincipled", (0.8, 0.5, 0.2, 1))
        node.inputs["Specular IOR Level"].default_value = 0
        value = alpha(nodes)
        if isinstance(value, bpy.types.NodeSocket):
            nodes.tree.links.new(value, node.inputs["Alpha"])
        else:
            node.inputs["Alpha"].default_value = value
        return node.outputs[0]

    return make


def cut(nodes):
    """The alpha of an image cut at 0.6, with the nodes that glTF's importer makes."""
    less = nodes.add("Math", nodes.image().outputs["Alpha"], 0.6, operation="LESS_THAN")
    return nodes.add("Math", 1.0, less.outputs[0], operation="SUBTRACT").outputs[0]


def mixed(factor, order):
    def make(nodes):
        clear = nodes.add("BsdfTransparent").outputs[0]
        shaders = (clear, nodes.diffuse()) if order else (nodes.diffuse(), clear)
        return nodes.add("MixShader", factor(nodes), *shaders).outputs[0]

    return make


SHEETS = {
    "alpha": principled(lambda nodes: 0.35),
    "image alpha": principled(lambda nodes: nodes.image().outputs["Alpha"]),
    "image colour": principled(lambda nodes: nodes.image().outputs["Color"]),
    "cut image": principled(cut),
    "mix": mixed(lambda nodes: 0.35, True),
    "mix, other way": mixed(lambda nodes: 0.35, False),
    "mix by image": mixed(lambda nodes: nodes.image().outputs["Alpha"], True),
    "mix by image, other way": mixed(lambda nodes: nodes.image().outputs["Alpha"], False),
    "mix of three": lambda nodes: nodes.add(
        "MixShader", 0.5, nodes.add("MixShader", 0.6, nodes.add("BsdfTransparent").outputs[0],
                                    nodes.add("BsdfDiffuse", (0.9, 0.1, 0.1, 1)).outputs[0]).outputs[0],
        nodes.diffuse()).outputs[0],
    "grey glass": lambda nodes: nodes.add("BsdfTransparent", (0.85, 0.85, 0.85, 1)).outputs[0],
}  # fmt: skip


@pytest.fixture
def scene():
    bpy.ops.wm.read_homefile(use_empty=True)
    scene = bpy.context.scene
    floor = Nodes("Floor")
    grey = floor.done(floor.add("BsdfDiffuse", (0.7, 0.7, 0.7, 1)).outputs[0])
    # The wall sends light back that has come through the sheet.
    for name, size, location, tilt in (
        ("Floor", 4, (0, 0, 0), 0), ("Wall", 3, (-1.4, 0, 0), math.pi / 2), ("Sheet", 2.4, (0, 0, 0.7), 0),
    ):  # fmt: skip
        bpy.ops.mesh.primitive_plane_add(size=size, location=location, rotation=(0, tilt, 0))
        bpy.context.object.name = name
        if name != "Sheet":
            bpy.context.object.data.materials.append(grey)
    sun = bpy.data.objects.new("Sun", bpy.data.lights.new("Sun", "SUN"))
    sun.data.energy, sun.rotation_euler = 3, (0.3, 0.7, 0)
    scene.collection.objects.link(sun)
    scene.world = bpy.data.worlds.new("World")
    if bpy.app.version < (5, 0, 0):
        scene.world.use_nodes = True
    scene.world.node_tree.nodes["Background"].inputs["Color"].default_value = (0.3, 0.4, 0.5, 1)
    camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
    camera.data.type, camera.data.ortho_scale, camera.location = "ORTHO", 3.0, (0, 0, 5)
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.resolution_x = scene.render.resolution_y = 24
    return scene


@pytest.mark.parametrize("name", SHEETS)
def test_sheet(scene, name):
    nodes = Nodes("Sheet")
    bpy.data.objects["Sheet"].data.materials.append(nodes.done(SHEETS[name](nodes)))
    settings = RsmSettings(antialias=8, samples=64 * 16, light_samples=64, denoise="none")
    result = tiles.finish(bake(scene, bpy.context.view_layer, Job(settings=settings)))
    assert not [note for note in result.approximated if "Sheet" in note]
    cycles = camera_reference(scene, bpy.context.view_layer, 256, 1, 7)
    for layer, bias, noise in (
        ("Diffuse Color", 0.02, 0.003), ("Diffuse Direct", 0.01, 0.003), ("Diffuse Indirect", 0.02, 0.005),
    ):  # fmt: skip
        ours, theirs = result.layers[layer], cycles[layer]
        assert abs(metrics.bias(ours, theirs)) < bias, layer
        assert metrics.relmse(ours, theirs) < noise, layer


def test_alpha_1_is_opaque(scene):
    """Most materials have an alpha of 1, many from an image without any: they are no different."""
    nodes = Nodes("Sheet")
    image = nodes.image()
    image.image.alpha_mode = "NONE"
    bpy.data.objects["Sheet"].data.materials.append(nodes.done(principled(lambda _: image.outputs["Alpha"])(nodes)))
    [sheet] = [m for m in read_scene(scene, bpy.context.view_layer).materials if m.name == "Sheet"]
    assert sheet.alpha.texture is None and (sheet.alpha.value == 1).all()


def test_what_is_not_exact_is_told(scene):
    nodes = Nodes("Sheet")
    checker = nodes.add("TexChecker")
    clear = nodes.add("BsdfTransparent", (1, 0.5, 0.5, 1))
    shader = nodes.add("MixShader", checker.outputs["Fac" if "Fac" in checker.outputs else "Factor"],
                       clear.outputs[0], nodes.diffuse())  # fmt: skip
    bpy.data.objects["Sheet"].data.materials.append(nodes.done(shader.outputs[0]))
    told = " ".join(read_scene(scene, bpy.context.view_layer).approximated)
    assert "Checker Texture" in told and "all colours through alike" in told
