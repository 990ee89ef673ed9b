# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What each receiver collects while tiles are worked out: layers of its whole image by name, its canvas."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ..gi_core.receivers import Receiver
from ..gi_core.scene import Camera
from ..gi_core.settings import Settings
from . import denoise


def kept_layers(settings: Settings, camera: Camera | None) -> set[str]:
    """Layers that the result or the denoiser needs: a hundred large lightmaps have no memory to give away."""
    light = {"Lamps", "Around", "Indirect", "Coverage", "Centred"}
    light |= set() if camera else {"Inside"}
    guides = {"Color", "Normal", "Position"} if camera or settings.denoise == "oidn" else set()
    guides |= {"Normal"} if settings.directional else set()
    guides |= {"Normal", "Position"} if getattr(settings, "interpolation", 1) > 1 else set()
    guides |= {"Color", "Emission"} if settings.gltf and not camera else set()
    gloss = {"Glossy Lamps", "Glossy Around", "Glossy Indirect", "Glossy Color"} if settings.glossy else set()
    fog = {"Volume Direct", "Volume Indirect", "Transmittance"} if getattr(settings, "fog_density", 0) else set()
    return light | guides | gloss | fog | ({"Emission", "Sky"} if camera else set())


def put(
    canvas: dict[str, np.ndarray], found: dict[str, np.ndarray], names: set[str], receiver: Receiver, rows, kept
):
    """Copies the rows of a tile that are kept to the receiver's rows that they are."""
    height = receiver.height // receiver.subpixels
    for name in names:
        layer = found[name]
        if name not in canvas:
            canvas[name] = np.zeros((height, *layer.shape[1:]), layer.dtype)
        canvas[name][pixels(kept, receiver)] = layer[pixels(rows, receiver)]


def pixels(rows: slice, receiver: Receiver) -> slice:
    """Rows of subpixels as rows of pixels."""
    return slice(rows.start // receiver.subpixels, rows.stop // receiver.subpixels)


def without_noise(canvases: dict[str, dict[str, np.ndarray]], noisy: bool, apart: bool) -> Iterator[float]:
    """Takes the noise out of all images' diffuse light; noisy: out of what is reflected too. apart: each island by
    itself. A generator of progress."""
    found = list(canvases.values())
    kinds = ["Around", *(["Indirect"] if noisy else [])]
    smoothed = denoise.smoothed_islands if apart else denoise.smoothed
    clean = yield from smoothed([np.concatenate([c[k] for k in kinds], -1) for c in found], found)
    for canvas, light in zip(found, clean):
        for kind, part in zip(kinds, np.split(light, len(kinds), axis=-1)):
            canvas[kind] = np.where(canvas["Coverage"] > 0, part, 0)
