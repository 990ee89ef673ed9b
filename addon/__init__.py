# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The Blender side: reads the scene, runs the bake, writes results back, compares with Cycles."""

_commands = []


def _modules():
    # Here and not above: without a Blender around it, `gi_bake.addon` can still be imported to be looked at.
    from . import operators, preferences, presets, properties, session, translations, ui

    return properties, session, operators, presets, ui, preferences, translations


def register():
    import bpy

    from . import cli

    for module in _modules():
        module.register()
    _commands.append(bpy.utils.register_cli_command("gi_bake", cli.command))


def unregister():
    import bpy

    while _commands:
        bpy.utils.unregister_cli_command(_commands.pop())
    for module in reversed(_modules()):
        module.unregister()
