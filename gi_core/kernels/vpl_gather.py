# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What points gather from virtual point lights: which lights, how much each brings, and the sum.

    picked = chosen(…)              the lights that get shadow rays, with their irradiance over flux
    irradiance = added(picked, …)   their light
    irradiance = unshadowed(…)      both in one, where no rays are asked for

A pattern (`gathering.Pattern`) says for each point which lights it looks at. Where it looks at several candidates for
each sample, one survives, drawn in proportion to what it brings where nothing shades it: resampled importance sampling
(Talbot, Cline & Egbert 2005). The survivor stands for the sum of its group, so that the mean stays what it is and rays
go where light comes from.
"""

import numpy as np

from ..sampling import hash01
from ..vectors import pick
from .vpl_transfer import transfer

# In the order of their numbers in GLSL.
BOUNDS = ("disc", "distance", "geometry", "offset")

# Points that share what is fetched of a light, where all take all of them, and where neighbours take much the same.
_BLOCK, _NEIGHBOURS = 4, 8

# Turns for each light that neighbours take: one or two lights, rarely more.
_AROUND = 4

# Spreads the index of a group's first light over the bits of a hash's key.
_GOLDEN = 0x9E3779B1


def chosen(here, lights, pattern, bound: str = "disc", candidates: int = 1) -> np.ndarray:
    """The lights that points send shadow rays to, and their irradiance over flux where nothing is between.

    here: Surfels. lights: `vpls.Packed`. pattern: see `gathering.Pattern`. bound: see `vpl_transfer`.
    candidates: that follow each other in the pattern, of which one survives.
    Returns (s, n, 2) float32: the index, −1 for none, and the weight [1/m²]; float64 where there are more lights than
    float32 counts.
    """
    index, factor = pattern(here)
    kind = np.float32 if len(lights.at) <= 1 << 24 else np.float64
    at, axis = pick(lights.at, index), pick(lights.axis, index)
    where = here.position[:, None], here.normal[:, None]
    weight = transfer(*where, at[..., :3], axis[..., :3], at[..., 3], bound) * factor
    weight = np.where(index >= 0, weight, 0).astype(np.float32)
    if candidates == 1:
        return np.stack([index.T, weight.T], -1, dtype=kind, casting="same_kind")
    groups = (len(index), index.shape[1] // candidates, candidates)
    index, weight, brightness = (a.reshape(groups) for a in (index, weight, axis[..., 3]))
    brought = np.cumsum(weight * brightness, -1)
    total = brought[..., -1]
    # The first light tells passes and seeds apart: each draws anew.
    key = here.place[:, None] * groups[1] + np.arange(groups[1]) + index[..., 0] * _GOLDEN
    # Never the last one by rounding where it brings nothing.
    survivor = np.argmax(brought > (hash01(key, candidates) * total)[..., None], -1)[..., None]
    index, brightness = (np.take_along_axis(a, survivor, -1)[..., 0] for a in (index, brightness))
    weight = np.divide(total, brightness, out=np.zeros_like(total), where=brightness > 0)
    return np.stack([index.T, weight.T], -1, dtype=kind, casting="same_kind")


def chosen_on_gpu(gpu, here, lights, pattern, bound: str = "disc", candidates: int = 1):
    n, s = len(here), pattern.lights // candidates
    place = _places(gpu, here)
    inputs, integers, floats = pattern.on_gpu(gpu, here, place)
    picked = gpu.empty((s, n, 2), 2)
    gpu.dispatch(
        "vpl_gather", s * n, {**_points(here, lights), "place": (place, 2), **inputs},
        {"picked": picked},
        integers={"points": n, "samples": s, **integers}, floats=floats,
        defines={"BOUND": BOUNDS.index(bound), "CANDIDATES": candidates},
        with_sources=("hash01", "place", *pattern.sources, "vpl_transfer"), steps=candidates,
    )  # fmt: skip
    return picked


def unshadowed(here, lights, pattern, bound: str = "disc", candidates: int = 1) -> np.ndarray:
    """Irradiance of points from the lights that the pattern takes, whatever is between. Returns (n, 3) float32 [W/m²].

    Arguments as for `chosen`.
    """
    return added(chosen(here, lights, pattern, bound, candidates), lights.flux)


def unshadowed_on_gpu(gpu, here, lights, pattern, bound: str = "disc", candidates: int = 1):
    if candidates > 1:
        return gpu.run(added, gpu.run(chosen, here, lights, pattern, bound, candidates), lights.flux)
    n, inputs = len(here), {**_points(here, lights), "flux": (lights.flux, 3)}
    integers, floats, defines = {"points": n}, {}, {"BLOCK": 1, "BOUND": BOUNDS.index(bound)}
    source, sources, turns = "vpl_gather_every", ("vpl_transfer",), 1
    if "vpl_every" in pattern.sources:
        defines["BLOCK"] = _BLOCK
    else:
        place = _places(gpu, here)
        more, counts, floats = pattern.on_gpu(gpu, here, place)
        inputs, integers = {**inputs, "place": (place, 2), **more}, {**integers, **counts}
        source, sources = "vpl_gather_some", ("hash01", "place", *pattern.sources, "vpl_transfer")
        order = pattern.order(here, _NEIGHBOURS)
        if order is not None:
            source, inputs["order"], defines["BLOCK"], turns = "vpl_gather_ordered", (order, 1), _NEIGHBOURS, _AROUND

    def part(first: int, last: int):
        irradiance, block = gpu.empty((n, 3), 3), defines["BLOCK"]
        gpu.dispatch(
            source, -(-n // block), inputs, {"irradiance": irradiance}, {**integers, "begin": first, "end": last},
            floats, defines, sources, steps=block * turns * (last - first),
        )  # fmt: skip
        return irradiance

    return gpu.added_up(pattern.lights, turns, part)


def _places(gpu, here):
    """Points' places in halves, which are exact on the card."""
    halves = np.stack([here.place & 0xFFFF, here.place >> 16 & 0xFFFF], -1).astype(np.float32)
    return gpu.array(halves, 2)


def added(picked: np.ndarray, flux: np.ndarray) -> np.ndarray:
    """Irradiance of lights by their weights: (s, n, 2), (m, 3) -> (n, 3) float32 [W/m²]."""
    return np.einsum("sn,snc->nc", picked[..., 1], pick(flux, picked[..., 0].astype(np.int32)))


def added_on_gpu(gpu, picked, flux):
    s, n, _ = picked.shape

    def part(first: int, last: int):
        irradiance = gpu.empty((n, 3), 3)
        gpu.dispatch(
            "vpl_added", n, {"picked": (picked, 2), "flux": (flux, 3)}, {"irradiance": irradiance},
            integers={"begin": first, "end": last, "points": n}, steps=last - first,
        )  # fmt: skip
        return irradiance

    return gpu.added_up(s, 1, part)


def _points(here, lights) -> dict:
    return {
        "position": (here.position, 3), "normal": (here.normal, 3),
        "light_at": (lights.at, 4), "light_axis": (lights.axis, 4),
    }  # fmt: skip
