# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A camera's screen: where points of the world are on it, and the way back as a plane for each pixel.

Pixels have their edges at whole numbers in `Screen.march` and their centres there elsewhere. Depth is along the view
axis [m]; device depth is −1/depth in perspective and depth itself in parallel projection, linear along rays on the
screen, near is small.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..kernels.diffuse_filter import projected
from ..scene import Camera
from ..vectors import dot, normalize

# A pixel's plane reaches no nearer and no further than this share of its depth.
_SLOPE = np.float32(0.5)


@dataclass(frozen=True)
class Screen:
    """camera: whose. step: pixels of the camera to one of this screen's along each axis; its pixels are those in whose
    lower left corner theirs are, not the blocks' middles."""

    camera: Camera
    step: int = 1

    @cached_property
    def shape(self) -> tuple[int, int]:
        """(h, w)."""
        w, h = self.camera.resolution
        return -(-h // self.step), -(-w // self.step)

    @property
    def parallel(self) -> bool:
        return self.camera.kind != "PERSPECTIVE"

    @property
    def eye(self) -> np.ndarray:
        return self.camera.matrix[:3, 3]

    @property
    def ahead(self) -> np.ndarray:
        return -self.camera.matrix[:3, 2]

    @cached_property
    def axes(self) -> np.ndarray:
        """(3, 3) float64: to the right, up and ahead, unit vectors in rows."""
        return self.camera.matrix[:3, :3].T * [[1], [1], [-1]]

    @cached_property
    def frame(self) -> np.ndarray:
        """(4, 3) float32: the axes and the eye."""
        return np.concatenate([self.axes, self.eye[None]]).astype(np.float32)

    @cached_property
    def pixels_per_unit(self) -> tuple[float, float]:
        """Of the camera, on the plane at depth 1, or in a metre of a parallel one."""
        left, right, bottom, top = self.camera.window
        w, h = self.camera.resolution
        return w / (right - left), h / (top - bottom)

    @cached_property
    def matrix(self) -> np.ndarray:
        """(4, 4) float64, world to x · w, y · w, depth and w; x and y in pixels whose centres are whole numbers."""
        left, _, bottom, _ = self.camera.window
        fx, fy = self.pixels_per_unit
        view = np.eye(4)
        view[:3, :3], view[:3, 3] = self.axes, -self.axes @ self.eye
        over = np.array([0.0, 0, 0, 1]) if self.parallel else view[2]
        x, y = fx * view[0] - (fx * left + 0.5) * over, fy * view[1] - (fy * bottom + 0.5) * over
        return np.stack([x / self.step, y / self.step, view[2], over])

    def project(self, points: np.ndarray) -> np.ndarray:
        """Points on the screen: (n, 3) -> (n, 3) float32: x, y and depth; x and y are NaN behind the camera."""
        at = projected(points, self.matrix)
        if not self.parallel:
            at[at[:, 2] <= 0, :2] = np.nan
        return at

    def towards(self, points: np.ndarray) -> np.ndarray:
        """Unit directions from points to the eye: (n, 3) -> (n, 3) float32."""
        if self.parallel:
            return np.broadcast_to(-self.ahead, points.shape).astype(np.float32)
        return normalize((self.eye - points).astype(np.float32))

    def footprint(self, depth: np.ndarray) -> np.ndarray:
        """Size of this screen's pixels on a surface that faces the camera: (...) [m] -> (...) float32 [m]."""
        size = np.float32(self.step / min(self.pixels_per_unit))
        return np.full_like(depth, size) if self.parallel else depth * size

    def device(self, depth: np.ndarray) -> np.ndarray:
        """Depth [m] to device depth."""
        return depth if self.parallel else -1 / depth

    def back(self, thickness: float) -> float:
        """What device depth is multiplied by for a surface's back."""
        return 1 + thickness if self.parallel else 1 / (1 + thickness)

    def march(self, points: np.ndarray, directions: np.ndarray) -> np.ndarray:
        """Which way the image of a point and its device depth move: (n, 3), (n, 3) -> (n, 3), of any length."""
        local, d = ((a @ self.axes.T.astype(np.float32)) for a in (points - self.eye.astype(np.float32), directions))
        # The derivative of (x/z, y/z, −1/z), times z².
        flat = d[:, :2] if self.parallel else d[:, :2] * local[:, 2:] - local[:, :2] * d[:, 2:]
        return np.concatenate([flat * np.array(self.pixels_per_unit, np.float32), d[:, 2:]], -1)

    def slopes(self, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
        """How device depth changes from pixel to pixel of the camera on planes: (n, 3), (n, 3) -> (n, 2) float32."""
        local, n = ((a @ self.axes.T.astype(np.float32)) for a in (points - self.eye.astype(np.float32), normals))
        # On the plane n · x = k, −1/z is −(n · (x/z, y/z, 1))/k.
        over = n[:, 2] if self.parallel else dot(n, local)
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            slope = -n[:, :2] / over[:, None] / np.array(self.pixels_per_unit, np.float32)
        slope = np.nan_to_num(slope, posinf=1e20, neginf=-1e20)
        steep = np.abs(slope).sum(-1)
        most = _SLOPE * np.abs(self.device(local[:, 2]))
        return (slope * np.minimum(1, most / np.maximum(steep, 1e-30))[:, None]).astype(np.float32)
