# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What surfaces send of the light that comes to them."""


def reflected(base, albedo, light):
    """base + albedo · light: (h, w, 3) float32 each."""
    return base + albedo * light


def reflected_on_gpu(gpu, base, albedo, light):
    picture = gpu.empty(base.shape, 3)
    inputs = {"base": (base, 3), "albedo": (albedo, 3), "light": (light, 3)}
    gpu.dispatch("reflected", picture.items, inputs, {"picture": picture})
    return picture
