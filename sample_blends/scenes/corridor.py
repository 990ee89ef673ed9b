# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed corridor of 16 m, lit at the near end only: how far does indirect light reach?"""

import math

from lightmap_uvs import unwrap_all
from shading import WHITE, diffuse
from shapes import interior, mesh_object, polygons
from stage import camera, empty_scene, lamp

WIDTH, HEIGHT, LENGTH, BAND = 2.0, 2.5, 16, 2


def build():
    scene = empty_scene()
    white = diffuse("White", WHITE)
    interior((-WIDTH / 2, 0, 0), (WIDTH / 2, LENGTH, HEIGHT), floor=white, ceiling=white, front=white, back=white)
    red, yellow = diffuse("Red", (0.65, 0.12, 0.1)), diffuse("Yellow", (0.75, 0.6, 0.15))
    green, blue = diffuse("Green", (0.2, 0.5, 0.15)), diffuse("Blue", (0.15, 0.3, 0.65))
    banded_wall("Left wall", -1, [red, yellow, green, blue])
    banded_wall("Right wall", 1, [green, blue, red, yellow])
    lamp("SPOT", "Spot", (0, 2.6, 2.4), (0, 0.3, 0.4), 330, spot_size=math.radians(80), spot_blend=0.3,
         shadow_soft_size=0.03)
    camera((0.25, 0.3, 1.6), (-0.1, 8, 1), 70)
    unwrap_all(scene)


def banded_wall(name, side, materials):
    """One mesh at x = ±WIDTH/2 whose faces, one for each BAND metres, take the `materials` in turn."""
    edges = range(0, LENGTH + 1, BAND)
    vertices = [(0, y, z) for y in edges for z in (0, HEIGHT)]
    faces = [(i, i + 2, i + 3, i + 1)[::-side] for i in range(0, 2 * len(edges) - 2, 2)]
    mesh = polygons(name, vertices, faces)
    for material in materials:
        mesh.materials.append(material)
    mesh.polygons.foreach_set("material_index", [i % len(materials) for i in range(len(faces))])
    return mesh_object(name, mesh, None, (side * WIDTH / 2, 0, 0))
