# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How a map looks out of its light: which ray each texel stands for, how much flux it carries, and back from points to
texels.

A lamp's maps share `map_resolution`² texels: a sun has an orthographic map fitted to the scene, or where the scene is
much larger than what is to be lit a few, one around the other; a spot has one perspective map, a point light (and a
very wide spot) six cube faces, an area light a hemisphere from each of 4 × 4 parts of its surface.
Soft lamps start each texel's ray somewhere on the lamp, so that indirect shadows are as soft as they should be.
"""

from dataclasses import dataclass, fields

import numpy as np

from ..lights import axes, points_on, spot_gain, spread_gain
from ..raster import Grid
from ..sampling import cone, disk, frame, hash01
from ..scene import Light
from ..vectors import length, normalize

_WIDEST_PERSPECTIVE = np.radians(130)
_AREA_PARTS = 4

# Volume that a view's axes span at least, to be drawn.
_FLATTEST = 1e-3

# A cascade's side over that of the next finer one.
_CASCADE_RATIO = 4.0
_MOST_CASCADES = 4


@dataclass(frozen=True)
class View:
    """A map's projection.

    kind: "ORTHOGRAPHIC", "PERSPECTIVE" or "HEMISPHERE".
    origin: (3,) centre of projection (the near plane's centre of an orthographic view).
    x, y, forward: (3,) unit axes of the view in the world; texel columns run along x, rows along y.
    extent: half width and height [m], their tangents (perspective), or the radius of the disk of directions twice
        (hemisphere).
    resolution: texels along each side.
    light: the lamp.
    part: lower corner and size of the area light's part that the view looks out of, in 0…1 along both axes.
    hole: left, right, bottom, top of what a finer cascade covers, in 0…1 of the map; no flux leaves from there.
    """

    kind: str
    origin: np.ndarray
    x: np.ndarray
    y: np.ndarray
    forward: np.ndarray
    extent: tuple[float, float]
    resolution: int
    light: Light
    part: tuple[float, float, float] = (0.0, 0.0, 1.0)
    hole: tuple[float, float, float, float] | None = None

    @property
    def grid(self) -> Grid | None:
        """The texels as pixels of a picture; None for a hemisphere, in which straight edges are curved."""
        axes = np.stack([self.x, self.y, self.forward])
        if self.kind == "HEMISPHERE" or abs(np.linalg.det(axes)) < _FLATTEST:
            return None
        wide, high = self.extent
        size = self.resolution, self.resolution
        slant = np.tan(self.light.angle / 2) if self.kind == "ORTHOGRAPHIC" else 0.0
        return Grid(self.kind, self.origin, axes, (-wide, wide, -high, high), size, self.light.radius, slant, False)


@dataclass(frozen=True)
class Rays:
    """The rays of a map's texels.

    origin, direction: (n, 3) float32.
    flux: (n, 3) radiant flux that each carries [W].
    spread: (n,) area of the ray's cross section at its start [m²], and solid_angle (n,) [sr] by which it widens.
    """

    origin: np.ndarray
    direction: np.ndarray
    flux: np.ndarray
    spread: np.ndarray
    solid_angle: np.ndarray

    @staticmethod
    def concatenate(parts: "list[Rays]") -> "Rays":
        return Rays(*(np.concatenate([getattr(p, f.name) for p in parts]) for f in fields(Rays)))


def views(light: Light, bounds: np.ndarray, resolution: int, focus: np.ndarray | None = None) -> list[View]:
    """The maps of a lamp.

    bounds: (2, 3) corners of all that may be lit. focus: (2, 3) corners of what matters most, for the cascades of suns.
    resolution: texels along the side of one map for all.
    """
    x, y = (normalize(light.matrix[:3, i]) for i in (0, 1))
    forward, position = axes(light)[2], light.matrix[:3, 3]
    if light.kind == "SUN":
        return _cascades(light, bounds, bounds if focus is None else focus, resolution)

    if light.kind == "AREA":
        # Right-handed whatever the lamp's own scale mirrors.
        y = np.cross(forward, x) * -1
        radius = np.sin(min(max(light.spread, np.radians(1)), np.pi) / 2)
        size = 1 / _AREA_PARTS
        return [
            View("HEMISPHERE", position, x, y, forward, (radius, radius), max(1, resolution // _AREA_PARTS), light,
                 (i * size, j * size, size))
            for j in range(_AREA_PARTS)
            for i in range(_AREA_PARTS)
        ]  # fmt: skip

    if light.kind == "SPOT":
        scale = np.linalg.norm(light.matrix[:3, :3], axis=0)
        extent = tuple(np.tan(min(light.spot_angle, _WIDEST_PERSPECTIVE) / 2) * scale[:2] / scale[2])
        if light.spot_angle <= _WIDEST_PERSPECTIVE and max(extent) <= np.tan(_WIDEST_PERSPECTIVE / 2):
            return [View("PERSPECTIVE", position, x, y, forward, extent, resolution, light)]

    side = max(1, round(resolution / np.sqrt(6)))
    faces = []
    for axis in range(3):
        for sign in (1, -1):
            ahead = np.zeros(3)
            ahead[axis] = sign
            right, up = frame(ahead)
            faces.append(View("PERSPECTIVE", position, right, up, ahead, (1.0, 1.0), side, light))
    return faces


def _cascades(light: Light, bounds: np.ndarray, focus: np.ndarray, resolution: int) -> list[View]:
    """Orthographic maps of a sun, the finest around the focus, each of the others several times as wide, the last over
    all."""
    forward = axes(light)[2]
    x, y = frame(forward)
    low, high = _extent(bounds, x, y, forward)
    # A sun with an angle sends slanted rays: room around the scene for those that come in from the side.
    margin = (high[2] - low[2]) * np.tan(light.angle / 2) + 1e-4 * np.max(high - low)
    whole = np.stack([low[:2] - margin, high[:2] + margin])
    near = np.stack([side[:2] for side in _extent(focus, x, y, forward)])
    half = np.maximum(np.ptp(near, 0) / 2 + margin, np.ptp(whole, 0) / 2 * _CASCADE_RATIO ** (1 - _MOST_CASCADES))
    center = np.clip(near.mean(0), whole[0] + half, whole[1] - half)
    rectangles = [np.stack([center - half, center + half])]
    while np.any(2 * np.ptp(rectangles[-1], 0) < np.ptp(whole, 0)):
        half = np.ptp(rectangles[-1], 0) * _CASCADE_RATIO / 2
        rectangles.append(np.clip([center - half, center + half], *whole))
    # What is half the whole is the whole: another map would gain little.
    rectangles[-1] = whole

    texels = max(1, round(resolution / np.sqrt(len(rectangles))))
    cascades, inner = [], None
    for rectangle in rectangles:
        center, extent = rectangle.mean(0), np.ptp(rectangle, 0) / 2
        origin = center[0] * x + center[1] * y + (low[2] - margin) * forward
        hole = None
        if inner is not None:
            left_bottom, right_top = (inner - rectangle[0]) / np.ptp(rectangle, 0)
            hole = (left_bottom[0], right_top[0], left_bottom[1], right_top[1])
        cascades.append(View("ORTHOGRAPHIC", origin, x, y, forward, tuple(extent), texels, light, hole=hole))
        inner = rectangle
    return cascades


def _extent(bounds: np.ndarray, x: np.ndarray, y: np.ndarray, forward: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lowest and highest coordinates of a box along three axes: (3,) twice."""
    corners = np.array(np.meshgrid(*np.asarray(bounds, np.float64).T)).reshape(3, -1).T
    local = corners @ np.stack([x, y, forward], -1)
    return local.min(0), local.max(0)


def texel_rays(view: View, seed: int) -> Rays:
    """One ray for each texel, through a random point of it; row by row from the bottom."""
    n = view.resolution
    index = np.arange(n * n, dtype=np.uint32)
    random = [hash01(index, seed * 8 + k) for k in range(4)]
    st = np.stack([(index % n + random[0]) / n, (index // n + random[1]) / n], -1)
    return rays(view, st, np.stack(random[2:], -1), np.full(n * n, 1 / n**2))


def rays(view: View, st: np.ndarray, lens: np.ndarray, share: np.ndarray) -> Rays:
    """Rays through points of a map.

    st: (n, 2) points, 0…1; lens: (n, 2) where on a soft lamp each starts, 0…1; share: (n,) of the map that each stands
        for.
    """
    light, n = view.light, len(st)
    plane = (2 * st - 1) * view.extent
    basis = np.stack([view.x, view.y, view.forward])

    if view.kind == "ORTHOGRAPHIC":
        section = 4 * view.extent[0] * view.extent[1] * share
        origin = view.origin + plane @ basis[:2]
        cos_rim = np.cos(light.angle / 2)
        direction = cone(np.broadcast_to(view.forward, origin.shape), np.full(n, 1 - cos_rim), lens)
        # Slanted rays of a sun with an angle pass the map's plane with their cosine; the mean is one.
        gain = 2 * (direction @ view.forward) / (1 + cos_rim)
        if view.hole is not None:
            left, right, bottom, top = view.hole
            s, t = st.T
            gain = np.where((s > left) & (s < right) & (t > bottom) & (t < top), 0, gain)
        return _rays(origin, direction, section * gain, light.power, section, np.zeros(n))

    if view.kind == "HEMISPHERE":
        # Even on the disk is cosine-distributed over the hemisphere: each texel carries the same flux (Malley's
        # method).
        on_disk = disk(st) * view.extent[0]
        height = np.sqrt(np.maximum(1 - np.sum(on_disk**2, -1), 1e-12))
        direction = np.concatenate([on_disk, height[:, None]], -1) @ basis
        i, j, size = view.part
        origin = points_on(light, np.array([i, j], np.float32) + size * lens)
        share = share * (view.extent[0] / _AREA_PARTS) ** 2
        gain = share * spread_gain(light, height)
        return _rays(origin, direction, gain, light.power, np.zeros(n), np.pi * share / height)

    tangent = np.concatenate([plane, np.ones((n, 1))], -1)
    cosine = 1 / length(tangent)
    direction = (tangent * cosine[:, None]) @ basis
    solid_angle = 4 * view.extent[0] * view.extent[1] * share * cosine**3
    origin = np.broadcast_to(view.origin, direction.shape)
    if light.radius > 0:
        # The sphere's disk as the ray's direction sees it; on the sphere's skin unless the lamp is a disk itself.
        local = disk(lens)
        x, y = frame(direction)
        lift = 0 if light.soft_falloff else np.sqrt(np.maximum(1 - np.sum(local**2, -1, keepdims=True), 0))
        origin = origin + light.radius * (local[:, :1] * x + local[:, 1:] * y + lift * direction)
    intensity = light.power / (4 * np.pi)
    return _rays(origin, direction, solid_angle * spot_gain(light, direction), intensity, np.zeros(n), solid_angle)


def _rays(origin, direction, gain, color, spread, solid_angle) -> Rays:
    flux = gain[:, None] * np.asarray(color)
    return Rays(*(np.asarray(a, np.float32) for a in (origin, direction, flux, spread, solid_angle)))


def project(view: View, points: np.ndarray) -> np.ndarray:
    """Where points lie in a map: (n, 3) -> (n, 2) float32 in units of the map's side, 0…1 inside; NaN behind the
    view."""
    local = (points - view.origin) @ np.stack([view.x, view.y, view.forward], -1)
    if view.kind == "ORTHOGRAPHIC":
        plane = local[:, :2] / view.extent
    elif view.kind == "PERSPECTIVE":
        with np.errstate(divide="ignore", invalid="ignore"):
            plane = np.where(local[:, 2:] > 0, local[:, :2] / local[:, 2:] / view.extent, np.nan)
    else:
        unit = normalize(local)
        plane = np.where(unit[:, 2:] > 0, _square(unit[:, :2] / view.extent[0]), np.nan)
    return ((plane + 1) / 2).astype(np.float32)


def _square(d: np.ndarray) -> np.ndarray:
    """Unit disk to the square [−1, 1]²: the inverse of `sampling.disk`."""
    r = np.hypot(d[:, 0], d[:, 1])
    phi = np.arctan2(d[:, 1], d[:, 0])
    # Quarter turns: 0 along +x, 1 along +y, 2 along −x, 3 along −y.
    quarter = np.round(phi / (np.pi / 2)).astype(int) % 4
    along = r * np.where(quarter >= 2, -1, 1)
    turn = (phi - np.round(phi / (np.pi / 2)) * (np.pi / 2)) * 4 / np.pi * r
    across = turn * np.where((quarter == 1) | (quarter == 2), -1, 1)
    return np.where((quarter % 2 == 0)[:, None], np.stack([along, across], -1), np.stack([across, along], -1))
