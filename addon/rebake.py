# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Which objects' lightmaps are still right: what went into each is kept as a hash with it.

An object's own shape, place, UVs and materials count, the lamps, the sky and the settings, but not the other objects:
what these reflect onto it stays as it was until all is baked again.
"""

import hashlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, fields, is_dataclass, replace
from functools import cache

import bpy
import numpy as np

from ..gi_core.atlas import Page, Place
from ..gi_core.scene import Scene
from ..gi_core.settings import Settings
from .write.placement import HASH, placement

# Settings that change how long a bake takes and what files it writes, but no light.
_IDLE = {"memory", "time_limit", "device", "rebake", "encoding", "exposure", "exr", "gltf", "unwrap"}


def signatures(core: Scene, pages: Sequence[Page], method: str, settings: Settings) -> dict[str, str]:
    """Object name -> hash of what its lightmap follows from."""
    chosen = {name: value for name, value in asdict(settings).items() if name not in _IDLE}
    common = _digest((method, sorted(chosen.items(), key=str), core.lights, core.environment))
    instances = {i.name: i for i in core.instances if not i.is_copy}

    @cache
    def shape(index: int) -> str:
        mesh = core.meshes[index]
        return _digest((mesh.vertices, mesh.triangles, mesh.normals, mesh.slots, mesh.uvs))

    @cache
    def material(index: int) -> str:
        return _digest(core.materials[index])

    found = {}
    for page in pages:
        for place in page.places:
            instance = instances[place.name]
            own = shape(instance.mesh), instance.matrix, instance.casts, [material(k) for k in instance.materials]
            found[place.name] = _digest((common, own, place, page.width, page.height))
    return found


@dataclass(frozen=True)
class Due:
    """What of some lightmaps is to be baked.

    whole: all of them. pages: those with only the objects that are due. hashes: `signatures`. kept: see `kept`.
    """

    whole: tuple[Page, ...] = ()
    pages: tuple[Page, ...] = ()
    hashes: dict[str, str] = field(default_factory=dict)
    kept: dict[str, np.ndarray] = field(default_factory=dict)

    def of(self, which: Callable[[str], bool]) -> "Due":
        """What of it is due of some objects only."""
        left = [replace(p, places=tuple(q for q in p.places if which(q.name))) for p in self.pages]
        hashes = {name: value for name, value in self.hashes.items() if which(name)}
        return replace(self, pages=tuple(page for page in left if page.places), hashes=hashes)


def due(
    scene: bpy.types.Scene, core: Scene, pages: list[Page], method: str, settings: Settings
) -> Iterator[tuple[str, float]]:
    """What of the pages is to be baked, by the setting `rebake`. A generator of (stage, fraction of it), "layout" and
    "signatures", of which the latter touches nothing of Blender; returns Due."""
    changed = settings.rebake == "changed"
    whole = [_as_before(scene, page) or page for page in pages] if changed else pages
    yield "signatures", 0.0
    hashes = signatures(core, whole, method, settings)
    yield "layout", 1.0
    if not changed:
        return Due(tuple(whole), tuple(whole), hashes)
    still, earlier = kept(scene, whole, hashes)
    left = [replace(p, places=tuple(q for q in p.places if q.name not in still)) for p in whole]
    return Due(tuple(whole), tuple(page for page in left if page.places), hashes, earlier)


def kept(
    scene: bpy.types.Scene, pages: Sequence[Page], wanted: dict[str, str]
) -> tuple[set[str], dict[str, np.ndarray]]:
    """Names of the objects whose light is still right, and by page name what the file holds of it: (h, w, 4)."""
    names, pixels = set(), {}
    for page in pages:
        for place in page.places:
            obj = scene.objects[place.name]
            found = placement(obj)
            if found and obj.get(HASH) == wanted[place.name] and tuple(found.image.size) == (page.width, page.height):
                names.add(place.name)
                if page.name not in pixels:
                    pixels[page.name] = _read(found.image)
    return names, pixels


def _as_before(scene: bpy.types.Scene, page: Page) -> Page | None:
    found = {place.name: placement(scene.objects[place.name]) for place in page.places}
    images = {each.image for each in found.values() if each}
    if None in found.values() or len(images) != 1 or tuple(images.pop().size) != (page.width, page.height):
        return None
    places = []
    for place in page.places:
        each = found[place.name]
        if each.uv != place.uv:
            return None
        x, y = (round(o * n) for o, n in zip(each.offset, (page.width, page.height)))
        places.append(Place(place.name, place.uv, x, y, round(each.scale[0] * page.width)))
    return Page(page.name, page.width, page.height, tuple(places))


def _read(image: bpy.types.Image) -> np.ndarray:
    width, height = image.size
    pixels = np.empty((height, width, 4), np.float32)
    image.pixels.foreach_get(pixels.ravel())
    return pixels


def _digest(value) -> str:
    hashed = hashlib.blake2b(digest_size=16)

    def feed(value):
        if isinstance(value, np.ndarray):
            hashed.update(f"{value.dtype}{value.shape}".encode())
            hashed.update(np.ascontiguousarray(value).reshape(-1))
        elif is_dataclass(value):
            hashed.update(type(value).__name__.encode())
            for f in fields(value):
                feed(getattr(value, f.name))
        elif isinstance(value, dict):
            feed(sorted(value))
            for key in sorted(value):
                feed(value[key])
        elif isinstance(value, list | tuple):
            hashed.update(f"({len(value)}".encode())
            for each in value:
                feed(each)
        else:
            hashed.update(repr(value).encode() + b";")

    feed(value)
    return hashed.hexdigest()
