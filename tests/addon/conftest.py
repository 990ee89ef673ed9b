# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What tests of the panel share."""

import importlib

import bpy
import pytest


@pytest.fixture
def gi(extension, sample, tmp_path):
    """Imports a module of the enabled extension; the Cornell box is open, and small bakes are asked for."""

    def module(name):
        return importlib.import_module(f"{extension.__name__}.{name}")

    bpy.ops.wm.open_mainfile(filepath=str(sample("cornell")))
    group = bpy.context.scene.gi_bake
    group.samples, group.light_samples, group.rsm.map_resolution = 4, 4, 32
    group.use_render_size, group.image_resolution, group.resolution, group.antialias = False, 24, 16, 1
    group.folder = str(tmp_path / "out")
    yield module
    module("addon.session").session.clear()
