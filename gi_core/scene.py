# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The scene as the techniques see it: frozen dataclasses of arrays, with nothing of Blender in them.

Conventions: scene-linear Rec.709, metres, radiometric units per channel, world space right-handed with Z up.
Arrays are float32 and C-ordered unless said otherwise; images have row 0 at the bottom.
Geometry is kept once per mesh in the mesh's own space; an `Instance` puts it into the world.
"""

from dataclasses import dataclass, field, replace

import numpy as np

# The UV map that is made for lightmaps where a mesh has none; where it is there, lightmaps lie on it.
LIGHTMAP_UV = "GI Lightmap"


@dataclass(frozen=True)
class Texture:
    """An image that colours a surface.

    pixels: (h, w, 3) float32, scene-linear, row 0 at the bottom.
    extension: what lies outside [0, 1]: "REPEAT", "EXTEND", "CLIP" (black) or "MIRROR".
    interpolation: "LINEAR" or "CLOSEST".
    encoded: (h, w, 3) uint8, the sRGB values that `pixels` were decoded from; where there are some, it is these that
        are interpolated, as Cycles does it.
    """

    name: str
    pixels: np.ndarray
    extension: str = "REPEAT"
    interpolation: str = "LINEAR"
    encoded: np.ndarray | None = None


@dataclass(frozen=True)
class ColorSource:
    """A colour over a surface: `value`, multiplied by `texture` looked up at the UV map named `uv` where there is one.

    value: (3,) float32.
    uv: name of the UV map; "" means the mesh's render UV map.
    """

    value: np.ndarray
    texture: Texture | None = None
    uv: str = ""


@dataclass(frozen=True)
class NormalSource(ColorSource):
    """A normal over a surface, in the mesh's own space.

    raised: seen from behind the relief stands out there as well, as bumps do; else its back shows, as of normal maps.
    under: the normal that bumps stand out from, None for the mesh's own.
    own: light knows of no other normal under it, as where displacement is seen as relief.
    """

    raised: bool = False
    own: bool = False
    under: ColorSource | None = None


BLACK = ColorSource(np.zeros(3, np.float32))
WHITE = ColorSource(np.ones(3, np.float32))


@dataclass(frozen=True)
class Gloss:
    """A rough mirror on a surface: its reflectance at an angle θ to a microfacet is

        specular + (edge − specular) (1 − cosθ)⁵ + dielectric · F(θ, ior)

    of metals (Schlick) and of dielectrics (Fresnel), which add up where materials are mixed.

    roughness: Blender's, 0…1, in the first channel; α of the GGX lobe is its square.
    specular, edge: reflectance at normal incidence and at grazing, 0…1.
    metal, dielectric: how much of the surface is either, 0…1. ior: index of refraction of the latter.
    """

    roughness: ColorSource = BLACK
    specular: ColorSource = BLACK
    edge: ColorSource = BLACK
    metal: ColorSource = BLACK
    dielectric: ColorSource = BLACK
    ior: float = 1.5

    @property
    def is_none(self) -> bool:
        """Whether nothing is reflected."""
        return not any(source.value.any() for source in (self.specular, self.edge, self.dielectric))


MATTE = Gloss()


@dataclass(frozen=True)
class Material:
    """A diffuse, emitting surface, glossy where it is asked for; both sides alike.

    albedo: diffuse reflectance, 0…1.
    emission: radiance [W/(m²·sr)].
    alpha: how solid it is, 0…1, in the first channel: of the light that meets it the rest goes straight on. Albedo and
        emission are those of the solid part.
    gloss: what it reflects besides, of the solid part too.
    gloss_albedo: share of even light from all around that it reflects besides. It is what other surfaces get of that,
        as if it were diffuse, whether or not `gloss` is known.
    normal: shading normal in the mesh's own space, of any length but zero, where a normal or bump map gives one; None
        for the mesh's.
    """

    name: str
    albedo: ColorSource
    emission: ColorSource = BLACK
    alpha: ColorSource = WHITE
    gloss: Gloss = MATTE
    gloss_albedo: ColorSource = BLACK
    normal: NormalSource | None = None


@dataclass(frozen=True)
class Mesh:
    """The triangles of one evaluated mesh, in its own space.

    vertices: (v, 3) float32.
    triangles: (t, 3) int32 indices into `vertices`.
    normals: (t, 3, 3) float32, unit shading normal of each corner.
    slots: (t,) int32 material slot of each triangle.
    uvs: UV map name -> (t, 3, 2) float32.
    render_uv: name of the UV map that textures lie on by default, "" where the mesh has none.
    active_uv: name of the UV map that lightmaps lie on by default, "" where the mesh has none.
    """

    name: str
    vertices: np.ndarray
    triangles: np.ndarray
    normals: np.ndarray
    slots: np.ndarray
    uvs: dict[str, np.ndarray] = field(default_factory=dict)
    render_uv: str = ""
    active_uv: str = ""


@dataclass(frozen=True)
class Instance:
    """A mesh at a place in the world.

    name: the object's name; copies made by instancing (collections, particles, nodes) carry their source's name.
    mesh: index into `Scene.meshes`.
    matrix: (4, 4) float64, mesh space to world space.
    materials: index into `Scene.materials` for each slot, at least one.
    is_copy: made by instancing, not an object of its own; it casts and reflects light but no result is kept for it.
    receives: gets results where none are asked for by name. casts: blocks and reflects light.
    """

    name: str
    mesh: int
    matrix: np.ndarray
    materials: tuple[int, ...]
    is_copy: bool = False
    receives: bool = True
    casts: bool = True


@dataclass(frozen=True)
class Light:
    """A lamp; it shines along the −Z axis of its matrix.

    kind: "POINT", "SPOT", "AREA" or "SUN".
    matrix: (4, 4) float64, light space to world space, scale included (it stretches area lights and spot cones).
    power: (3,) float32. Point, spot and area: radiant power [W] with Blender's meaning (radiant intensity P/4π W/sr of
        a point or spot, radiance P/(πA) of an area light). Sun: irradiance on a perpendicular surface [W/m²].
        Colour, temperature, exposure and Blender's `normalize` are already in it.
    radius: [m] of the sphere (point, spot).
    soft_falloff: the sphere is a disk that faces the receiver (Blender's Soft Falloff).
    spot_angle, spot_blend: full cone angle [rad] and share of the cone that fades out, 0…1.
    shape, size: "RECTANGLE" or "ELLIPSE", full extents (2,) along X and Y in light space [m before scale].
    spread: full angle [rad] of an area light's beam, π for a Lambertian one.
    angle: angular diameter of a sun [rad].
    shadow: casts shadows.
    """

    name: str
    kind: str
    matrix: np.ndarray
    power: np.ndarray
    radius: float = 0.0
    soft_falloff: bool = False
    spot_angle: float = np.pi
    spot_blend: float = 0.0
    shape: str = "RECTANGLE"
    size: tuple[float, float] = (1.0, 1.0)
    spread: float = np.pi
    angle: float = 0.0
    shadow: bool = True


@dataclass(frozen=True)
class Environment:
    """What is seen where a ray leaves the scene: radiance [W/(m²·sr)].

    color: (3,) float32, multiplied by `texture` (equirectangular as Blender maps it, +X in the middle).
    rotation: (3, 3) float64, world direction to texture direction.
    """

    color: np.ndarray
    texture: Texture | None = None
    rotation: np.ndarray = field(default_factory=lambda: np.eye(3))


@dataclass(frozen=True)
class Camera:
    """A pinhole or parallel camera; it looks along the −Z axis of its matrix.

    kind: "PERSPECTIVE" or "ORTHOGRAPHIC".
    matrix: (4, 4) float64, camera space to world space, without scale.
    window: left, right, bottom, top of the image on the plane z = −1 (perspective) or in metres (orthographic), with
        lens shift, sensor fit and pixel aspect applied.
    resolution: (width, height) in pixels.
    clip: near and far distance along the view axis [m].
    """

    kind: str
    matrix: np.ndarray
    window: tuple[float, float, float, float]
    resolution: tuple[int, int]
    clip: tuple[float, float] = (1e-3, 1e6)

    def at(self, side: int | None) -> "Camera":
        """The camera with its longer side at so many pixels, None for as it is."""
        if side is None:
            return self
        longer = max(self.resolution)
        return replace(self, resolution=tuple(max(1, round(n * side / longer)) for n in self.resolution))


@dataclass(frozen=True)
class Scene:
    """All that a technique may know.

    approximated: a sentence for each thing that is not taken as it is in the file, naming it and what was taken
        instead.
    """

    meshes: tuple[Mesh, ...]
    instances: tuple[Instance, ...]
    materials: tuple[Material, ...]
    lights: tuple[Light, ...] = ()
    environment: Environment = Environment(np.zeros(3, np.float32))
    camera: Camera | None = None
    approximated: tuple[str, ...] = ()
