# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame starts from: the G-buffer of a camera, the light that its surfaces send without bounces, and where each
pixel's surface was in an earlier frame."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from .. import raster, surfels, tiles
from ..device import NUMPY, Device
from ..direct import surroundings
from ..geometry import Geometry
from ..images import spread
from ..kernels.depth_pyramid import depth_pyramid
from ..kernels.march_cells import march_cells
from ..kernels.pixel_planes import pixel_planes
from ..sampling import Samples
from ..shadow_maps import lamps
from ..surfels import Surfels
from ..trace import Tracer
from ..vectors import dot, pick, put
from .screen import Screen

# Levels of the depth pyramid; HDRP marches up to the seventh.
LEVELS = 7

# Pixels worked on at once by a thread.
_PIXELS = 1 << 15

# Lengths in HDRP are for what is some metres away. Here they grow with the distance: its metre is this share of it.
METRE = np.float32(1 / 5)


@dataclass(frozen=True)
class GBuffer:
    """What a camera sees at its pixels' centres, row 0 at the bottom.

    screen: whose. depth: (h, w) float32 along the view axis [m], inf where no surface is; all else is 0 there.
    position, normal, smooth, face, albedo, emission: (h, w, 3) float32, as in Surfels; albedo is all that is reflected.
    triangle: (h, w) int32, −1 where no surface is, and weights: (h, w, 3) float32: the point on the mesh.
    geometry: what it was seen in.
    """

    screen: Screen
    depth: np.ndarray
    position: np.ndarray
    normal: np.ndarray
    smooth: np.ndarray
    face: np.ndarray
    albedo: np.ndarray
    emission: np.ndarray
    triangle: np.ndarray
    weights: np.ndarray
    geometry: Geometry

    def __getitem__(self, step: int) -> "GBuffer":
        """The pixels of every step-th row and column."""
        if step == 1:
            return self
        images = (self.depth, self.position, self.normal, self.smooth, self.face, self.albedo, self.emission,
                  self.triangle, self.weights)  # fmt: skip
        screen = Screen(self.screen.camera, self.screen.step * step)
        return GBuffer(screen, *(np.ascontiguousarray(i[::step, ::step]) for i in images), self.geometry)

    def on(self, device: Device) -> "GBuffer":
        """The buffer with what kernels read of it where they run."""
        images = {"depth": 1, "position": 3, "normal": 3, "face": 3, "albedo": 3}
        images |= {"smooth": 3} if self.is_bumpy else {}
        return replace(self, **{name: device.array(getattr(self, name), c) for name, c in images.items()})

    @property
    def surface(self) -> np.ndarray:
        """(h, w) bool, where a surface is."""
        return self.triangle >= 0

    def surfels(self) -> Surfels:
        """The points that are seen; `place` counts this buffer's pixels along rows."""
        place = np.flatnonzero(self.surface)
        images = (self.position, self.normal, self.face, self.albedo, self.emission)
        points = Surfels(*(pick(i.reshape(-1, 3), place) for i in images), place)
        return replace(points, smooth=pick(self.smooth.reshape(-1, 3), place)) if self.is_bumpy else points

    @property
    def is_bumpy(self) -> bool:
        """Whether normals may differ from meshes'."""
        return self.geometry.has_normal_maps


def g_buffer(tracer: Tracer, screen: Screen) -> Iterator[float]:
    """What the camera sees. A generator of progress; returns a GBuffer."""
    h, w = screen.shape
    camera = screen.camera
    origins, directions = surfels.camera_rays(camera)
    depth, triangle = np.full(h * w, np.inf, np.float32), np.full(h * w, -1, np.int32)
    images = np.zeros((7, h * w, 3), np.float32)
    drawn = yield from tracer.drawn(raster.of_camera(camera), origins, directions)

    def tile(part: slice):
        hits = tracer.closest(origins[part], directions[part], solid=drawn and drawn[part])
        hit = np.flatnonzero(hits.triangle >= 0)
        rows = hit + part.start
        weights = pick(hits.weights, hit)
        seen = surfels.at(tracer.geometry, hits.triangle[hit], weights, rows, -pick(directions, rows), reflecting=True)
        z = (seen.position - screen.eye) @ screen.ahead
        near = z <= camera.clip[1]
        rows = rows[near]
        depth[rows], triangle[rows] = z[near], hits.triangle[hit[near]]
        values = (seen.position, seen.normal, seen.smooth, seen.face, seen.albedo, seen.emission, weights)
        for image, value in zip(images, values):
            put(image, rows, pick(value, near))

    yield from tiles.run(tile, tiles.slices(h * w, surfels.TILE))
    *images, weights = (i.reshape(h, w, 3) for i in images)
    return GBuffer(screen, depth.reshape(h, w), *images, triangle.reshape(h, w), weights, tracer.geometry)


