# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Two rooms with a wall of one centimetre between them and a lamp in the left one: no light may reach the right one."""

from lightmap_uvs import unwrap_all
from shading import WHITE, diffuse
from shapes import box, cylinder, interior
from stage import camera, empty_scene, lamp


def build():
    scene = empty_scene((256, 128))
    white = diffuse("White", WHITE)
    # Open at y = −1. What lies behind that plane is convex, so the wall blocks every straight line between the rooms.
    interior((-2, -1, 0), (2, 1, 2), floor=white, ceiling=white, back=white, left=diffuse("Orange", (0.7, 0.4, 0.1)),
             right=diffuse("Blue", (0.15, 0.3, 0.65)))
    box("Thin wall", (0.01, 2.002, 2.002), (0, 0, -0.001), white)
    box("Lit box", (0.5, 0.5, 0.8), (-1.2, 0.3, -0.001), white, rotation=25)
    cylinder("Dark cylinder", 0.3, 0.9, (1.1, 0.2, -0.001), white)
    # Near the wall: brightest where a leak would show.
    lamp("POINT", "Point", (-0.55, -0.1, 1.3), (-0.55, -0.1, 0), 20, shadow_soft_size=0.03)
    # A step to the right, the lens shifted back: the wall's dark side shows, the opening still fills the picture.
    camera((0.5, -5, 1), (0.5, 0, 1), 52).data.shift_x = -0.128
    unwrap_all(scene)
