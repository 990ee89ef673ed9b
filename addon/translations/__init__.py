# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The interface in other languages, one file for each."""

import bpy

from .zh_hans import ZH_HANS

PACKAGE = __name__.rpartition(".addon.")[0]


def register():
    bpy.app.translations.register(PACKAGE, {"zh_HANS": ZH_HANS})


def unregister():
    bpy.app.translations.unregister(PACKAGE)
