# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A courtyard in the sun where every object's colour comes another way, and some objects come another way."""

import math

import bpy
import images
import numpy as np
from lightmap_uvs import unwrap_all
from shading import DIFFUSE, PRINCIPLED, diffuse, node, surface
from shapes import (
    box,
    cylinder,
    icosphere_mesh,
    interior,
    mesh_object,
    quad,
    sphere,
    subdivide,
    suzanne_mesh,
    texture_uvs,
    torus_mesh,
)
from stage import camera, empty_scene, lamp

TEXTURE, COORDINATES = "ShaderNodeTexImage", "ShaderNodeTexCoord"


def build():
    scene = empty_scene((256, 192), world=(0.09, 0.12, 0.18))
    tiles, letter, spots, dents = images.tiles(), images.letter(), images.spots(), images.dents()
    walls(tiles)
    textured(letter)
    mapped(tiles, spots, dents)
    colored()
    files()
    stools = instanced()
    lamp("SUN", "Sun", (-2, -3, 4), (0, 0, 0), 3, color=(1, 0.95, 0.88), angle=math.radians(0.5))
    camera((0.25, -4.6, 2.3), (0, 0.35, 0.7), 50)
    unwrap_all(scene)
    # Only its instances show, not the original, which has to be in the view layer to be unwrapped.
    bpy.context.view_layer.layer_collection.children[stools.name].exclude = True


def walls(tiles):
    """A floor whose picture repeats (UVs beyond 1), and two walls of procedural textures."""
    sides = interior((-2.5, -2, 0), (2.5, 2, 2.5), floor=image_material("Tiled", tiles), back=plaster(),
                     left=chequered())
    texture_uvs(sides["floor"].data, repeat=5)


def textured(letter):
    """One picture on the default UV map, on another UV map, and on a mirrored object."""
    crate = box("Crate", (0.7, 0.7, 0.7), (-1.5, 0.9, -0.001), image_material("Letter", letter), rotation=20)
    texture_uvs(crate.data)

    # By the map that renders by default each side would show one F; by "Detail" it shows nine.
    crate = box("Small crate", (0.5, 0.5, 0.5), (-1.3, -0.45, -0.001), image_material("Nine letters", letter, "Detail"),
                rotation=-25)
    texture_uvs(crate.data)
    texture_uvs(crate.data, "Detail", repeat=3)

    monkey = mesh_object("Mirrored Suzanne", suzanne_mesh("Suzanne"), bpy.data.materials["Letter"], (-0.3, 0.7, 0.45),
                         rotation=25, scale=0.45)
    monkey.scale.x *= -1
    texture_uvs(monkey.data)
    subdivide(monkey, 1)


def mapped(tiles, spots, dents):
    """Images that are data, and shaders that are more than diffuse."""
    block = box("Dented block", (0.6, 0.6, 0.9), (0.75, 1.2, -0.001), dented(tiles, spots, dents), rotation=-15)
    texture_uvs(block.data, repeat=2)
    sphere("Spotted ball", 0.28, (1.45, -0.4, 0.279), spotted(spots))
    brass = {"Base Color": (0.8, 0.6, 0.25), "Metallic": 1, "Roughness": 0.3}
    mesh_object("Metal ring", torus_mesh("Metal ring", 0.3, 0.1, segments=48, sides=24),
                surface("Brass", lambda tree: node(tree, PRINCIPLED, brass)), (-0.45, -1.0, 0.099))


def colored():
    """Colours from the mesh and from a node group."""
    ball = mesh_object("Painted ball", icosphere_mesh("Painted ball", 0.35, subdivisions=4), painted(),
                       (1.5, 0.5, 0.349))
    normals = np.empty(3 * len(ball.data.vertices), np.float32)
    ball.data.vertices.foreach_get("normal", normals)
    rgba = np.insert(0.45 + 0.35 * normals.reshape(-1, 3), 3, 1, axis=1)
    ball.data.attributes.new("Paint", "FLOAT_COLOR", "POINT").data.foreach_set("color", rgba.ravel())

    group = faded_group()
    for name, saturation, radius, height, place in (("Vivid", 1, 0.25, 0.6, (0.3, -0.2)),
                                                    ("Faded", 0.4, 0.25, 0.35, (0.85, -0.75))):
        inputs = {"Color": (0.7, 0.2, 0.1), "Saturation": saturation}
        material = surface(name, lambda tree, i=inputs: node(tree, "ShaderNodeGroup", i, node_tree=group))
        cylinder(f"{name} drum", radius, height, (*place, -0.001), material)
    sphere("Clouded ball", 0.26, (-2.05, 0.2, 0.259), clouded())


def files():
    """An image in two UDIM tiles, packed, and one of a sequence of files beside the .blend."""
    rings = image_material("Two tiles", images.two_tiles())
    chest = box("Two-tile chest", (0.35, 0.3, 0.45), (2.15, -0.2, -0.001), rings, rotation=10)
    texture_uvs(chest.data)
    for k, face in enumerate(chest.data.polygons):
        for corner in face.loop_indices if k % 2 else ():
            chest.data.uv_layers["UVMap"].uv[corner].vector.x += 1

    scene = bpy.context.scene
    scene.frame_start, scene.frame_end, scene.frame_current = 1, 3, 2
    sign = quad("Sign", [(-0.6, 1.99, 1.5), (0, 1.99, 1.5), (0, 1.99, 1.9), (-0.6, 1.99, 1.9)], sequence())
    texture_uvs(sign.data)


