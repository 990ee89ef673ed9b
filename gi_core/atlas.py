# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which lightmap an object lies on, where on it, and how large: squares of texels packed into images.

An object's lightmap UVs fill a unit square. On an image it is a square of so many texels at a place of its own, so that
objects that share a mesh, and with it the UVs, still have each their own light.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

# Sides of images [texels].
LEAST, MOST = 4, 16384

# Share of an image that objects' squares fill, before it is known.
_PACKED = 0.85

# Steps in which the density is found that just fits: half a thousandth of it.
_STEPS = 11


@dataclass(frozen=True)
class Asked:
    """An object that asks for a place.

    uv: name of its UV map. area: of its surface [m²]; filled: of its UVs, both float. factor: of its texel density.
    low, high: corners of its UVs' bounding box in the unit square, (2,) each.
    """

    name: str
    uv: str
    area: float
    filled: float
    low: Sequence[float] = (0.0, 0.0)
    high: Sequence[float] = (1.0, 1.0)
    factor: float = 1.0

    def side(self, density: float) -> int:
        """Of its square [texels] at a density [texels per metre]."""
        wanted = density * self.factor * math.sqrt(self.area / self.filled) if self.filled > 0 else 0
        return int(min(max(LEAST, math.ceil(wanted)), MOST))


@dataclass(frozen=True)
class Place:
    """Where an object lies on an image: its UV (u, v) is the texel (x + side · u, y + side · v)."""

    name: str
    uv: str
    x: int
    y: int
    side: int

    def on(self, uv: np.ndarray, width: int, height: int) -> np.ndarray:
        """The object's UVs as those of the image, (..., 2) float64."""
        out = uv.astype(np.float64)
        out *= self.side
        out += self.x, self.y
        out /= width, height
        return out


@dataclass(frozen=True)
class Page:
    """A lightmap image and the objects on it."""

    name: str
    width: int
    height: int
    places: tuple[Place, ...]

    def coarser(self, step: int) -> "Page":
        """The page with texels `step` times as long; objects begin within texels where they must."""
        places = tuple(replace(p, x=p.x / step, y=p.y / step, side=p.side / step) for p in self.places)
        return replace(self, width=-(-self.width // step), height=-(-self.height // step), places=places)


def single(asked: Asked, resolution: int, density: float) -> Page:
    """A lightmap for one object: so many texels square, or as many as the density asks for."""
    if density:
        # Drivers and compression like sides that four divides.
        side = min(-(-asked.side(density) // 4) * 4, MOST)
    else:
        side = int(min(max(LEAST, round(resolution * asked.factor)), MOST))
    return Page(asked.name, side, side, (Place(asked.name, asked.uv, 0, 0, side),))


def together(name: str, asked: Sequence[Asked], resolution: int, density: float, padding: int) -> list[Page]:
    """Objects on images of resolution² texels: on one, as densely as it holds them, or at a density on several.

    padding: texels that stay free around each object.
    Raises ValueError where an object does not fit at all.
    """
    if density:
        sides = [a.side(density) for a in asked]
        pages, left = [], list(range(len(asked)))
        while left:
            here = _packed([asked[i] for i in left], [sides[i] for i in left], resolution, padding)
            done = [i for i, corner in zip(left, here) if corner is not None]
            if not done:
                a = asked[left[0]]
                raise ValueError(
                    f"'{a.name}' needs {sides[left[0]]}² texels at {density:g} texels per metre and the lightmap has "
                    f"{resolution}²: raise the resolution, or lower the density or the object's factor"
                )
            places = tuple(
                Place(asked[i].name, asked[i].uv, *corner, sides[i]) for i, corner in zip(left, here) if corner
            )
            pages.append(Page(name if not pages else f"{name} {len(pages) + 1}", resolution, resolution, places))
            left = [i for i in left if i not in done]
        return pages

    low, high = 0.0, 4 * _guess(asked, resolution)
    best = None
    for step in range(_STEPS + 8):
        density = (low + high) / 2 if step else high / 4
        sides = [a.side(density) for a in asked]
        corners = _packed(asked, sides, resolution, padding)
        if all(corner is not None for corner in corners):
            low, best = density, (sides, corners)
            if step >= _STEPS:
                break
        else:
            high = density
    if best is None:
        raise ValueError(f"{len(asked)} objects do not fit on a lightmap of {resolution}² texels: raise the resolution")
    places = tuple(Place(a.name, a.uv, *corner, side) for a, side, corner in zip(asked, *best))
    return [Page(name, resolution, resolution, places)]


def expected_sides(
    areas: np.ndarray, filled: np.ndarray, factors: np.ndarray, resolution: int, density: float
) -> np.ndarray:
    """About the sides of squares [texels]: (n,) areas [m²], (n,) of their UVs, (n,) factors, to (n,) float64.

    resolution: of an image that they are on together.
    """
    asked = [Asked("", "", float(a), float(f), factor=float(k)) for a, f, k in zip(areas, filled, factors)]
    density = density or _guess(asked, resolution)
    return np.array([a.side(density) for a in asked], np.float64)


def _guess(asked: Sequence[Asked], resolution: int) -> float:
    """Density [texels per metre] at which objects about fill an image."""
    whole = sum(a.factor**2 * a.area / max(a.filled, 1e-9) for a in asked)
    return resolution * math.sqrt(_PACKED / whole) if whole > 0 else 1.0


def _packed(asked: Sequence[Asked], sides: list[int], resolution: int, padding: int) -> list[tuple[int, int] | None]:
    """Corners of squares on an image, None for those that have no room; what their UVs leave free is shared."""
    low = [np.floor(np.multiply(a.low, s)).astype(int) - padding for a, s in zip(asked, sides)]
    high = [np.ceil(np.multiply(a.high, s)).astype(int) + padding for a, s in zip(asked, sides)]
    corners = pack([tuple(map(int, h - b)) for h, b in zip(high, low)], resolution)
    return [corner and (corner[0] - int(b[0]), corner[1] - int(b[1])) for corner, b in zip(corners, low)]


def pack(sizes: Sequence[tuple[int, int]], side: int) -> list[tuple[int, int] | None]:
    """Lower left corners of rectangles (width, height) in a square, None for those that have no room.

    The skyline of what is placed so far (Jylänki 2010, "A thousand ways to pack the bin", SKYLINE-BL): tall ones first,
    each where its top comes lowest.
    """
    corners: list[tuple[int, int] | None] = [None] * len(sizes)
    skyline = [(0, 0, side)]  # (x, height, width), from left to right
    for k in sorted(range(len(sizes)), key=lambda k: (-sizes[k][1], -sizes[k][0], k)):
        width, height = sizes[k]
        best = None
        for i, (x, _, _) in enumerate(skyline):
            if x + width > side:
                break
            y, reach, j = 0, 0, i
            while reach < width:
                y, reach = max(y, skyline[j][1]), reach + skyline[j][2]
                j += 1
            if y + height <= side and (best is None or y < best[1]):
                best = x, y
        if best is None:
            continue
        corners[k] = best
        skyline = _raised(skyline, best[0], best[1] + height, width)
    return corners


def _raised(skyline: list[tuple[int, int, int]], x: int, height: int, width: int) -> list[tuple[int, int, int]]:
    """The skyline with [x, x + width) at a height."""
    out = []
    for left, level, extent in skyline:
        right = left + extent
        if left < x:
            out.append((left, level, min(right, x) - left))
        if left <= x < right:
            out.append((x, height, width))
        if right > x + width:
            begin = max(left, x + width)
            out.append((begin, level, right - begin))
    return out
