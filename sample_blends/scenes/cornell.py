# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Cornell box, two metres wide, lit by a spot lamp whose cone stays inside."""

import math

from lightmap_uvs import unwrap_all
from shading import GREEN, RED, WHITE, diffuse
from shapes import box, interior
from stage import camera, empty_scene, lamp


def room(white, red, green):
    """Two metres a side, open at y = −1, and the camera in front of it."""
    interior((-1, -1, 0), (1, 1, 2), floor=white, ceiling=white, back=white, left=red, right=green)
    # A little narrower than the opening, so that every pixel shows a surface.
    camera((0, -3.88, 1), (0, 0, 1), 38)


def build():
    scene = empty_scene()
    white = diffuse("White", WHITE)
    room(white, diffuse("Red", RED), diffuse("Green", GREEN))
    # A millimetre into the floor: no faces in one plane, no slit of light.
    box("Tall box", (0.6, 0.6, 1.2), (-0.34, 0.35, -0.001), white, rotation=-17)
    box("Short box", (0.6, 0.6, 0.5), (0.34, -0.25, -0.001), white, rotation=18)
    lamp("SPOT", "Spot", (0, 0.08, 1.95), (0, 0.08, 0), 115, spot_size=math.radians(58), spot_blend=0.15,
         shadow_soft_size=0.02)
    unwrap_all(scene)
