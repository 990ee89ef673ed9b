# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Tiny scenes for shaders: squares, lamps and trees of nodes in a line or two, and what Cycles makes of them."""

from dataclasses import replace

import bpy
import numpy as np
import OpenEXR
from gi_bake.addon.read import read_scene, with_bakes
from gi_bake.addon.read.surface_bakes import SurfaceBakes
from gi_bake.gi_core.geometry import Geometry
from gi_bake.gi_core.surfels import camera_rays
from gi_bake.gi_core.tiles import finish
from gi_bake.gi_core.trace import Tracer


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
    """Cycles' passes as arrays with row 0 at the bottom: keys "Combined", "Diffuse Color", "Emission", and "Normal",
    "Diffuse Direct" and "Diffuse Indirect" where the view layer has them."""
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
    names = {"DiffCol": "Diffuse Color", "DiffDir": "Diffuse Direct", "DiffInd": "Diffuse Indirect", "Emit": "Emission"}
    with OpenEXR.File(scene.render.filepath) as file:
        channels = {name: channel.pixels for part in file.parts for name, channel in part.channels.items()}
    passes = {}
    for name, pixels in channels.items():
        key = name.split(".")[1]
        if pixels.ndim == 3:
            passes[names.get(key, key)] = pixels[::-1, :, :3]
        elif name.endswith(".X"):
            passes[key] = np.stack([channels[name[:-1] + axis] for axis in "XYZ"], -1)[::-1]
    return passes


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
        output = next((n for n in self.tree.nodes if n.bl_idname == kind), None) or self.tree.nodes.new(kind)
        self.tree.links.new(shader, output.inputs["Surface"])
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


def lamp(kind, name="lamp", scale=(1, 1, 1), **attributes):
    light = bpy.data.lights.new(name, kind)
    light.energy = 10
    for attribute, value in attributes.items():
        setattr(light, attribute, value)
    return link(light, name, location=(0.05, 0.05, 3), scale=scale)


def brightness(tmp_path):
    """Of a small white square at the origin, at right angles to where lamps are: (3,)."""
    return render(tmp_path, 8, 8, samples=32)["Combined"].mean((0, 1))


def read_baked(bakes=None):
    """What is in the file, with what only Cycles can tell; nothing is kept on disk."""
    bakes = bakes or SurfaceBakes(None)
    scene, view_layer = bpy.context.scene, bpy.context.view_layer
    return finish(with_bakes(read_scene(scene, view_layer, bakes=bakes), scene, view_layer, bakes))


def color_errors(core, shown, source, factor=1.0):
    """Object's name -> how far a property of surfaces is from an image (h, w, 3), in each of its pixels [1/255]."""
    geometry = Geometry(core)
    camera = replace(core.camera, resolution=shown.shape[1::-1])
    hits = Tracer(geometry).closest(*camera_rays(camera))
    hit = np.flatnonzero(hits.triangle >= 0)
    ours = geometry.color(source, hits.triangle[hit], hits.weights[hit]) * factor
    error = np.abs(ours - shown.reshape(-1, 3)[hit]).max(-1) * 255
    names = np.array([instance.name for instance in core.instances])[geometry.instance[hits.triangle[hit]]]
    return {name: error[names == name] for name in np.unique(names).tolist()}
