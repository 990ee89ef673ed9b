# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The box that a volume covers, given as numbers or as an object: an empty, or a mesh that need not render."""

from itertools import product

import bpy
from mathutils import Vector


def box_corners(text: str, scene: bpy.types.Scene) -> str:
    """An object's name as the corners of its box in the world, 'x y z x y z'; any other text as it is."""
    obj = scene.objects.get(text.strip())
    if obj is None:
        return text
    half = obj.empty_display_size
    local = product((-half, half), repeat=3) if obj.type == "EMPTY" else obj.bound_box
    world = [obj.matrix_world @ Vector(corner) for corner in local]
    low, high = (tuple(f(point[k] for point in world) for k in range(3)) for f in (min, max))
    return " ".join(f"{value:.9g}" for value in (*low, *high))
