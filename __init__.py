# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""GI Bake: global illumination baked in seconds, measured against Cycles.

Blender's extension system looks for `register` and `unregister` here; everything lives in `addon` and `gi_core`.
"""


def register():
    from . import addon

    addon.register()


def unregister():
    from . import addon

    addon.unregister()
