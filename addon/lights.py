# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The light of lightmaps and vertices out of the layers that were collected for them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..gi_core import directional, images, ssgi
from ..gi_core.atlas import Page
from ..gi_core.receivers import Receiver
from ..gi_core.tiles import finish
from .job import Job
from .result import Light


def coverage_of(receiver: Receiver, views: list[ssgi.View]) -> np.ndarray | None:
    """How surely cameras saw a receiver's places, 0…1, in its shape; None without cameras."""
    if not views:
        return None
    points, _ = receiver.points(slice(0, receiver.height))
    _, coverage = finish(ssgi.seen(views, points))
    return images.spread(coverage[:, None], points.place, (receiver.height, receiver.width)).reshape(receiver.shape)


def light_of(canvas: dict[str, np.ndarray], shape: tuple[int, ...], coverage: np.ndarray | None) -> Light:
    direct, indirect = (canvas[name].reshape(*shape, 3) / np.float32(np.pi) for name in ("Direct", "Indirect"))
    valid = canvas["Coverage"].reshape(shape) > 0
    centred, inside = (canvas[name].reshape(shape) for name in ("Centred", "Inside"))
    return Light(direct, indirect, valid, centred, valid, coverage, inside=inside)


def directional_of(light: dict[str, Light], page: Page, canvas: dict[str, np.ndarray], job: Job) -> Light:
    """A page's light with what it is for other normals too, out of its lights for four."""
    four = [light[directional.named(page.name, k)] for k in range(4)]
    seen = np.stack([job.settings.wanted(each.direct, each.indirect) for each in four])
    return replace(four[0], directional=directional.coefficients(seen, canvas["Normal"]))


def radiant(light: Light, canvas: dict[str, np.ndarray], job: Job) -> Light:
    """Light with what the surface makes of it."""
    wanted = job.settings.wanted(light.direct, light.indirect)
    return replace(light, radiance=canvas["Color"] * wanted + canvas["Emission"])
