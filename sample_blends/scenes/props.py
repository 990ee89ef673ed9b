# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sixty subdivided props on the floor and two shelves of the Cornell box, as artists have them.

On purpose no mesh has UVs: a lightmap bake has to make its own.
"""

import colorsys
import math

from scenes.cornell import room
from shading import GREEN, PRINCIPLED, RED, WHITE, diffuse, node, surface
from shapes import (
    box,
    cube_mesh,
    cylinder_mesh,
    icosphere_mesh,
    mesh_object,
    subdivide,
    suzanne_mesh,
    torus_mesh,
)
from stage import empty_scene, lamp

# What a prop is: its mesh, about 2 m across, whether all of the kind share it, and its subdivision levels.
KINDS = {
    "Suzanne": (suzanne_mesh, False, 2),
    "Torus": (lambda name: torus_mesh(name, 0.7, 0.3, segments=24, sides=12), True, 2),
    "Ball": (lambda name: icosphere_mesh(name, 1, subdivisions=2), True, 2),
    "Cylinder": (lambda name: cylinder_mesh(name, 0.8, 1.7, segments=16), False, 2),
    "Cube": (lambda name: cube_mesh(name, 1.6, crease=0.7), True, 3),
}


def build():
    empty_scene()
    white = diffuse("White", WHITE)
    room(white, diffuse("Red", RED), diffuse("Green", GREEN))
    for name, height in (("Lower shelf", 0.68), ("Upper shelf", 1.28)):
        box(name, (2.002, 0.5, 0.02), (0, 0.751, height), white)
    props(places())
    lamp("SPOT", "Spot", (-0.5, -0.7, 1.9), (0.1, 0.6, 0.6), 90, color=(1, 0.9, 0.75), spot_size=math.radians(75),
         spot_blend=0.3, shadow_soft_size=0.05)
    lamp("AREA", "Area", (0.35, -0.1, 1.98), (0.35, -0.1, 0), 14, color=(0.8, 0.9, 1), shape="RECTANGLE", size=0.6,
         size_y=0.4)


def places():
    """Where each prop stands and its half width: 24 on the floor, 18 on each shelf."""
    for row in range(4):
        for column in range(6):
            yield (-0.82 + 0.328 * column, -0.8 + 0.4 * row, 0), 0.13
    for height in (0.7, 1.3):
        for row in range(2):
            for column in range(9):
                yield (-0.86 + 0.215 * column, 0.62 + 0.24 * row, height), 0.095


def props(places):
    materials = [paint(i) for i in range(10)]
    shared = {}
    for i, ((x, y, z), half) in enumerate(places):
        # Step 3 of 5 kinds, 7 of 10 materials: neighbours in rows and columns differ.
        kind = list(KINDS)[(i + 3 * (i // 6)) % len(KINDS)]
        make, is_shared, levels = KINDS[kind]
        name = f"{kind} {i + 1:02}"
        mesh = shared.setdefault(kind, make(kind)) if is_shared else make(name)
        foot = min(vertex.co.z for vertex in mesh.vertices)
        obj = mesh_object(name, mesh, None, (x, y, z - half * foot), rotation=37 * i % 360, scale=half)
        if not mesh.materials:
            mesh.materials.append(materials[0])
        # On the object: those that share a mesh still differ in colour.
        obj.material_slots[0].link = "OBJECT"
        obj.material_slots[0].material = materials[7 * i % len(materials)]
        subdivide(obj, levels)


def paint(i):
    """Principled material number `i`: hues around the circle, from glossy to rough, each fifth a metal."""
    color = colorsys.hsv_to_rgb(i / 10, 0.65, 0.7)
    name = f"{'Metal' if i % 5 == 4 else 'Paint'} {i + 1:02}"
    inputs = {"Base Color": color, "Roughness": 0.3 + 0.06 * i, "Metallic": float(i % 5 == 4)}
    return surface(name, lambda tree: node(tree, PRINCIPLED, inputs))
