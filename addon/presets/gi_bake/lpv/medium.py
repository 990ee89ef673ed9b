# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.bounces = 1
gi_bake.light_samples = 32
gi_bake.antialias = 2
gi_bake.lpv.cells = 32
gi_bake.lpv.cascades = 3
gi_bake.lpv.map_resolution = 512
