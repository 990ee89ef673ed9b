# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Receivers laid out as images: surfels to pixels and back, and what a camera's subpixels make of a pixel."""

from collections.abc import Iterator

import numpy as np

from . import environment as beyond
from .filter import smooth, walls_between
from .scene import Camera, Environment
from .surfels import Surfels, camera_rays
from .trace import Tracer


def spread(values: np.ndarray, surfels: Surfels, resolution: tuple[int, int]) -> np.ndarray:
    """Values of surfels as an image, zero where there is none: (n, c), (width, height) -> (h, w, c) float32."""
    w, h = resolution
    image = np.zeros((h * w, values.shape[-1]), np.float32)
    image[surfels.place] = values
    return image.reshape(h, w, -1)


def smoothed(
    irradiance: np.ndarray,
    surfels: Surfels,
    resolution: tuple[int, int],
    passes: int,
    tracer: Tracer | None = None,
) -> Iterator[float]:
    """Irradiance of an image's surfels, filtered along surfaces: (n, c) -> (n, c).

    tracer: finds the walls that the filter must not cross in a lightmap; what one camera sees needs none.
    A generator of progress; returns the values.
    """
    image, position, normal = (spread(a, surfels, resolution) for a in (irradiance, surfels.position, surfels.normal))
    walls = None if tracer is None else walls_between(tracer, position, normal)
    image = yield from smooth(image, position, normal, passes, walls)
    return image.reshape(-1, irradiance.shape[-1])[surfels.place]


def by_pixel(
    values: np.ndarray, weight: np.ndarray, surfels: Surfels, resolution: tuple[int, int], subpixels: int
) -> np.ndarray:
    """Weighed means of each pixel's surfels, zero where there is none: (n, c) and (n, c or 1) -> (h, w, c) float32.

    resolution: (width, height) in subpixels; `subpixels`: of a pixel along each axis.
    """
    w, h = resolution[0] // subpixels, resolution[1] // subpixels

    def total(a: np.ndarray) -> np.ndarray:
        return spread(a, surfels, resolution).reshape(h, subpixels, w, subpixels, -1).sum((1, 3))

    light, whole = total(weight * values), total(weight)
    return np.divide(light, whole, out=np.zeros_like(light), where=whole > 0)


def of_pixels(image: np.ndarray, surfels: Surfels, subpixels: int) -> np.ndarray:
    """What an image (h, w, c) has where surfels of subpixels are: (n, c)."""
    row, column = np.divmod(surfels.place, image.shape[1] * subpixels)
    return image[row // subpixels, column // subpixels]


def camera_layers(
    surfels: Surfels, direct: np.ndarray, indirect: np.ndarray, camera: Camera, environment: Environment, subpixels:
        int,
    transparent: bool,
) -> dict[str, np.ndarray]:  # fmt: skip
    """What a camera sees, in layers named as Blender's passes.

    surfels: of subpixels; direct, indirect: (n, 3) irradiance [W/m²]; transparent: leave the environment out of the
        picture.
    Returns (h, w, c) float32 each. Diffuse light is E/π without colour, as Cycles' passes are: the light of a pixel
    over its colour, so that a pixel on a silhouette weighs its subpixels as Cycles does. Position, normal and depth are
    one subpixel's.
    """
    w, h = camera.resolution
    fine = (w * subpixels, h * subpixels)

    def resolved(values: np.ndarray) -> np.ndarray:
        return spread(values, surfels, fine).reshape(h, subpixels, w, subpixels, -1).mean((1, 3))

    def one(values: np.ndarray) -> np.ndarray:
        return spread(values, surfels, fine)[subpixels // 2 :: subpixels, subpixels // 2 :: subpixels]

    color = resolved(surfels.albedo)
    lit = {
        name: resolved(surfels.albedo * irradiance / np.pi)
        for name, irradiance in (("Direct", direct), ("Indirect", indirect))
    }
    coverage = resolved(np.ones((len(surfels), 1), np.float32))
    combined = lit["Direct"] + lit["Indirect"] + resolved(surfels.emission)
    alpha = coverage
    if not transparent:
        _, direction = camera_rays(camera, subpixels)
        sky = beyond.radiance(environment, direction).copy()
        sky[surfels.place] = 0
        combined = combined + sky.reshape(h, subpixels, w, subpixels, 3).mean((1, 3))
        alpha = np.ones_like(coverage)

    # Where nothing reflects there is no light to speak of.
    without_color = {k: np.divide(v, color, out=np.zeros_like(v), where=color > 0) for k, v in lit.items()}
    depth = ((surfels.position - camera.matrix[:3, 3]) @ -camera.matrix[:3, 2])[:, None].astype(np.float32)
    return {
        "Combined": np.concatenate([combined, alpha], -1),
        "Diffuse Direct": without_color["Direct"],
        "Diffuse Indirect": without_color["Indirect"],
        "Diffuse Color": color,
        "Emission": resolved(surfels.emission),
        "Irradiance": np.pi * (without_color["Direct"] + without_color["Indirect"]),
        "Normal": one(surfels.normal),
        "Position": one(surfels.position),
        # Blender's depth of nothing.
        "Depth": np.where(one(np.ones_like(depth)) > 0, one(depth), np.float32(1e10)),
    }


def with_gloss(
    layers: dict[str, np.ndarray],
    surfels: Surfels,
    direct: np.ndarray,
    indirect: np.ndarray,
    color: np.ndarray,
    subpixels: int,
) -> dict[str, np.ndarray]:
    """The layers of a camera image and what glossy surfaces reflect: layers of its own, added to Combined.

    layers: of `camera_layers`. surfels: the glossy ones. direct, indirect: (n, 3) light over colour. color: (n, 3).
    """
    h, w = layers["Combined"].shape[:2]
    fine = (w * subpixels, h * subpixels)
    whole = spread(color, surfels, fine).reshape(h, subpixels, w, subpixels, 3).mean((1, 3))
    direct, indirect = (by_pixel(light, color, surfels, fine, subpixels) for light in (direct, indirect))
    combined = layers["Combined"].copy()
    combined[..., :3] += whole * (direct + indirect)
    gloss = {"Glossy Direct": direct, "Glossy Indirect": indirect, "Glossy Color": whole}
    return {**layers, "Combined": combined, **gloss}
