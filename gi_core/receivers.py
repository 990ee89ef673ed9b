# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What gets light, as grids of places, and the tiles in which a bake works through them.

A camera image, a lightmap and the vertices of a mesh are all receivers. Large ones are cut into bands of rows, small
ones of equal width are stacked, so that a tile has about as many points as memory is given for and never many fewer
than keep all cores busy. Bands carry rows beyond their own for filters to look at: what comes out does not depend on
how it was cut.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from . import directional, raster, surfels, tiles
from .atlas import Page
from .corners import Corners
from .geometry import Geometry
from .scene import Camera
from .surfels import Surfels
from .trace import Hits, Tracer

# Memory that a point takes while its light is worked out, all its arrays together [bytes]; measured.
POINT_BYTES = 300


# What lies at the places of some rows, and whether the surface covers each place's centre, (n,) bool.
Points = Callable[[slice], tuple[Surfels, np.ndarray]]


@dataclass(frozen=True)
class Receiver:
    """A grid of places that get light.

    name: of the object; "" for the camera.
    width, height: of the grid.
    points: what lies at the places of some rows; the Surfels' `place` is row · width + column.
    drawn: makes `points` for rows that are about to be asked for, on the main thread; a generator of progress.
    subpixels: of a pixel along each axis.
    is_image: places that are neighbours in the grid are neighbours on the surface.
    streams: of random numbers, of each place; None for each its own. (width · height,) int64.
    """

    name: str
    width: int
    height: int
    points: Points
    subpixels: int = 1
    is_image: bool = True
    streams: np.ndarray | None = None
    drawn: Callable[[slice], Iterator[float]] | None = None

    @property
    def shape(self) -> tuple[int, ...]:
        """Of the results: (h, w) pixels, or (3 t,) corners of triangles."""
        return (self.height // self.subpixels, self.width // self.subpixels) if self.is_image else (self.height,)


def of_camera(tracer: Tracer, camera: Camera, subpixels: int) -> Receiver:
    """The image of a camera."""
    width, height = (n * subpixels for n in camera.resolution)

    def points(rows: slice, solid: Hits | None = None):
        seen = surfels.from_camera(tracer, camera, subpixels, rows, solid)
        return seen, np.ones(len(seen), bool)

    def drawn(rows: slice):
        if tracer.raster is None:
            return points
        grid = raster.of_camera(camera, subpixels, rows)
        solid = yield from tracer.drawn(grid, *surfels.camera_rays(camera, subpixels, rows))
        if solid is None:
            return points
        return lambda part: points(part, solid[(part.start - rows.start) * width : (part.stop - rows.start) * width])

    return Receiver("", width, height, points, subpixels, drawn=drawn)


def of_page(geometry: Geometry, page: Page, side: int = 0) -> Receiver:
    """A lightmap of the objects that lie on it; side: which of the normals of a directional one."""
    size = page.width, page.height

    def points(rows: slice):
        none = surfels.at(geometry, *(np.zeros(s, int) for s in ((0,), (0, 3), (0,))))
        parts = [(none, np.zeros(0, bool))]
        for place in page.places:
            if place.y < rows.stop and place.y + place.side > rows.start:
                parts.append(surfels.from_texels(geometry, place.name, place.uv, size, rows, place))
        here, centred = zip(*parts)
        surface = Surfels.concatenate(list(here))
        if side:
            normal = directional.tilted(surface.normal, side)
            surface = replace(surface, normal=normal, smooth=normal)
        return surface, np.concatenate(centred)

    return Receiver(directional.named(page.name, side), *size, points)


def of_corners(geometry: Geometry, name: str, alike: bool = False) -> Receiver:
    """The corners of an object's triangles.

    alike: those at one point of the surface have the same noise, so that none of it shows between faces.
    """
    streams = Corners.of(geometry, name).point if alike else None

    def points(rows: slice):
        here = surfels.from_corners(geometry, name, slice(rows.start // 3, -(-rows.stop // 3)))
        here = here[(here.place >= rows.start) & (here.place < rows.stop)]
        return here, np.ones(len(here), bool)

    mesh, _ = geometry.mesh_of(name)
    return Receiver(name, 1, 3 * len(mesh.triangles), points, is_image=False, streams=streams)


@dataclass(frozen=True)
class Band:
    """Some rows of a receiver.

    rows: all that are worked on. kept: those of them that results are taken from.
    """

    receiver: Receiver
    rows: slice
    kept: slice

    @property
    def height(self) -> int:
        return self.rows.stop - self.rows.start


@dataclass(frozen=True)
class Tile:
    """Bands that are worked on together, one above the other in one image of their common width."""

    bands: tuple[Band, ...]

    @property
    def shape(self) -> tuple[int, int]:
        """(height, width) of the image."""
        return sum(band.height for band in self.bands), self.bands[0].receiver.width

    def points(self) -> Iterator[float]:
        """Everything in the tile's bands that gets light.

        A generator of progress; returns the Surfels, the place of each in the tile's image (n,) int64, and whether the
        surface covers the centre of it (n,) bool.
        """
        parts, base = [], 0
        for band in self.bands:
            width, points = band.receiver.width, band.receiver.points
            if band.receiver.drawn is not None:
                points = yield from band.receiver.drawn(band.rows)
            for rows in tiles.slices(band.height, max(1, surfels.TILE // width)):
                part = slice(band.rows.start + rows.start, band.rows.start + rows.stop)
                parts.append((points, band.receiver.streams, part, base - band.rows.start * width))
            base += band.height * width
        found = {}

        def make(part: slice):
            for k in range(part.start, part.stop):
                points, streams, rows, shift = parts[k]
                here, centred = points(rows)
                place = here.place + shift
                if streams is not None:
                    here = replace(here, place=streams[here.place])
                found[k] = here, place, centred

        yield from tiles.run(make, tiles.slices(len(parts), 1))
        here, place, centred = zip(*(found[k] for k in range(len(parts))))
        return Surfels.concatenate(list(here)), np.concatenate(place), np.concatenate(centred)

    def kept(self) -> Iterator[tuple[Receiver, slice, slice]]:
        """For each band its receiver, the rows of the tile's image that are kept, and the receiver's rows they are."""
        base = 0
        for band in self.bands:
            begin = base + band.kept.start - band.rows.start
            yield band.receiver, slice(begin, begin + band.kept.stop - band.kept.start), band.kept
            base += band.height


def cut(receivers: list[Receiver], points: int, margin: int, unit: int = 1) -> list[Tile]:
    """Tiles of at most about so many points that cover all receivers.

    margin: rows beyond its own that a band needs, where it ends inside its receiver. unit: rows that stay together.
    """
    done, stack, count = [], [], 0
    for receiver in receivers:
        whole = receiver.width * receiver.height
        if stack and (count + whole > points or receiver.width != stack[0].receiver.width):
            done.append(Tile(tuple(stack)))
            stack, count = [], 0
        if whole <= points:
            rows = slice(0, receiver.height)
            stack.append(Band(receiver, rows, rows))
            count += whole
            continue
        # Never so few rows that most of the work goes into their margins.
        own = -(-max(2 * margin, points // receiver.width - 2 * margin, 1) // unit) * unit
        for kept in tiles.slices(receiver.height, own):
            rows = slice(max(0, kept.start - margin), min(receiver.height, kept.stop + margin))
            done.append(Tile((Band(receiver, rows, kept),)))
    return [*done, Tile(tuple(stack))] if stack else done


def guides(tracer: Tracer, names: list[str], camera: Camera | None, n: int) -> Surfels:
    """About n points spread over what gets light, to which lights are chosen; the same however the bake is cut.

    names: the objects, each with as many points; or camera: the view, evenly.
    """
    if camera is not None:
        step = max(1.0, np.sqrt(camera.resolution[0] * camera.resolution[1] / n))
        resolution = tuple(max(1, round(side / step)) for side in camera.resolution)
        return surfels.from_camera(tracer, replace(camera, resolution=resolution))
    return surfels.strewn_over(tracer.geometry, names, n)
