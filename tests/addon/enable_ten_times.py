# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Enable and disable the extension ten times in a Blender of its own: `enable_ten_times.py REPOSITORY REPORT`.

REPOSITORY is a folder that holds the extension as `gi_bake`. REPORT is written as JSON: what was `added` to Blender
when the extension was first enabled, and what was `left` when it was last disabled.
"""

import collections
import json
import sys
from pathlib import Path

import bpy

import addon_utils

MODULE = "bl_ext.t.gi_bake"


def count_commands():
    """Keep book of the commands for Blender's command line, of which Blender gives no list: handle -> name."""
    commands, register, unregister = {}, bpy.utils.register_cli_command, bpy.utils.unregister_cli_command

    def register_cli_command(name, execute):
        handle = register(name, execute)
        commands[id(handle)] = handle, name
        return handle

    def unregister_cli_command(handle):
        unregister(handle)
        commands.pop(id(handle), None)

    bpy.utils.register_cli_command, bpy.utils.unregister_cli_command = register_cli_command, unregister_cli_command
    return commands


def subclasses(cls):
    for subclass in cls.__subclasses__():
        yield subclass
        yield from subclasses(subclass)


def hung_in_blender(commands):
    """Count everything that an extension can hang into Blender, by name."""
    names = [f"command {name}" for _, name in commands.values()]
    for cls in subclasses(bpy.types.bpy_struct):
        # In bpy.types lie Blender's own classes, made when they are first asked for.
        if cls.__module__ != "bpy.types" and getattr(cls, "is_registered", False):
            names.append(f"class {cls.__module__}.{cls.__name__}")
    for cls in (getattr(bpy.types, name) for name in dir(bpy.types)):
        if isinstance(cls, type) and hasattr(cls, "bl_rna"):
            names += [f"property {cls.__name__}.{key}" for key in cls.bl_rna.properties.keys()]
            drawn = getattr(getattr(cls, "draw", None), "_draw_funcs", ())
            names += [f"drawn in {cls.__name__}: {f.__name__}" for f in drawn if f.__module__ != cls.__module__]
    for name in dir(bpy.app.handlers):
        if isinstance(handlers := getattr(bpy.app.handlers, name), list):
            names += [f"handler {name}: {f!r}" for f in handlers]
    for keymap in bpy.context.window_manager.keyconfigs.addon.keymaps:
        names += [f"key in {keymap.name}: {item.idname}" for item in keymap.keymap_items]
    return collections.Counter(names)


def enable_ten_times(repository, report):
    def fail(error):
        raise error

    commands = count_commands()
    bpy.context.preferences.extensions.repos.new(name="t", module="t", custom_directory=repository)
    addon_utils.extensions_refresh()
    before = hung_in_blender(commands)
    for cycle in range(10):
        addon_utils.enable(MODULE, default_set=True, handle_error=fail)
        if cycle == 0:
            added = hung_in_blender(commands) - before
        addon_utils.disable(MODULE, default_set=True, handle_error=fail)
    left = hung_in_blender(commands) - before
    Path(report).write_text(json.dumps({"added": sorted(added.elements()), "left": sorted(left.elements())}))


enable_ten_times(*sys.argv[1:])