def direct_light(
    tracer: Tracer, buffer: GBuffer, light_samples: int, samples: int, seed: int, shadow_map_resolution: int = 0
) -> Iterator[float]:
    """Irradiance of lamps, emitting surfaces and the sky. A generator of progress; returns (h, w, 3) float32 [W/m²].

    What a surface emits itself is not in it: that reaches others as direct light, of which it is a source here, so a
    hit sends on only what it reflects.
    """
    points = buffer.surfels()
    irradiance = yield from lamps(tracer, points, light_samples, seed, shadow_map_resolution)
    irradiance += yield from surroundings(tracer, points, Samples(samples), seed)
    return spread(irradiance, points.place, buffer.screen.shape)


@dataclass(frozen=True)
class DepthMap:
    """What rays are marched through, where kernels run.

    cells: of `march_cells`, table: of `depth_pyramid`.
    """

    cells: np.ndarray
    table: np.ndarray


def depth_map(buffer: GBuffer, device: Device = NUMPY) -> Iterator[float]:
    """The depth of a full-resolution buffer, ready for marching. A generator of progress; returns a DepthMap.

    buffer: where kernels run.
    """
    h, w = buffer.screen.shape
    depth, position, face = buffer.depth.reshape(-1), buffer.position.reshape(-1, 3), buffer.face.reshape(-1, 3)

    def tile(part: slice):
        return device.run(pixel_planes, depth[part], position[part], face[part], buffer.screen)

    depth, slope, nearest = yield from device.each(tile, h * w, _PIXELS)
    pyramid, table = device.run(depth_pyramid, nearest.reshape(h, w), LEVELS)
    return DepthMap(device.run(march_cells, depth.reshape(h, w), slope.reshape(h, w, 2), pyramid), table)


def before(buffer: GBuffer, earlier: GBuffer) -> tuple[np.ndarray, np.ndarray]:
    """Where each pixel's surface was in an earlier frame.

    Returns (h · w, 3) float32: x and y on the earlier screen and depth there, and (h · w, 3) float32: in its world [m];
    NaN where the surface was nowhere.
    """
    position = buffer.position.reshape(-1, 3).astype(np.float32)
    surface = np.flatnonzero(buffer.surface)
    where = np.full_like(position, np.nan)
    if earlier.geometry is buffer.geometry:
        where[surface] = position[surface]
    else:
        triangle = matching(buffer.geometry, earlier.geometry)[buffer.triangle.ravel()[surface]]
        known = triangle >= 0
        surface = surface[known]
        where[surface] = earlier.geometry.position(triangle[known], buffer.weights.reshape(-1, 3)[surface])
    at = np.full_like(where, np.nan)
    at[surface] = earlier.screen.project(where[surface])
    return at, where


def matching(now: Geometry, then: Geometry) -> np.ndarray:
    """The triangles of one frame in another's geometry: (t,) int64, −1 where there is none.

    An instance is the same where name, count among those of that name, and number of triangles are.
    """
    places: dict[tuple, int] = {}
    out = np.full(len(now.triangles), -1, np.int64)

    def keys(geometry: Geometry):
        seen: dict[str, int] = {}
        for k, instance in enumerate(geometry.scene.instances):
            nth = seen[instance.name] = seen.get(instance.name, -1) + 1
            first, stop = geometry.first[k : k + 2]
            yield (instance.name, nth, int(stop - first)), first, stop

    for key, first, _ in keys(then):
        places[key] = first
    for key, first, stop in keys(now):
        if key in places:
            out[first:stop] = places[key] + np.arange(stop - first)
    return out


def slant(buffer: GBuffer) -> np.ndarray:
    """|n·v| of each pixel: (h · w,) float32."""
    view = buffer.screen.towards(buffer.position.reshape(-1, 3))
    return np.abs(dot(buffer.smooth.reshape(-1, 3), view))
