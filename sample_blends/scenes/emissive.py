# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A closed room without lamps: a warm panel on the ceiling and a cool strip on a wall shine by their material."""

from lightmap_uvs import unwrap_all
from shading import WHITE, diffuse, emission
from shapes import box, cylinder, interior, sphere
from stage import camera, empty_scene


def build():
    scene = empty_scene()
    white, grey = diffuse("White", WHITE), diffuse("Grey", (0.4, 0.4, 0.4))
    interior((-1.5, -1.5, 0), (1.5, 1.5, 2.4), floor=grey, ceiling=white, front=white, back=white, left=white,
             right=white)
    # Closed boxes half sunk into ceiling and wall, as fittings are.
    box("Warm panel", (1.2, 0.5, 0.04), (0.4, 0.2, 2.38), emission("Warm light", (1, 0.62, 0.3), 6))
    box("Cool strip", (0.04, 1.6, 0.25), (-1.5, 0.3, 0.9), emission("Cool light", (0.25, 0.55, 1), 7))
    box("Plinth", (0.6, 0.6, 0.7), (0.5, 0.55, -0.001), white, rotation=20)
    sphere("Ball", 0.25, (0.5, 0.55, 0.949), white)
    cylinder("Drum", 0.3, 0.45, (-0.6, 0.1, -0.001), diffuse("Terracotta", (0.6, 0.25, 0.15)))
    box("Screen", (0.9, 0.02, 1.5), (-0.4, 0.9, -0.001), diffuse("Olive", (0.4, 0.45, 0.2)), rotation=-12)
    camera((0.2, -1.4, 1.3), (0, 0.6, 1.05), 80)
    unwrap_all(scene)
