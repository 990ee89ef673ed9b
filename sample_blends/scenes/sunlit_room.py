# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A furnished room with walls of real thickness, a thin partition, and the sun through its window."""

import math

from lightmap_uvs import unwrap_all
from shading import WHITE, diffuse
from shapes import box, boxes, cylinder, sphere, wall_with_opening
from stage import camera, empty_scene, lamp


def build():
    scene = empty_scene()
    white, wood = diffuse("White", WHITE), diffuse("Wood", (0.5, 0.3, 0.15))
    shell(white)
    furniture(white, wood)
    lamp("SUN", "Sun", (-4, -1, 4), (0, 0.4, 0.9), 10, color=(1, 0.93, 0.82), angle=math.radians(0.5))
    camera((-1.75, -1.6, 1.45), (0.35, 0.7, 0.75), 75)
    unwrap_all(scene)


def shell(white):
    """Four by 3.5 by 2.5 m inside. The slabs and walls run into each other, so that no two faces share a plane."""
    box("Floor", (4.4, 3.9, 0.1), (0, 0, -0.1), diffuse("Floorboards", (0.6, 0.5, 0.38)))
    box("Ceiling", (4.4, 3.9, 0.1), (0, 0, 2.5), white)
    wall_with_opening("Window wall", (3.6, 0.1, 2.6), (-1.1, 1.1, 0.6, 2.3), (-2.05, 0, -0.05), white, rotation=-90)
    box("Blue wall", (0.1, 3.6, 2.6), (2.05, 0, -0.05), diffuse("Blue", (0.3, 0.45, 0.7)))
    box("Ochre wall", (4.3, 0.1, 2.6), (0, 1.8, -0.05), diffuse("Ochre", (0.75, 0.55, 0.25)))
    box("Camera wall", (4.3, 0.1, 2.6), (0, -1.8, -0.05), white)
    box("Partition", (0.02, 1.2, 2.55), (0.95, 1.2, -0.025), diffuse("Sage", (0.4, 0.55, 0.35)))


def furniture(white, wood):
    legs = [((0.06, 0.06, 0.7), (x, y, 0)) for x in (-0.54, 0.54) for y in (-0.29, 0.29)]
    boxes("Table", [((1.2, 0.7, 0.04), (0, 0, 0.69)), *legs], (-0.35, 0.35, -0.001), wood, rotation=12)
    boards = [((0.78, 0.28, 0.02), (0, 0.01, z)) for z in (0.1, 0.5, 0.9, 1.3)]
    sides = [((0.02, 0.3, 1.45), (x, 0, 0)) for x in (-0.4, 0.4)]
    boxes("Shelf", [*sides, *boards], (0.35, 1.59, -0.001), white)
    box("Crate", (0.35, 0.35, 0.35), (-1.3, -0.35, -0.001), diffuse("Brick", (0.6, 0.2, 0.12)), rotation=28)
    box("Book", (0.24, 0.17, 0.05), (-0.55, 0.25, 0.729), diffuse("Teal", (0.1, 0.4, 0.4)), rotation=35)
    box("Small box", (0.2, 0.18, 0.25), (0.25, 1.58, 0.519), wood, rotation=8)
    cylinder("Vase", 0.08, 0.28, (-0.15, 0.45, 0.729), diffuse("Rose", (0.7, 0.35, 0.4)))
    cylinder("Stool", 0.18, 0.45, (0.55, -0.1, -0.001), diffuse("Yellow", (0.75, 0.6, 0.15)))
    sphere("Globe", 0.13, (0.5, 1.58, 1.449), diffuse("Clay", (0.6, 0.4, 0.3)))
