# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes the context that Blender's `gpu` module needs in the background.

From Blender 5.2 on `gpu.init()` does; before, a render engine that asks for a context gets one, and leaves it behind.
This file is also run by itself, to find out whether that works: where no driver is, Blender does not survive it.
"""

import contextlib

import bpy


def make_context():
    """Makes a context. Nothing is left in the file."""
    import gpu

    if hasattr(gpu, "init"):
        gpu.init()
        return

    class Engine(bpy.types.RenderEngine):
        bl_idname, bl_label, bl_use_gpu_context = "GI_BAKE_CONTEXT", "GI Bake", True

        def render(self, depsgraph):
            pass

    with contextlib.ExitStack() as gone:
        bpy.utils.register_class(Engine)
        gone.callback(bpy.utils.unregister_class, Engine)
        before = set(bpy.data.images)
        gone.callback(lambda: bpy.data.batch_remove(set(bpy.data.images) - before))
        scene = bpy.data.scenes.new("GI Bake")
        gone.callback(bpy.data.scenes.remove, scene)
        camera = bpy.data.cameras.new("GI Bake")
        gone.callback(bpy.data.cameras.remove, camera)  # takes the object along
        scene.camera = bpy.data.objects.new("GI Bake", camera)
        scene.render.engine = Engine.bl_idname
        scene.render.resolution_x = scene.render.resolution_y = 16
        bpy.ops.render.render(scene=scene.name)


if __name__ == "__main__":
    import os
    import sys

    make_context()
    import gpu

    sys.stdout.write(f"renderer: {gpu.platform.renderer_get()}\n")
    sys.stdout.flush()
    os._exit(0)  # Blender 4.5 may hang while it ends with a context
