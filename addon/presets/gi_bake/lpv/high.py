# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.bounces = 3
gi_bake.light_samples = 128
gi_bake.antialias = 3
gi_bake.lpv.cells = 64
gi_bake.lpv.cascades = 3
gi_bake.lpv.map_resolution = 1024
