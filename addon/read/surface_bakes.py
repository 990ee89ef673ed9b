# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What only Cycles can tell of materials, baked to textures: one for each output of a node, material and mesh.

The first reading of a scene asks for them with `want`; `bake` makes them, out of copies in a scene of its own that are
gone afterwards; the second reading finds them. Where a material depends on the object or its place, each object that
shares a mesh has its own.
"""

import contextlib
import hashlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial
from operator import attrgetter
from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...gi_core.scene import ColorSource, Mesh, Texture
from ...gi_core.triangle_atlas import TriangleAtlas, triangle_atlas
from ...gi_core.vectors import normalize
from ..run import aside
from ..sentence import Sentence
from .expression import Expression, Key
from .mesh_copies import MeshCopy
from .places import Place
from .socket_materials import socket_material
from .sources import constant
from .texture_cache import TextureCache, default_folder

if TYPE_CHECKING:
    from .materials import MaterialReader

# Texels of all textures together, and the most and fewest of one [power of two].
_ALL, _MOST, _FEWEST = 25, 20, 14

# Share of a texture's texels that are on edges, or on noise, above which it is told.
_ROUGH = 0.01

# Triangles beyond which a mesh is not baked: each needs eight texels.
_TRIANGLES = 1 << 20

# Objects that share a mesh and a material which differs between them; further ones take turns with the textures.
_OBJECTS = 256

# Changes whenever the same input gives other textures.
_VERSION = 1


@dataclass
class Patch:
    """A material on some slots of a mesh. uv: name of the UV map of its textures. textures: those that were baked.
    notes: what is not exact."""

    material: bpy.types.Material
    expressions: tuple[Expression, ...]
    mesh: int
    slots: tuple[int, ...]
    place: Place
    textures: dict[tuple[Key, bool], ColorSource] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)

    @property
    def uv(self) -> str:
        return "gi_bake." + ".".join(map(str, self.slots))


class SurfaceBakes:
    """The textures that the materials of one scene want.

    folder: where they are kept for the next time, None for nowhere. patches: all that was asked for. materials, notes:
    of the first reading, what reads materials again and what else was approximated.
    """

    def __init__(self, folder: Path | str | None = "default"):
        self.patches: list[Patch] = []
        self.materials: MaterialReader | None = None
        self.notes: list[str] = []
        self._cache = TextureCache(default_folder() if folder == "default" else folder)
        self._meshes: dict[int, MeshCopy] = {}
        self._known: dict[tuple, dict[bytes, Patch]] = {}

    def want(
        self,
        material: bpy.types.Material,
        expressions: tuple[Expression, ...],
        entry: bpy.types.DepsgraphObjectInstance,
        index: int,
        mesh: Mesh,
        slots: tuple[int, ...],
    ) -> Patch:
        """The patch of an evaluated material on slots of an instance of a mesh."""
        key = material.original.as_pointer(), index, slots
        alike = self._known.setdefault(key, {})
        differs = any(_owner(expression) for expression in expressions)
        if alike and not differs:
            return alike[b""]
        place = Place.of(entry)
        own = b"".join(sorted({_owner(expression)(place) for expression in expressions if _owner(expression)}))
        if own not in alike:
            if len(alike) < _OBJECTS:
                alike[own] = Patch(material.original, expressions, index, slots, place)
                self.patches.append(alike[own])
                if np.count_nonzero(np.isin(mesh.slots, slots)) > _TRIANGLES:
                    said = Sentence("mesh '{mesh}' has too many triangles to bake it", mesh=mesh.name)
                    alike[own].notes.append(said)
                elif index not in self._meshes:
                    self._meshes[index] = MeshCopy.of(entry.object, mesh)
            else:
                patches = list(alike.values())[:_OBJECTS]
                said = Sentence(
                    "objects of one mesh differ in it; all but {number} are taken as one of those", number=_OBJECTS
                )
                patches[0].notes[:] = [said]
                alike[own] = patches[len(alike) % _OBJECTS]
        return alike[own]

    def bake(self, scene: bpy.types.Scene) -> Iterator[float]:
        """Makes the textures. A generator of progress; returns mesh index -> its UV maps with those for textures.

        Raises RuntimeError where Blender cannot bake now.
        """
        uvs = {index: dict(copy.mesh.uvs) for index, copy in self._meshes.items()}
        atlases, count = {}, sum(len(patch.expressions) for patch in self.patches)
        texels = 1 << min(max(_ALL - int(np.ceil(np.log2(max(count, 1)))), _FEWEST), _MOST)
        with contextlib.ExitStack() as gone:
            studio = None
            for done, patch in enumerate(self.patches):
                yield done / len(self.patches)
                copy, where = self._meshes.get(patch.mesh), (patch.mesh, patch.slots)
                if copy is None:
                    continue
                kept = np.isin(copy.mesh.slots, patch.slots)
                if np.count_nonzero(kept) > _TRIANGLES:  # copied for other slots
                    continue
                if where not in atlases:
                    atlases[where] = triangle_atlas(copy.mesh.vertices[copy.mesh.triangles], kept, texels)
                    uvs[patch.mesh][patch.uv] = atlases[where].uvs
                for expression in patch.expressions:
                    key = _hash(patch, expression, copy, texels)
                    pixels = self._cache.load(key)
                    if pixels is None:
                        studio = studio or gone.enter_context(_Studio(scene))
                        pixels = studio.baked(patch, expression, copy, atlases[where])
                        yield done / len(self.patches)
                        pixels = yield from aside(partial(self._kept, key, pixels, patch, expression, atlases[where]))
                    patch.textures[expression.wanted_as] = _source(expression.name, pixels, patch.uv)
                    if atlases[where].roughness(pixels) > _ROUGH:
                        said = Sentence("'{node}' has finer detail than its texture", node=expression.name)
                        patch.notes.append(said)
        self._cache.trim()
        self._meshes.clear()
        return uvs

    def _kept(
        self, key: str, pixels: np.ndarray, patch: Patch, expression: Expression, atlas: TriangleAtlas
    ) -> np.ndarray:
        """What Cycles baked as the texture that is kept: (h, w, 4), to (h, w, 3) with all texels. Away from Blender."""
        pixels = np.nan_to_num(pixels[..., :3])
        if expression.is_normal:  # from the world to the mesh's space, as normals go
            pixels = normalize((2 * pixels - 1) @ patch.place.matrix[:3, :3].astype(np.float32))
        atlas.complete(pixels)
        return self._cache.save(key, pixels)

    def with_uvs(self, meshes: tuple[Mesh, ...], uvs: dict[int, dict[str, np.ndarray]]) -> tuple[Mesh, ...]:
        """Meshes with other UV maps, by their index."""
        return tuple(replace(mesh, uvs=uvs.get(index, mesh.uvs)) for index, mesh in enumerate(meshes))


def _owner(expression: Expression) -> Callable[[Place], bytes] | None:
    """What of an object's place an expression depends on."""
    if expression.of_object or expression.random:
        return attrgetter("signature")
    return attrgetter("shape") if expression.of_shape else None


