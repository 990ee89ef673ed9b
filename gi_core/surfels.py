# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Surface points: what light arrives at and leaves from. Made from a camera, a light's map, UV texels and vertices."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace

import numpy as np

from . import bump
from .atlas import Place
from .emitters import strewn
from .geometry import Geometry
from .scene import Camera
from .texels import covered_texels
from .trace import FAR, Hits, Tracer
from .vectors import dot, length, normalize, offset, pick

TILE = 1 << 16

# How far a triangle's corners lie from its vertices, towards its centre, as a share of their largest coordinate or of a
# metre: at a vertex itself the neighbouring walls would be met at distance zero. It is what Cycles' bake does.
_INSET = 1e-4


@dataclass(frozen=True)
class Surfels:
    """Points on surfaces, all arrays with one row per point.

    position: (n, 3) float32, world space [m].
    normal: (n, 3) float32, unit shading normal.
    face: (n, 3) float32, unit geometric normal, on the same side; rays leave towards it.
    albedo: (n, 3) float32 diffuse reflectance.
    emission: (n, 3) float32 radiance [W/(m²·sr)].
    place: (n,) int64, which pixel, texel or vertex of its receiver the point stands for (row · width + column in an
        image).
    smooth: (n, 3) float32, unit, the mesh's interpolated normal, from which a normal or bump map may turn `normal`
        away. Where none does it is the very array of `normal`.
    """

    position: np.ndarray
    normal: np.ndarray
    face: np.ndarray
    albedo: np.ndarray
    emission: np.ndarray
    place: np.ndarray
    smooth: np.ndarray | None = None

    def __post_init__(self):
        if self.smooth is None:
            object.__setattr__(self, "smooth", self.normal)

    def __len__(self) -> int:
        return len(self.position)

    def __getitem__(self, which) -> "Surfels":
        """The points that a slice, mask or index array picks."""
        return self._each(lambda name: pick(getattr(self, name), which), self.is_bumpy)

    def _each(self, made: Callable[[str], np.ndarray], bumpy: bool) -> "Surfels":
        return Surfels(**{f.name: made(f.name) for f in fields(self) if bumpy or f.name != "smooth"})

    @property
    def is_bumpy(self) -> bool:
        """Whether normals may differ from the mesh's."""
        return self.smooth is not self.normal

    @property
    def origin(self) -> np.ndarray:
        """(n, 3) float32: where rays may start without meeting the surface that they leave."""
        return offset(self.position, self.face)

    def shadowing(self, rows: np.ndarray, direction: np.ndarray) -> np.ndarray | np.float32:
        """How much of light from unit directions (m, 3) counts at points (m,) of these, see `bump`: (m,), or just 1."""
        if not self.is_bumpy:
            return np.float32(1)
        return bump.shadowing(pick(self.smooth, rows), pick(self.normal, rows), direction)

    def turned(self, rows: np.ndarray) -> "Surfels":
        """The same points, those that rows (n,) bool picks on the other side of their surface."""
        sign = np.where(rows, -1, 1).astype(np.float32)[:, None]
        normal = self.normal * sign
        smooth = self.smooth * sign if self.is_bumpy else normal
        return replace(self, normal=normal, smooth=smooth, face=self.face * sign)

    @staticmethod
    def concatenate(parts: "list[Surfels]") -> "Surfels":
        bumpy = any(p.is_bumpy for p in parts)
        return parts[0]._each(lambda name: np.concatenate([getattr(p, name) for p in parts]), bumpy)


def at(geometry: Geometry, triangle, weights, place, towards=None, reflecting=False, maps=True) -> Surfels:
    """The surfels at points on triangles.

    triangle: (n,), weights: (n, 3) barycentric, place: (n,).
    towards: (n, 3) directions; normals are turned to the side that they point to (a camera's or a light's). Without it
        the mesh's front counts, as it does for a bake.
    reflecting: the points are to light others, so that albedo is all that they reflect, their gloss included.
    maps: normals are those that materials make of the mesh's.
    """
    albedo = geometry.color("albedo", triangle, weights)
    if reflecting and geometry.has_gloss:
        albedo = np.minimum(albedo + geometry.color("gloss_albedo", triangle, weights), 1)
    face = geometry.face_normal(triangle)
    smooth = geometry.shading_normal(triangle, weights)
    # A mesh may carry no usable corner normals; its faces always have one.
    smooth = np.where(np.any(smooth != 0, -1, keepdims=True), smooth, face)
    # The shading normal says where the front is: winding may disagree with it.
    face = np.where(dot(face, smooth)[:, None] < 0, -face, face)
    behind = None if towards is None else dot(face, towards) < 0
    normal = smooth
    if maps and geometry.has_normal_maps:
        normal, smooth = geometry.mapped_normal(triangle, weights, smooth, behind)
    made = Surfels(
        geometry.position(triangle, weights), normal, face, albedo, geometry.color("emission", triangle, weights),
        np.asarray(place, np.int64), smooth,
    )  # fmt: skip
    return made if behind is None else made.turned(behind)


