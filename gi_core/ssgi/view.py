# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a camera found, and that light at other points: a finer picture's pixels, texels, vertices."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from ..device import NUMPY, Device
from ..kernels.bilateral_upsample import bilateral_upsample
from ..surfels import Surfels
from .frame import METRE, GBuffer

_POINTS = 1 << 14


@dataclass(frozen=True)
class History:
    """What a pass leaves to the next; images at the resolution of tracing.

    buffer: what was seen. levels: for each bounce (h, w, 3) float32, mean radiance E/π so far. filtered: (h, w, 3) the
        same after the first diffuse filter, of the last bounce. count: (h, w) float32 passes in them.
    picture: (H, W, 3) float32, radiance that surfaces reflect, at full resolution. full: what was seen there.
    passes: how many there were. behind: of those, the last ones that are in neither `filtered` nor `picture`.
    """

    buffer: GBuffer
    levels: tuple[np.ndarray, ...]
    filtered: np.ndarray
    count: np.ndarray
    picture: np.ndarray
    full: GBuffer
    passes: int
    behind: int = 0

    def of(self, device: Device) -> "History":
        """The same, out of the device."""
        levels = tuple(device.numpy(level) for level in self.levels)
        images = {name: device.numpy(getattr(self, name)) for name in ("filtered", "count", "picture")}
        return replace(self, levels=levels, **images)

    @property
    def arrays(self) -> dict[str, np.ndarray]:
        """All but what was seen, which can be looked at again; see `restored`."""
        return {"levels": np.array(self.levels), "filtered": self.filtered, "count": self.count,
                "picture": self.picture, "passes": np.array(self.passes)}  # fmt: skip


@dataclass(frozen=True)
class View:
    """A camera's picture, at the resolution of tracing.

    buffer: what is seen. radiance: (h, w, 3) float32, E/π of reflected light. layers: what each pass found, name ->
        (h, w) or (h, w, 3), empty where that was not asked for. history: for the next picture, None in mode off.
    """

    buffer: GBuffer
    radiance: np.ndarray
    layers: dict[str, np.ndarray]
    history: History | None

    def debug(self, resolution: tuple[int, int]) -> dict[str, np.ndarray]:
        """The layers at a resolution (width, height), for the eye: name -> (height, width) or (height, width, 3)."""
        shown = {}
        for name, layer in self.layers.items():
            for axis, size in enumerate(resolution[::-1]):
                layer = np.repeat(layer, -(-size // layer.shape[axis]), axis).take(range(size), axis)
            shown[name] = layer.astype(np.float32)
        return shown


def seen(views: list[View], surfels: Surfels, device: Device = NUMPY) -> Iterator[float]:
    """Irradiance of reflected light at points, from the cameras that see them.

    A generator of progress; returns (n, 3) float32 [W/m²], and (n,) float32 coverage, 0…1: how surely a camera saw the
    point. What none saw gets what the nearest pixels have, if it is on a screen at all.
    """

    def tile(part: slice):
        here = surfels[part]
        total, weights, coverage = np.zeros((len(here), 3), np.float32), *np.zeros((2, len(here)), np.float32)
        for view in views:
            points = between(view.buffer, here.position, here.normal)
            found = looked_up(view.buffer, view.radiance, points, device)
            radiance, share = map(device.numpy, found)
            weight = np.maximum(share, np.float32(1e-6))
            total += weight[:, None] * radiance
            weights += weight
            coverage = np.maximum(coverage, share)
        return total * (np.float32(np.pi) / np.maximum(weights, np.float32(1e-20)))[:, None], coverage

    return (yield from device.each(tile, len(surfels), _POINTS))


def between(buffer: GBuffer, position: np.ndarray, normal: np.ndarray) -> tuple[np.ndarray, ...]:
    """Points between a buffer's pixels: (n, 3), (n, 3) -> where on its screen (n, 2), NaN for off it; depth (n,);
    position, normal; and what a metre of the source is there (n,) [m]."""
    at, (h, w) = buffer.screen.project(position), buffer.depth.shape
    half = 0.5 / buffer.screen.step
    with np.errstate(invalid="ignore"):
        on_screen = (at[:, 0] >= -half) & (at[:, 0] <= w - 1 + half) & (at[:, 1] >= -half) & (at[:, 1] <= h - 1 + half)
    on_screen &= at[:, 2] > 0
    z = at[:, 2]
    return np.where(on_screen[:, None], at[:, :2], np.float32(np.nan)), z, position, normal, METRE * z


def looked_up(buffer: GBuffer, value: np.ndarray, points: tuple[np.ndarray, ...], device: Device = NUMPY):
    """An image's values (h, w, 3) at points `between` its pixels: (n, 3), and how surely it shows them (n,), 0…1."""
    *where, scale = points
    far = np.float32(buffer.screen.camera.clip[1])
    return device.run(
        bilateral_upsample, *where, value, buffer.depth, buffer.position, buffer.normal, far, scale
    )  # fmt: skip
