# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.samples = 256
gi_bake.bounces = 3
gi_bake.light_samples = 128
gi_bake.antialias = 2
gi_bake.ssgi.frames = 32
gi_bake.ssgi.full_resolution = True
gi_bake.ssgi.quality = "HIGH"