def along_rays(
    tracer: Tracer,
    origins: np.ndarray,
    directions: np.ndarray,
    place: np.ndarray,
    far: float = FAR,
    reflecting: bool = False,
    solid: Hits | None = None,
) -> tuple[Surfels, np.ndarray]:
    """The surfels where rays hit, facing back along them, and the indices of the rays that hit: (n, 3), (n, 3), (n,).

    reflecting: as for `at`. solid: as for `Tracer.closest`.
    """
    hits = tracer.closest(origins, directions, far, solid)
    hit = np.flatnonzero(hits.triangle >= 0)
    hits = hits[hit]
    return at(tracer.geometry, hits.triangle, hits.weights, place[hit], -pick(directions, hit), reflecting), hit


def camera_rays(camera: Camera, subpixels: int = 1, rows: slice | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Rays through a regular grid of points, `subpixels`² to a pixel, from the near clipping plane on.

    rows: of the grid, from the bottom, None for all.
    Returns origins and unit directions, (rows · w·subpixels, 3) float32 each.
    """
    left, right, bottom, top = camera.window
    w, h = camera.resolution[0] * subpixels, camera.resolution[1] * subpixels
    row, near = np.arange(h)[rows or slice(None)], camera.clip[0]
    x, y = left + (np.arange(w) + 0.5) / w * (right - left), bottom + (row + 0.5) / h * (top - bottom)
    right, up, back = camera.matrix[:3, :3].T
    # One sum for each ray: the plane's points are a row of vectors and a column.
    plane = (x[:, None] * right + (y[:, None] * up)[:, None] - back).reshape(-1, 3)
    if camera.kind == "PERSPECTIVE":
        start, direction = near * plane, normalize(plane)
    else:
        start, direction = plane + (1 - near) * back, np.broadcast_to(normalize(-back), plane.shape)
    return (start + camera.matrix[:3, 3]).astype(np.float32), direction.astype(np.float32)


def from_camera(
    tracer: Tracer, camera: Camera, subpixels: int = 1, rows: slice | None = None, solid: Hits | None = None
) -> Surfels:
    """What each (sub)pixel sees; `place` counts subpixels along rows. rows: of subpixels, None for all. solid: as for
    `Tracer.closest`."""
    origins, directions = camera_rays(camera, subpixels, rows)
    first = rows.start * camera.resolution[0] * subpixels if rows else 0
    surfels, _ = along_rays(tracer, origins, directions, first + np.arange(len(origins)), solid=solid)
    # The near plane is where rays start; the far one cuts what lies behind it.
    axis = -camera.matrix[:3, 2]
    return surfels[(surfels.position - camera.matrix[:3, 3]) @ axis <= camera.clip[1]]


def from_texels(
    geometry: Geometry,
    name: str,
    uv: str,
    resolution: tuple[int, int],
    rows: slice | None = None,
    place: Place | None = None,
) -> tuple[Surfels, np.ndarray]:
    """A surfel for every texel that a face of an object touches, with the point clamped into the face.

    name: the object. uv: its UV map, "" for the active one. resolution: (width, height). rows: of texels, None for all.
    place: of the object on the image, None for all of it.
    Returns the Surfels and (n,) bool: whether the texel's centre lies in a face.
    Raises KeyError where there is no such object or UV map.
    """
    mesh, triangle = geometry.mesh_of(name)
    layer = uv or mesh.active_uv
    if layer not in mesh.uvs:
        raise KeyError(f"object '{name}' has no UV map '{layer}'")
    # Without area there is no normal and nothing to light.
    solid = geometry.areas[triangle] > 0
    uvs = mesh.uvs[layer][solid]
    if place is None:
        texels = covered_texels(uvs, resolution, rows)
    else:
        texels = covered_texels(place.on(uvs, *resolution), resolution, rows).within(place, resolution[0])
    return at(geometry, triangle[solid][texels.triangle], texels.weights, texels.place), texels.centred


def strewn_over(geometry: Geometry, names: Sequence[str], n: int) -> Surfels:
    """About n surfels over objects, as many on each, evenly over its surface. Raises KeyError for no such object."""
    areas, strength = geometry.areas, np.zeros(len(geometry.triangles))
    for name in names:
        triangle = geometry.mesh_of(name)[1]
        area = areas[triangle].sum(dtype=np.float64)
        strength[triangle] = 1 / area if area > 0 else 0
    if not np.any(strength):
        return at(geometry, *(np.zeros(s, int) for s in ((0,), (0, 3), (0,))))
    triangle, weights, _ = strewn(geometry, strength, n)
    return at(geometry, triangle, weights, np.arange(n))


def from_corners(geometry: Geometry, name: str, triangles: slice | None = None) -> Surfels:
    """A surfel for each corner of each triangle of an object that has an area; `place` is 3 · triangle + corner.

    triangles: those to look at, None for all. Normals are the mesh's: of a normal map a corner would show one place,
    and stand for all around. Raises KeyError for no such object.
    """
    _, every = geometry.mesh_of(name)
    triangle = every[triangles or slice(None)]
    solid = np.flatnonzero(np.any(geometry.face_normal(triangle) != 0, -1))
    corners = geometry.vertices[geometry.triangles[triangle[solid]]]
    away = np.maximum(length(corners - corners.mean(1, keepdims=True)), 1e-20)
    share = np.minimum(_INSET * np.maximum(np.abs(corners).max(-1), 1) / away, 1)[..., None]
    weights = (1 - share) * np.eye(3) + share / 3
    place = (3 * (triangle[solid] - every[0])[:, None] + np.arange(3)).ravel()
    return at(geometry, np.repeat(triangle[solid], 3), weights.reshape(-1, 3).astype(np.float32), place, maps=False)