def instanced():
    """A collection of two objects, kept out of the view and shown by three empties, one of them mirrored."""
    stools = bpy.data.collections.new("Stool")
    scene = bpy.context.scene
    scene.collection.children.link(stools)
    parts = [cylinder("Stool seat", 0.2, 0.06, (0, 0, 0.4), diffuse("Stool red", (0.6, 0.15, 0.1))),
             box("Stool foot", (0.12, 0.2, 0.402), (0, 0, -0.001), diffuse("Stool grey", (0.5, 0.5, 0.5)))]
    for part in parts:
        stools.objects.link(part)
        scene.collection.objects.unlink(part)
    for i, (location, turn, scale) in enumerate((((-0.85, 1.6, 0), 0, (1, 1, 1)), ((2.1, 1.4, 0), 30, (1.2, 1.2, 1.6)),
                                                 ((1.3, -1.2, 0), -40, (-1, 1, 0.8)))):
        empty = bpy.data.objects.new(f"Stool {i + 1}", None)
        empty.instance_type, empty.instance_collection = "COLLECTION", stools
        empty.location, empty.rotation_euler.z, empty.scale = location, math.radians(turn), scale
        scene.collection.objects.link(empty)
    return stools


def image_material(name, image, uv_map=None):
    def shader(tree):
        vector = {"Vector": node(tree, "ShaderNodeUVMap", uv_map=uv_map)} if uv_map else {}
        return node(tree, DIFFUSE, {"Color": node(tree, TEXTURE, vector, image=image)})
    return surface(name, shader)


def plaster():
    """Noise through a colour ramp."""
    def shader(tree):
        ramp = node(tree, "ShaderNodeValToRGB", {0: node(tree, "ShaderNodeTexNoise", {"Scale": 6})})
        for element, color in zip(ramp.color_ramp.elements, ((0.25, 0.4, 0.5, 1), (0.8, 0.75, 0.6, 1))):
            element.color = color
        return node(tree, DIFFUSE, {"Color": ramp})
    return surface("Plaster", shader)


def chequered():
    """A checker in object space; at this scale no edge of a cell falls on the wall's plane."""
    def shader(tree):
        place = node(tree, "ShaderNodeMapping", {"Vector": node(tree, COORDINATES).outputs["Object"],
                                                 "Location": (0.1, 0, 0)})
        return node(tree, DIFFUSE, {"Color": node(tree, "ShaderNodeTexChecker", {
            "Vector": place, "Color1": (0.65, 0.25, 0.2), "Color2": (0.75, 0.7, 0.6), "Scale": 2})})
    return surface("Chequered", shader)


def dented(tiles, spots, dents):
    """Principled: base colour from an sRGB picture, roughness from a mask, normals from a normal map."""
    def shader(tree):
        color, mask, normal = (node(tree, TEXTURE, image=image) for image in (tiles, spots, dents))
        return node(tree, PRINCIPLED, {"Base Color": color, "Roughness": mask,
                                       "Normal": node(tree, "ShaderNodeNormalMap", {"Color": normal})})
    return surface("Dented", shader)


def spotted(spots):
    """Diffuse and glossy, mixed by a mask that generated coordinates lay on."""
    def shader(tree):
        mask = node(tree, TEXTURE, {"Vector": node(tree, COORDINATES).outputs["Generated"]}, image=spots)
        return node(tree, "ShaderNodeMixShader", {
            0: mask, 1: node(tree, DIFFUSE, {"Color": (0.2, 0.5, 0.3)}),
            2: node(tree, "ShaderNodeBsdfGlossy", {"Color": (0.8, 0.8, 0.85)})})
    return surface("Spotted", shader)


def clouded():
    """Two diffuse shaders, mixed by noise."""
    def shader(tree):
        return node(tree, "ShaderNodeMixShader", {
            0: node(tree, "ShaderNodeTexNoise", {"Scale": 3}), 1: node(tree, DIFFUSE, {"Color": (0.75, 0.7, 0.65)}),
            2: node(tree, DIFFUSE, {"Color": (0.1, 0.15, 0.4)})})
    return surface("Clouded", shader)


def sequence():
    """The image of the current frame."""
    def shader(tree):
        picture = node(tree, TEXTURE, image=images.frames())
        user = picture.image_user
        user.frame_duration, user.frame_start, user.use_auto_refresh = 3, 1, True
        return node(tree, DIFFUSE, {"Color": picture})
    return surface("Sequence", shader)


def painted():
    return surface("Painted", lambda tree: node(tree, DIFFUSE, {
        "Color": node(tree, "ShaderNodeVertexColor", layer_name="Paint")}))


def faded_group():
    """A node group: a Diffuse BSDF of a colour less saturated."""
    group = bpy.data.node_groups.new("Faded paint", "ShaderNodeTree")
    for name, direction, kind in (("Color", "INPUT", "Color"), ("Saturation", "INPUT", "Float"),
                                  ("Shader", "OUTPUT", "Shader")):
        group.interface.new_socket(name, in_out=direction, socket_type=f"NodeSocket{kind}")
    given = node(group, "NodeGroupInput").outputs
    color = node(group, "ShaderNodeHueSaturation", {"Color": given["Color"], "Saturation": given["Saturation"]})
    node(group, "NodeGroupOutput", {"Shader": node(group, DIFFUSE, {"Color": color})})
    return group
