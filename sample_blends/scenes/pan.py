# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Sixteen frames of a camera that pans and travels over a set that stands still, under an area lamp."""

import math

from lightmap_uvs import unwrap_all
from shading import WHITE, diffuse
from shapes import box, cylinder, interior, sphere
from stage import camera, empty_scene, lamp

FRAMES = 16


def build():
    scene = empty_scene((256, 144))
    scene.frame_start, scene.frame_end = 1, FRAMES
    set_pieces()
    lamp("AREA", "Area", (-0.3, 0.2, 2.55), (-0.3, 0.2, 0), 55, shape="RECTANGLE", size=1.6, size_y=0.8)
    travel(camera((0, -1.85, 1.35), (0, 1, 0.85), 72))
    unwrap_all(scene)


def set_pieces():
    white = diffuse("White", WHITE)
    red, blue = diffuse("Red", (0.65, 0.12, 0.08)), diffuse("Blue", (0.12, 0.25, 0.6))
    yellow, green = diffuse("Yellow", (0.75, 0.55, 0.12)), diffuse("Green", (0.2, 0.5, 0.15))
    interior((-3, -2, 0), (3, 2, 2.6), floor=diffuse("Floor", (0.5, 0.45, 0.4)), ceiling=white, front=white, back=white,
             left=red, right=blue)
    for i, x in enumerate((-2, -0.7, 0.7, 2)):
        cylinder(f"Column {i + 1}", 0.14, 2.602, (x, 1.3, -0.001), white)
    box("Red block", (0.5, 0.5, 0.5), (-1.5, 0.5, -0.001), red, rotation=30)
    box("Yellow block", (0.4, 0.4, 0.8), (0.05, 0.75, -0.001), yellow, rotation=-15)
    box("Blue block", (0.7, 0.35, 0.35), (1.3, 0.2, -0.001), blue, rotation=20)
    box("Green board", (0.9, 0.03, 1.2), (1.95, 0.8, -0.001), green, rotation=-35)
    sphere("White ball", 0.28, (-0.55, 0.15, 0.279), white)
    sphere("Yellow ball", 0.2, (1.25, 0.22, 0.548), yellow)


def travel(obj):
    """Key an even way of 1.2 m to the right and a turn of 30 degrees: near things uncover far ones."""
    for frame, x, turn in ((1, -0.6, 15), (FRAMES, 0.6, -15)):
        obj.location.x = x
        obj.rotation_euler.z = math.radians(turn)
        obj.keyframe_insert("location", frame=frame)
        obj.keyframe_insert("rotation_euler", frame=frame)
    animation = obj.animation_data
    for curve in animation.action.layers[0].strips[0].channelbag(animation.action_slot).fcurves:
        for key in curve.keyframe_points:
            key.interpolation = "LINEAR"
