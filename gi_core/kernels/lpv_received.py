# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""From the light around points to what their surfaces get of it."""

import numpy as np

from .. import sh


def received(found, normal, factor, ahead=None, exponent: float = 0.0):
    """Irradiance on surfaces: (n, 3) float32 [W/m²].

    found: (n, k, 3) float32 coefficients of irradiance over the normal at points. normal: (n, 3). factor: (n,) float32.
    ahead: as found, a step along the normal, for derivative damping by that exponent above 0.
    """
    if ahead is not None:
        factor = factor * damping(found, ahead - found) ** np.float32(exponent)
    return np.maximum(sh.evaluate(found, normal), 0) * factor[:, None]


def damping(found, change):
    """How much light on a surface is believed, by how it changes along the normal: (n, k, 3), (n, k, 3) -> (n,).

    Light that has come to the surface from before it grows along the normal; light of the other side, which has only
    leaked into the cell, becomes less (Kaplanyan 2009). 1 where both point the same way, 0 where they are opposite.
    """
    cosine = np.einsum("nkc,nkc->nc", found, change)
    norms = np.einsum("nkc,nkc->nc", found, found) * np.einsum("nkc,nkc->nc", change, change)
    cosine = np.divide(cosine, np.sqrt(norms), out=np.zeros_like(cosine), where=norms > 0)
    return np.clip(cosine.max(-1), 0, 1)


def received_on_gpu(gpu, found, normal, factor, ahead=None, exponent: float = 0.0):
    n, bands, _ = found.shape
    irradiance = gpu.empty((n, 3), 3)
    inputs = {"found": (found, 3), "normal": (normal, 3), "factor": (factor, 1)}
    gpu.dispatch(
        "lpv_received", n, inputs if ahead is None else {**inputs, "ahead": (ahead, 3)}, {"irradiance": irradiance},
        floats={} if ahead is None else {"exponent": exponent},
        defines={"BANDS": bands, "DAMPED": int(ahead is not None)}, steps=bands,
    )  # fmt: skip
    return irradiance
