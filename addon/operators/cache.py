# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The cache folder emptied."""

import shutil

from bpy.types import Operator

from .. import preferences


class GI_OT_clear_cache(Operator):
    """Delete what is kept: baked materials, comparisons of files that are not saved, and timings"""

    bl_idname = "gi.clear_cache"
    bl_label = "Clear Cache"
    bl_options = {"INTERNAL"}

    @classmethod
    def poll(cls, context):
        if not preferences.cached_files():
            cls.poll_message_set("The cache folder is empty")
            return False
        return True

    def execute(self, context):
        for path in preferences.cached_files():
            path.unlink(missing_ok=True)
        shutil.rmtree(preferences.cache_folder(), ignore_errors=True)
        return {"FINISHED"}


classes = (GI_OT_clear_cache,)
