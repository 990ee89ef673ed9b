# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Virtual point lights into cells: Kaplanyan & Dachsbacher 2010, §4.2.

A Lambertian light of flux Φ about n has the intensity Φ/π · max(0, n·ω): a cosine lobe. Fluxes add up; nothing is
divided by the number of lights.

The other form, kept for comparison, puts in a delta towards the cell's middle instead, with a cosine at the light
where the lobe has one already: a light in the middle of its cell has no direction and is lost.
"""

import math

import numpy as np

from .. import sh
from ..vectors import dot, normalize


def coefficients(flux, normal, towards=None) -> np.ndarray:
    """Intensity of lights as two bands: (n, 3) Φ [W], (n, 3) unit -> (n, 4, 3) float32 [W/sr].

    towards: (n, 3) from each light to the middle of its cell, for the other form.
    """
    if towards is None:
        lobe = sh.cosine_lobe(normal) / np.float32(np.pi)
    else:
        direction = normalize(towards)
        cosine = np.maximum(dot(normal, direction), 0)
        lobe = sh.basis(direction) * (cosine * np.any(direction != 0, -1))[:, None]
    return lobe[:, :, None] * flux[:, None, :]


def summed(cell, values, size: int) -> np.ndarray:
    """Values added up by cell: (n,) in [0, size), (n, ...) -> (size, ...) float32."""
    columns = values.reshape(len(values), int(np.prod(values.shape[1:])))
    out = np.empty((size, columns.shape[1]), np.float32)
    for k in range(columns.shape[1]):
        out[:, k] = np.bincount(cell, columns[:, k], size)
    return out.reshape(size, *values.shape[1:])


def coefficients_on_gpu(gpu, flux, normal, towards=None):
    n = len(flux)
    intensity = gpu.empty((n, 4, 3), 3)
    inputs = {"flux": (flux, 3), "normal": (normal, 3)}
    gpu.dispatch(
        "lpv_inject", n, inputs if towards is None else {**inputs, "towards": (towards, 3)}, {"intensity": intensity},
        defines={"TOWARDS": int(towards is not None)},
    )  # fmt: skip
    return intensity


def summed_on_gpu(gpu, cell, values, size: int):
    """Each cell gathers its own: cards add no floating-point numbers from several sides."""
    columns = math.prod(values.shape[1:])
    channels = next(c for c in (4, 3, 2, 1) if columns % c == 0 and values.shape[-1] % c == 0)
    order = np.argsort(cell, kind="stable")
    start = np.searchsorted(cell[order], np.arange(size + 1))
    inputs = {"values": (values, channels), "order": (gpu.array(order, 1), 1), "start": (gpu.array(start, 1), 1)}

    def part(first: int, last: int):
        total = gpu.empty((size, *values.shape[1:]), channels)
        gpu.dispatch(
            "summed", size * columns // channels, inputs, {"total": total}, {"begin": first, "end": last},
            defines={"COLUMNS": columns // channels}, steps=max(1, len(cell) // max(1, size)),
        )  # fmt: skip
        return total

    return gpu.added_up(int(np.diff(start).max(initial=0)), 1, part)
