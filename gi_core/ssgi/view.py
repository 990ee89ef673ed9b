# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a camera found, and that light at other points: a finer picture's pixels, texels, vertices."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from .. import tiles
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
    passes: how many there were.
    """

    buffer: GBuffer
    levels: tuple[np.ndarray, ...]
    filtered: np.ndarray
    count: np.ndarray
    picture: np.ndarray
    full: GBuffer
    passes: int

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


def seen(views: list[View], surfels: Surfels) -> Iterator[float]:
    """Irradiance of reflected light at points, from the cameras that see them.

    A generator of progress; returns (n, 3) float32 [W/m²], and (n,) float32 coverage, 0…1: how surely a camera saw the
    point. What none saw gets what the nearest pixels have, if it is on a screen at all.
    """
    total, weights = np.zeros((len(surfels), 3), np.float32), np.zeros(len(surfels), np.float32)
    coverage = np.zeros(len(surfels), np.float32)

    def tile(part: slice):
        here = surfels[part]
        for view in views:
            radiance, share = looked_up(view.buffer, view.radiance, here.position, here.normal)
            weight = np.maximum(share, np.float32(1e-6))
            total[part] += weight[:, None] * radiance
            weights[part] += weight
            coverage[part] = np.maximum(coverage[part], share)

    yield from tiles.run(tile, tiles.slices(len(surfels), _POINTS))
    return total * (np.float32(np.pi) / np.maximum(weights, np.float32(1e-20)))[:, None], coverage


def upsampled(buffer: GBuffer, value: np.ndarray, full: GBuffer) -> np.ndarray:
    """An image at the resolution of tracing, (h, w, 3), at every pixel: (H, W, 3)."""
    if buffer.screen.step == full.screen.step:
        return value
    out = np.zeros_like(full.position)
    place = np.flatnonzero(full.surface)
    position, normal = full.position.reshape(-1, 3), full.normal.reshape(-1, 3)
    for part in tiles.slices(len(place), _POINTS):
        here = place[part]
        out.reshape(-1, 3)[here], _ = looked_up(buffer, value, position[here], normal[here])
    return out


def looked_up(buffer: GBuffer, value: np.ndarray, position: np.ndarray, normal: np.ndarray):
    """An image's values (h, w, 3) at points (n, 3): (n, 3), and how surely it shows them (n,), 0…1."""
    at, (h, w) = buffer.screen.project(position), buffer.depth.shape
    half = 0.5 / buffer.screen.step
    with np.errstate(invalid="ignore"):
        on_screen = (at[:, 0] >= -half) & (at[:, 0] <= w - 1 + half) & (at[:, 1] >= -half) & (at[:, 1] <= h - 1 + half)
    on_screen &= at[:, 2] > 0
    at = np.where(on_screen[:, None], at, 1)
    z = at[:, 2]
    found, share = bilateral_upsample(
        at[:, :2], z, position, normal, value, buffer.depth, buffer.position, buffer.normal,
        np.float32(buffer.screen.camera.clip[1]), METRE * z,
    )  # fmt: skip
    return found * on_screen[:, None], share * on_screen
