# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a render depends on, as one number: equal only where Cycles would make the same picture.

Everything of the evaluated scene counts that Blender's own reflection shows: shapes, materials down to each socket,
lamps, world, images' contents. What only changes how an editor looks does not. A change that would not be seen costs a
new render; one that would be seen and did not count would be a lie, so what is in doubt counts.
"""

import hashlib
from collections.abc import Iterator
from pathlib import Path

import bpy
import numpy as np

from ...gi_core.tiles import whole
from ..read.render_depsgraph import reading
from ..read.turns import in_turns
from .reference_scene import BOUNCES, CYCLES, RENDER

# Of editors, of this session, or what is asked for anew with each reference.
_IDLE = {
    "rna_type", "original", "session_uid", "is_evaluated", "users", "use_fake_user", "use_extra_user", "tag", "preview",
    "asset_data", "override_library", "library_weak_reference", "library", "animation_data", "select", "active_index",
    "execution_time", "is_updated", "is_updated_data", "bindcode", "runtime", "has_data", "pixels",
    # Blender 5 has nodes everywhere, and warns whoever asks.
    *(["use_nodes"] if bpy.app.version >= (5, 0) else []),
}  # fmt: skip
_IDLE_PREFIXES = ("show_", "select_", "preview_", "active_", "ui_", "gi_")
_OF_NODES = {"location", "location_absolute", "width", "height", "dimensions", "color", "use_custom_color", "hide",
             "parent", "internal_links"}  # fmt: skip
_OF_RENDERS = {*RENDER, *CYCLES, *BOUNCES, "filepath", "samples", "seed", "resolution_x", "resolution_y",
               "resolution_percentage", "filter_width", "pixel_filter_type", "image_settings", "bake", "ffmpeg",
               "threads", "threads_mode", "adaptive_threshold", "adaptive_min_samples", "denoiser"}  # fmt: skip
# Followed wherever they are used; others are told by their name.
_FOLLOWED = (
    bpy.types.Material, bpy.types.World, bpy.types.Light, bpy.types.NodeTree, bpy.types.Image, bpy.types.Texture,
    bpy.types.Curve, bpy.types.MetaBall, bpy.types.ParticleSettings, bpy.types.Collection, bpy.types.Text,
    bpy.types.Camera, bpy.types.Curves, bpy.types.PointCloud, bpy.types.Volume, bpy.types.LightProbe,
)  # fmt: skip
_VALUES = {"FLOAT_VECTOR": "vector", "FLOAT2": "vector", "FLOAT_COLOR": "color", "BYTE_COLOR": "color"}


def fingerprinting(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Iterator[float]:
    """A digest of what Cycles sees in a view layer at the current frame, hexadecimal. Settings that a reference has of
    its own (samples, bounces, resolution) are no part of it. A generator of progress."""
    return (yield from reading(scene, view_layer, lambda depsgraph: _Digest().of(depsgraph)))


fingerprint = whole(fingerprinting)


class _Digest:
    def __init__(self):
        self.hash = hashlib.sha256()
        self.met = {}  # address -> number, so that what is met again is told by when it was met first
        self.waiting = []

    def of(self, depsgraph) -> str:
        scene, layer = depsgraph.scene_eval, depsgraph.view_layer_eval
        self.tell("frame", scene.frame_current_final)
        self.struct(scene.render, _OF_RENDERS)
        self.struct(scene.cycles, _OF_RENDERS)
        self.struct(layer.layer_collection)
        for block in (scene.world, layer.world_override, layer.material_override, scene.camera):
            self.value(block)
        for instance in in_turns(depsgraph.object_instances):
            self.tell("instance", instance.object.name_full, tuple(map(tuple, instance.matrix_world)))
            self.tell(instance.show_self, instance.random_id, tuple(instance.uv), tuple(instance.orco))
            if self.first(instance.object):
                self.struct(instance.object, {"matrix_world", "matrix_local", "bound_box"})
                self.geometry(instance.object.data)
        # A list grows while it is gone through: what is found in one block leads to the next.
        for block in in_turns(self.waiting):
            self.block(block)
        return self.hash.hexdigest()

    def tell(self, *what):
        self.hash.update(repr(what).encode())

    def first(self, struct) -> bool:
        """Whether a struct is met for the first time; told by its number either way."""
        key = (struct.as_pointer(), struct.bl_rna.identifier)
        new = key not in self.met
        self.tell(struct.bl_rna.identifier, self.met.setdefault(key, len(self.met)))
        return new

    def block(self, block):
        self.tell("block", block.name_full)
        if isinstance(block, bpy.types.Image):
            self.image(block)
        self.struct(block)
        self.attributes(block)

    def struct(self, struct, idle=frozenset()):
        if isinstance(struct, bpy.types.Node):
            idle = idle | _OF_NODES
        if isinstance(struct, bpy.types.ID):
            own = {k: v for k, v in struct.items() if k not in struct.bl_rna.properties}
            self.tell([(k, _plain(v)) for k, v in own.items() if not k.startswith(_IDLE_PREFIXES)])
        for prop in struct.bl_rna.properties:
            name = prop.identifier
            if name in _IDLE or name in idle or name.startswith(_IDLE_PREFIXES):
                continue
            self.tell(name)
            value = getattr(struct, name)
            if prop.type == "COLLECTION":
                # A mesh's and a hair system's elements go by `attributes`, as whole arrays.
                if not hasattr(struct, "attributes"):
                    for item in value:
                        self.value(item)
            elif prop.type == "POINTER":
                self.value(value)
            elif getattr(prop, "is_array", False):
                self.tell(np.asarray(value).tolist())
            else:
                self.tell(value)

    def value(self, value):
        if not isinstance(value, bpy.types.bpy_struct):
            self.tell(value)
        elif isinstance(value, bpy.types.ID):
            self.tell(value.bl_rna.identifier, value.name_full)
            if isinstance(value, bpy.types.Object):
                self.tell(tuple(map(tuple, value.matrix_world)))
            elif isinstance(value, _FOLLOWED) and self.first(value):
                self.waiting.append(value)
        elif self.first(value):
            self.struct(value)

    def geometry(self, data):
        if isinstance(data, bpy.types.Mesh) and self.first(data):
            corners = np.empty(len(data.polygons), np.int32)
            data.polygons.foreach_get("loop_total", corners)
            self.hash.update(corners)
            self.tell([uv.name for uv in data.uv_layers if uv.active_render], data.attributes.default_color_name)
            self.attributes(data)
            for material in data.materials:
                self.value(material)

    def attributes(self, data):
        for attribute in getattr(data, "attributes", ()):
            if attribute.name.startswith((".select", ".hide", "gi_")) or attribute.data_type == "STRING":
                continue
            self.tell(attribute.name, attribute.data_type, attribute.domain, len(attribute.data))
            if len(attribute.data):
                name = _VALUES.get(attribute.data_type, "value")
                width = np.size(getattr(attribute.data[0], name))
                kind = {"INT": np.int32, "BOOLEAN": bool}.get(attribute.data_type, np.float32)
                values = np.empty(len(attribute.data) * width, kind)
                attribute.data.foreach_get(name, values)
                self.hash.update(values)

    def image(self, image):
        for packed in image.packed_files:
            self.hash.update(packed.packed_file.data)
        if image.is_dirty or image.source == "GENERATED":
            values = np.empty(len(image.pixels), np.float32)
            image.pixels.foreach_get(values)
            self.hash.update(values)
        elif image.filepath and not image.packed_files:
            # By name and time: reading a film or all tiles of a picture for it would take too long.
            path = Path(bpy.path.abspath(image.filepath, library=image.library))
            found = sorted(path.parent.glob(path.name.replace("<UDIM>", "*"))) if path.parent.is_dir() else []
            self.tell([(p.name, p.stat().st_size, p.stat().st_mtime_ns) for p in found])


def _plain(value):
    """A custom property without the address that it lies at."""
    for convert in ("to_dict", "to_list"):
        if hasattr(value, convert):
            return getattr(value, convert)()
    return getattr(value, "name_full", value)
