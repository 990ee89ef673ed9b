# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Mesh objects of simple shape, linked to the scene. Lengths in metres, angles in degrees, normals outward.

`material` may be None (left empty) throughout.
"""

import math

import bmesh
import bpy

BOX_FACES = ((0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (1, 3, 7, 5), (3, 2, 6, 7), (2, 0, 4, 6))


def mesh_object(name, mesh, material, location=(0, 0, 0), rotation=0.0, scale=1.0):
    """An object of `mesh`, turned by `rotation` about Z."""
    if material and not mesh.materials:
        mesh.materials.append(material)
    obj = bpy.data.objects.new(name, mesh)
    obj.location = location
    obj.rotation_euler.z = math.radians(rotation)
    obj.scale = (scale,) * 3
    bpy.context.scene.collection.objects.link(obj)
    return obj


def polygons(name, vertices, faces):
    """A mesh data-block of flat faces."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    return mesh


def quad(name, corners, material):
    """A face with its origin at its middle; its normal looks at whoever sees the four `corners` anticlockwise."""
    middle = [sum(axis) / 4 for axis in zip(*corners)]
    vertices = [[a - b for a, b in zip(corner, middle)] for corner in corners]
    return mesh_object(name, polygons(name, vertices, [(0, 1, 2, 3)]), material, middle)


def interior(lower, upper, **materials):
    """The inside of the box from corner `lower` to corner `upper`, a quad for each side named in `materials`.

    Sides: floor, ceiling, left (−X), right (+X), front (−Y), back (+Y). Returns {side: object}.
    """
    (x0, y0, z0), (x1, y1, z1) = lower, upper
    corners = {
        "floor": ("Floor", [(x0, y0, z0), (x1, y0, z0), (x1, y1, z0), (x0, y1, z0)]),
        "ceiling": ("Ceiling", [(x0, y0, z1), (x0, y1, z1), (x1, y1, z1), (x1, y0, z1)]),
        "left": ("Left wall", [(x0, y0, z0), (x0, y1, z0), (x0, y1, z1), (x0, y0, z1)]),
        "right": ("Right wall", [(x1, y1, z0), (x1, y0, z0), (x1, y0, z1), (x1, y1, z1)]),
        "front": ("Front wall", [(x1, y0, z0), (x0, y0, z0), (x0, y0, z1), (x1, y0, z1)]),
        "back": ("Back wall", [(x0, y1, z0), (x1, y1, z0), (x1, y1, z1), (x0, y1, z1)]),
    }
    return {side: quad(*corners[side], material) for side, material in materials.items()}


def box(name, size, location, material, rotation=0.0):
    """A closed box that stands on `location`, the middle of its underside."""
    return boxes(name, [(size, (0, 0, 0))], location, material, rotation)


def boxes(name, parts, location, material, rotation=0.0):
    """One mesh of closed boxes, each (size, middle of its underside)."""
    vertices, faces = [], []
    for (x, y, z), (cx, cy, cz) in parts:
        faces += [[len(vertices) + corner for corner in face] for face in BOX_FACES]
        vertices += [(cx + i * x / 2, cy + j * y / 2, cz + k * z) for k in (0, 1) for j in (-1, 1) for i in (-1, 1)]
    return mesh_object(name, polygons(name, vertices, faces), material, location, rotation)


def wall_with_opening(name, size, opening, location, material, rotation=0.0):
    """A wall of `size` (width, thickness, height) that stands on `location`, with a hole through it.

    opening: (left, right, sill, head), left and right from the wall's middle, sill and head from its foot.
    """
    width, thickness, height = size
    left, right, sill, head = opening
    outer = [(-width / 2, 0), (width / 2, 0), (width / 2, height), (-width / 2, height)]
    inner = [(left, sill), (right, sill), (right, head), (left, head)]
    vertices = [(x, y, z) for y in (-thickness / 2, thickness / 2) for x, z in outer + inner]
    faces = []
    for i, j in ((0, 1), (1, 2), (2, 3), (3, 0)):
        faces += [(i, j, j + 4, i + 4), (j + 8, i + 8, i + 12, j + 12)]  # the two sides, around the hole
        faces += [(j, i, i + 8, j + 8), (i + 4, j + 4, j + 12, i + 12)]  # the rim, the reveal
    return mesh_object(name, polygons(name, vertices, faces), material, location, rotation)


def cylinder(name, radius, height, location, material):
    """A closed cylinder that stands on `location`, round at the side and sharp at the rims."""
    x, y, z = location
    return mesh_object(name, cylinder_mesh(name, radius, height, segments=32), material, (x, y, z + height / 2))


def sphere(name, radius, location, material):
    """An icosphere around `location`."""
    return mesh_object(name, icosphere_mesh(name, radius, subdivisions=4), material, location)


def cylinder_mesh(name, radius, height, segments):
    mesh = _from_bmesh(name, bmesh.ops.create_cone, cap_ends=True, segments=segments, radius1=radius, radius2=radius,
                       depth=height)
    mesh.set_sharp_from_angle(angle=math.radians(40))
    return mesh


def icosphere_mesh(name, radius, subdivisions):
    return _from_bmesh(name, bmesh.ops.create_icosphere, radius=radius, subdivisions=subdivisions)


def cube_mesh(name, size, crease):
    """A cube whose edges resist subdivision by `crease`, 0…1."""
    mesh = _from_bmesh(name, bmesh.ops.create_cube, size=size)
    mesh.attributes.new("crease_edge", "FLOAT", "EDGE").data.foreach_set("value", [crease] * len(mesh.edges))
    return mesh


def suzanne_mesh(name):
    """Blender's monkey, 2.7 m from ear to ear, looking along -Y."""
    return _from_bmesh(name, bmesh.ops.create_monkey)


def torus_mesh(name, radius, tube, segments, sides):
    """A torus around Z; `radius` of the ring, `tube` of its section."""
    vertices, faces = [], []
    for i in range(segments):
        for j in range(sides):
            u, v = math.tau * i / segments, math.tau * j / sides
            r = radius + tube * math.cos(v)
            vertices.append((r * math.cos(u), r * math.sin(u), tube * math.sin(v)))
            i1, j1 = (i + 1) % segments, (j + 1) % sides
            faces.append((i * sides + j, i1 * sides + j, i1 * sides + j1, i * sides + j1))
    mesh = polygons(name, vertices, faces)
    mesh.shade_smooth()
    return mesh


def texture_uvs(mesh, name="UVMap", repeat=1):
    """A UV map that lays the picture `repeat` times along each side of every face (a triangle gets half of it)."""
    square = ((0, 0), (repeat, 0), (repeat, repeat), (0, repeat))
    vectors = [coordinate for face in mesh.polygons for corner in square[:face.loop_total] for coordinate in corner]
    mesh.uv_layers.new(name=name).uv.foreach_set("vector", vectors)


def subdivide(obj, levels):
    """A Subdivision Surface modifier, alike in the viewport and the render."""
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels = modifier.render_levels = levels
    return obj


def _from_bmesh(name, operator, **settings):
    mesh = bpy.data.meshes.new(name)
    bm = bmesh.new()
    operator(bm, **settings)
    bm.to_mesh(mesh)
    bm.free()
    mesh.shade_smooth()
    return mesh
