# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.samples = 64
gi_bake.bounces = 1
gi_bake.light_samples = 32
gi_bake.antialias = 2
gi_bake.ssgi.frames = 16
gi_bake.ssgi.full_resolution = True
gi_bake.ssgi.quality = "CUSTOM"
gi_bake.ssgi.steps = 64
gi_bake.ssgi.mixed_steps = 48
gi_bake.ssgi.radius = 0.5
