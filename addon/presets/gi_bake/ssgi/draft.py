# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.samples = 16
gi_bake.bounces = 1
gi_bake.light_samples = 8
gi_bake.antialias = 1
gi_bake.ssgi.frames = 4
gi_bake.ssgi.full_resolution = False
gi_bake.ssgi.quality = "LOW"
