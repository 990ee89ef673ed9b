# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Receivers laid out as images: surfels to pixels, and what a camera's subpixels make of a pixel."""

import math
from collections.abc import Iterator

import numpy as np

from . import environment as beyond
from .device import NUMPY, Device
from .filter import reach as filter_reach
from .filter import smooth, walls_between
from .scene import Camera, Environment
from .surfels import Surfels, camera_rays
from .trace import Tracer
from .vectors import pick, put

# Passes of the filter that tell how much of what was taken is noise, around each pixel.
_NEAR = 2

# Albedo up to which light counts at least, where a pixel's subpixels are weighed by it: black surfaces are lit too.
_DARK = np.float32(1e-3)


def spread(values: np.ndarray, place: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    """Values at places of an image, zero elsewhere: (n, c), (n,) row · width + column, (h, w) -> (h, w, c)."""
    image = np.zeros((shape[0] * shape[1], values.shape[-1]), values.dtype)
    put(image, place, values)
    return image.reshape(*shape, -1)


def reach(passes: int, subpixels: int = 1) -> int:
    """How far light that was `smoothed` depends on its neighbours [subpixels]."""
    return filter_reach(passes) + filter_reach(_near(subpixels))


def _near(subpixels: int) -> int:
    """Passes that reach as far over pixels as _NEAR does without subpixels: these share their pixel's light, and know
    no more of its noise together than one does."""
    return _NEAR + math.ceil(math.log2(subpixels))


def smoothed(
    irradiance: np.ndarray,
    surfels: Surfels,
    place: np.ndarray,
    shape: tuple[int, int],
    passes: int,
    variance: np.ndarray | None = None,
    tracer: Tracer | None = None,
    island: np.ndarray | None = None,
    device: Device = NUMPY,
    subpixels: int = 1,
) -> Iterator[float]:
    """Irradiance of an image's surfels, filtered along surfaces: (n, 3 k) -> (n, 3 k).

    place: (n,) of each in an image of `shape`. variance: (n, 3) of the k parts' sum; where it is known what the filter
    takes beyond noise is given back. tracer: finds the walls that the filter must not cross in a lightmap; what one
    camera sees needs none. island: (h,) number of each row's image, where several stand one above the other.
    subpixels: of a pixel along each axis. A generator of progress; returns the values.
    """
    lit = np.flatnonzero(irradiance.any(0))
    if not len(lit):
        return irradiance
    noisy, position, normal = (spread(a, place, shape) for a in (irradiance[:, lit], surfels.position, surfels.normal))
    walls = None if tracer is None else walls_between(tracer, position, normal)
    if walls is not None and island is not None:
        walls[..., 1] += (island * (shape[0] + 1))[:, None]
    image = yield from smooth(noisy, position, normal, passes, walls, device)
    if variance is not None:
        change = noisy - image
        taken = sum(sum(change[..., k] for k in np.flatnonzero(lit % 3 == c)) ** 2 for c in range(3))
        both = np.stack([taken, spread(variance.sum(-1, keepdims=True), place, shape)[..., 0]], -1)
        taken, noise = np.moveaxis((yield from smooth(both, position, normal, _near(subpixels), walls, device)), -1, 0)
        image += detail(taken, noise)[..., None] * change
    smooth_light = np.zeros_like(irradiance)
    smooth_light[:, lit] = pick(image.reshape(shape[0] * shape[1], -1), place)
    return smooth_light


def detail(taken: np.ndarray, noise: np.ndarray) -> np.ndarray:
    """Share of what a filter took that was light and not noise: Wiener's filter, from the mean square of what it took
    and the variance of the noise there, (h, w) each, to 0…1."""
    most = np.maximum(taken, noise)
    return 1 - np.divide(noise, most, out=np.ones_like(most), where=most > 0)


def resolved(
    surfels: Surfels, place: np.ndarray, shape: tuple[int, int], subpixels: int, light: dict[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Subpixels to pixels: (n,) surfels at places of an image of (h, w) subpixels, to (h / s, w / s, c) float32 each.

    light: name -> (n, c) irradiance. Of a pixel it is the light that its subpixels reflect over their colour, as in
        Cycles' passes, so that a pixel on a silhouette weighs them alike.
    The rest are means, but position and normal, which are one subpixel's. "Coverage" is 0…1.
    """

    def mean(values: np.ndarray) -> np.ndarray:
        image = spread(values, place, shape)
        return image if subpixels == 1 else summed(image, subpixels) / np.float32(subpixels**2)

    def one(values: np.ndarray) -> np.ndarray:
        return spread(values, place, shape)[subpixels // 2 :: subpixels, subpixels // 2 :: subpixels]

    layers = {
        "Color": mean(surfels.albedo), "Emission": mean(surfels.emission),
        "Normal": one(surfels.normal), "Position": one(surfels.position),
        "Coverage": mean(np.ones((len(surfels), 1), np.float32)),
    }  # fmt: skip
    if subpixels == 1:
        return layers | {name: mean(values) for name, values in light.items()}
    weight = surfels.albedo + _DARK
    return layers | {name: over_color(values, weight, place, shape, subpixels) for name, values in light.items()}


def summed(image: np.ndarray, subpixels: int) -> np.ndarray:
    """The sum of each pixel's subpixels: (h, w, c) -> (h / s, w / s, c)."""
    rows = sum(image[k::subpixels] for k in range(subpixels))
    return sum(rows[:, k::subpixels] for k in range(subpixels))


def over_color(
    light: np.ndarray, color: np.ndarray, place: np.ndarray, shape: tuple[int, int], subpixels: int
) -> np.ndarray:
    """Light over colour of each pixel, whose subpixels count by their colour; zero where there is none.

    light, color: (n, 3) at places of an image of (h, w) subpixels. Returns (h / s, w / s, 3) float32.
    """
    reflected, whole = (summed(spread(a, place, shape), subpixels) for a in (color * light, color))
    return np.divide(reflected, whole, out=np.zeros_like(reflected), where=whole > 0)


def sky(
    environment: Environment, camera: Camera, subpixels: int, rows: slice, place: np.ndarray
) -> np.ndarray:  # fmt: skip
    """What some rows of subpixels see of the environment, by pixels: (h, w, 3) float32 radiance [W/(m²·sr)].

    place: (n,) the subpixels that see a surface, counted from the first of the rows.
    """
    height, width = rows.stop - rows.start, camera.resolution[0] * subpixels
    seen = np.zeros((height * width, 3), np.float32)
    free = np.ones(len(seen), bool)
    free[place] = False
    if free.any() and not beyond.is_black(environment):
        _, direction = camera_rays(camera, subpixels, rows)
        seen[free] = beyond.radiance(environment, direction[free])
    return summed(seen.reshape(height, width, 3), subpixels) / np.float32(subpixels**2)


def camera_layers(found: dict[str, np.ndarray], camera: Camera, transparent: bool) -> dict[str, np.ndarray]:
    """What a camera sees, in layers named as Blender's passes: (h, w, c) float32 each.

    found: what `resolved` gave for the whole image, with light "Direct" and "Indirect" [W/m²], "Sky", and what
        glossy surfaces reflect and a medium scatters, where that is wanted.
    transparent: leave the sky out of the picture.
    Diffuse light is E/π without colour, as Cycles' passes are; where nothing reflects there is none.
    """
    color, coverage = found["Color"], found["Coverage"]
    lit = {name: np.where(color > 0, found[name], 0) / np.float32(np.pi) for name in ("Direct", "Indirect")}
    combined = color * (lit["Direct"] + lit["Indirect"]) + found["Emission"]
    alpha = coverage
    if not transparent:
        combined, alpha = combined + found["Sky"], np.ones_like(coverage)
    medium = {}
    if "Transmittance" in found:
        medium = {name: found[name] for name in ("Volume Direct", "Volume Indirect")}
    depth = ((found["Position"] - camera.matrix[:3, 3]) @ -camera.matrix[:3, 2])[..., None].astype(np.float32)
    surface = np.any(found["Normal"] != 0, -1, keepdims=True)
    gloss = {}
    if "Glossy Color" in found:
        gloss = {name: found[name] for name in ("Glossy Direct", "Glossy Indirect", "Glossy Color")}
        combined = combined + gloss["Glossy Color"] * (gloss["Glossy Direct"] + gloss["Glossy Indirect"])
    if medium:
        through = found["Transmittance"]
        combined = combined * through + medium["Volume Direct"] + medium["Volume Indirect"]
        alpha = 1 - through * (1 - alpha)
    return {
        "Combined": np.concatenate([combined, alpha], -1),
        "Diffuse Direct": lit["Direct"],
        "Diffuse Indirect": lit["Indirect"],
        "Diffuse Color": color,
        "Emission": found["Emission"],
        "Irradiance": np.float32(np.pi) * (lit["Direct"] + lit["Indirect"]),
        "Normal": found["Normal"],
        "Position": found["Position"],
        # Blender's depth of nothing.
        "Depth": np.where(surface, depth, np.float32(1e10)),
        **gloss,
        **medium,
    }

