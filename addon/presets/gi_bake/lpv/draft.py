# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.bounces = 1
gi_bake.light_samples = 8
gi_bake.antialias = 1
gi_bake.lpv.cells = 16
gi_bake.lpv.cascades = 1
gi_bake.lpv.map_resolution = 256