def _source(name: str, pixels: np.ndarray, uv: str) -> ColorSource:
    if not np.ptp(pixels, axis=(0, 1)).any():
        return constant(pixels[0, 0])
    return ColorSource(np.ones(3, np.float32), Texture(name, pixels, "EXTEND"), uv)


def _hash(patch: Patch, expression: Expression, copy: MeshCopy, texels: int) -> str:
    parts = [_VERSION, bpy.app.version, expression.signature, copy.signature, patch.slots, texels]
    if expression.is_normal:
        parts.append("normal")
    if owner := _owner(expression):
        parts.append(owner(patch.place))
    return hashlib.sha256(repr(parts).encode()).hexdigest()


class _Studio:
    """A scene with nothing in it but what is baked."""

    def __init__(self, scene: bpy.types.Scene):
        self._user = scene
        self._gone = contextlib.ExitStack()
        self._object = self._copy = None

    def __enter__(self) -> "_Studio":
        scene = bpy.data.scenes.new("GI Bake")
        self._gone.callback(bpy.data.scenes.remove, scene)
        user = self._user
        scene.frame_current, scene.frame_subframe = user.frame_current, user.frame_subframe
        scene.render.engine = "CYCLES"
        cycles = scene.cycles
        cycles.device, cycles.samples, cycles.shading_system = "CPU", 1, user.cycles.shading_system
        cycles.use_denoising = cycles.use_adaptive_sampling = cycles.use_auto_tile = False
        self._scene = scene
        return self

    def __exit__(self, *_) -> None:
        self._clear()
        self._gone.close()

    def _clear(self) -> None:
        if self._object:
            bpy.data.meshes.remove(self._object.data)  # takes the object along
        self._object = self._copy = None

    def baked(self, patch: Patch, expression: Expression, copy: MeshCopy, atlas: TriangleAtlas) -> np.ndarray:
        """What an expression computes, at the texels of an atlas that its triangles cover: (h, w, 4) float32."""
        if self._copy is not copy:
            self._clear()
            self._object, self._copy = copy.build("GI Bake"), copy
            self._scene.collection.objects.link(self._object)
        obj, mesh, place = self._object, self._object.data, patch.place
        obj.matrix_world = place.matrix.T.tolist()
        obj.color, obj.pass_index = place.color, place.pass_index
        for name in list(obj.keys()):
            del obj[name]
        for name, value in place.properties.items():
            obj[name] = value
        layer = mesh.uv_layers.new(name=patch.uv, do_init=False)
        if layer is None:
            raise RuntimeError(f"mesh '{copy.mesh.name}' has no room for another UV map: remove one")
        uv = layer.name
        layer.uv.foreach_set("vector", np.ascontiguousarray(atlas.sampled).reshape(-1))
        constants = dict(expression.of_view) | {key: np.full(3, place.random) for key in expression.random}
        with contextlib.ExitStack() as gone:
            gone.callback(lambda: mesh.uv_layers.remove(mesh.uv_layers[uv]))
            image = bpy.data.images.new(
                "GI Bake", atlas.width, atlas.height, alpha=True, float_buffer=True, is_data=True
            )
            gone.callback(bpy.data.images.remove, image)
            is_normal = expression.is_normal
            material = socket_material(patch.material, expression.key, constants, image, gone, signed=is_normal)
            mesh.materials.append(material)
            gone.callback(mesh.materials.clear)
            self._run(uv, patch)
            pixels = np.empty((atlas.height, atlas.width, 4), np.float32)
            image.pixels.foreach_get(pixels.reshape(-1))
        return pixels

    def _run(self, uv: str, patch: Patch) -> None:
        scene, obj = self._scene, self._object
        context = {"scene": scene, "view_layer": scene.view_layers[0], "object": obj, "active_object": obj}
        try:
            with bpy.context.temp_override(**context, selected_objects=[obj], selected_editable_objects=[obj]):
                bpy.ops.object.bake(
                    type="EMIT", margin=0, uv_layer=uv, use_clear=True, target="IMAGE_TEXTURES", save_mode="INTERNAL",
                    use_selected_to_active=False, use_split_materials=False,
                )  # fmt: skip
        except RuntimeError as error:
            raise RuntimeError(
                f"Cycles cannot bake material '{patch.material.name}' of '{patch.place.name}' now: {error}"
            ) from error
