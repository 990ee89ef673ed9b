# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
import bpy

gi_bake = bpy.context.scene.gi_bake

gi_bake.samples = 16
gi_bake.noise_threshold = 0.0
gi_bake.time_limit = 0.0
gi_bake.bounces = 1
gi_bake.light_samples = 8
gi_bake.denoise = "AUTO"
gi_bake.denoise_passes = 3
gi_bake.antialias = 1
gi_bake.rsm.map_resolution = 128
gi_bake.rsm.interpolation = 2
