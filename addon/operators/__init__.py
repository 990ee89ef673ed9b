# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""`bpy.ops.gi`: everything that the panel does, alike in a window, in the background and in scripts.

bpy.ops.gi.bake(method="RSM", target="LIGHTMAP", resolution=512)      to its end
bpy.ops.gi.bake("INVOKE_DEFAULT")                                     as the button does, beside a living window
"""

import bpy

from . import bake, cache, check, compare, remedies, results

classes = (
    *bake.classes, *check.classes, *compare.classes, *results.classes, *remedies.classes, *cache.classes,
)  # fmt: skip
register, unregister = bpy.utils.register_classes_factory(classes)
