# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Meshes with pictures on them as binary glTF 2.0, unlit (KHR_materials_unlit): viewers show what is baked and no more.

Positions stay in metres; a node above all turns Z up into glTF's Y up.
"""

import json
import os
import struct
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

_UNSIGNED, _FLOAT = 5125, 5126
_VERTICES, _INDICES = 34962, 34963


@dataclass(frozen=True)
class Part:
    """An object: corners (t, 3, 3) float32 positions, normals and (t, 3, 2) uvs of its triangles, and where it stands.

    matrix: (4, 4). picture: number of the picture that its uvs are on.
    """

    name: str
    corners: np.ndarray
    normals: np.ndarray
    uvs: np.ndarray
    matrix: np.ndarray
    picture: int


def write(
    path: str | os.PathLike, parts: Sequence[Part], pictures: Sequence[tuple[str, bytes]], extras: dict | None = None
) -> None:
    """Write a .glb; the file appears whole or not at all.

    pictures: names and PNG files. extras: kept with the file, for who reads it.
    """
    data = _Data()
    images = [{"name": name, "mimeType": "image/png", "bufferView": data.view(png)} for name, png in pictures]
    materials = [
        {
            "name": name,
            "pbrMetallicRoughness": {"baseColorTexture": {"index": k}, "metallicFactor": 0, "roughnessFactor": 1},
            "extensions": {"KHR_materials_unlit": {}},
        }
        for k, (name, _) in enumerate(pictures)
    ]
    meshes, nodes = [], []
    for part in parts:
        primitive = {"attributes": {}, "material": part.picture}
        values = np.concatenate([part.corners, part.normals, part.uvs], -1).reshape(-1, 8).astype(np.float32)
        values, index = np.unique(values, axis=0, return_inverse=True)
        position, normal, uv = values[:, :3], values[:, 3:6], values[:, 6:] * (1, -1) + (0, 1)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        normal = np.where(length > 0, normal / np.maximum(length, 1e-20), (0, 0, 1))
        primitive["attributes"] = {
            "POSITION": data.vectors(position), "NORMAL": data.vectors(normal), "TEXCOORD_0": data.vectors(uv),
        }  # fmt: skip
        primitive["indices"] = data.indices(index)
        meshes.append({"name": part.name, "primitives": [primitive]})
        # Column by column.
        nodes.append({"name": part.name, "mesh": len(meshes) - 1, "matrix": np.asarray(part.matrix).T.ravel().tolist()})
    half = float(np.sqrt(0.5))
    nodes.append({"name": "Baked", "rotation": [-half, 0, 0, half], "children": list(range(len(parts)))})
    document = {
        "asset": {"version": "2.0", "generator": "GI Bake", "extras": extras or {}},
        "extensionsUsed": ["KHR_materials_unlit"],
        "scene": 0,
        "scenes": [{"nodes": [len(nodes) - 1]}],
        "nodes": nodes,
        "meshes": meshes,
        "materials": materials,
        "textures": [{"source": k, "sampler": 0} for k in range(len(images))],
        # Linear, clamped at the border.
        "samplers": [{"magFilter": 9729, "minFilter": 9729, "wrapS": 33071, "wrapT": 33071}],
        "images": images,
        "accessors": data.accessors,
        "bufferViews": data.views,
        "buffers": [{"byteLength": len(data.bytes)}],
    }
    text = json.dumps(document, separators=(",", ":")).encode()
    chunks = _chunk(b"JSON", text, b" ") + _chunk(b"BIN\0", bytes(data.bytes), b"\0")
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(b"glTF" + struct.pack("<II", 2, 12 + len(chunks)) + chunks)
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


class _Data:
    """The binary part, and what says where everything lies in it."""

    def __init__(self):
        self.bytes, self.views, self.accessors = bytearray(), [], []

    def view(self, content: bytes, target: int | None = None) -> int:
        self.bytes += b"\0" * (-len(self.bytes) % 4)
        kind = {"target": target} if target else {}
        self.views.append({"buffer": 0, "byteOffset": len(self.bytes), "byteLength": len(content), **kind})
        self.bytes += content
        return len(self.views) - 1

    def vectors(self, values: np.ndarray) -> int:
        values = np.ascontiguousarray(values, np.float32)
        return self._accessor(values, f"VEC{values.shape[1]}", _FLOAT, _VERTICES)

    def indices(self, values: np.ndarray) -> int:
        return self._accessor(np.ascontiguousarray(values.reshape(-1, 1), np.uint32), "SCALAR", _UNSIGNED, _INDICES)

    def _accessor(self, values: np.ndarray, kind: str, component: int, target: int) -> int:
        self.accessors.append(
            {
                "bufferView": self.view(values.tobytes(), target), "componentType": component, "count": len(values),
                "type": kind, "min": values.min(0).tolist(), "max": values.max(0).tolist(),
            }
        )  # fmt: skip
        return len(self.accessors) - 1


def _chunk(kind: bytes, content: bytes, padding: bytes) -> bytes:
    content += padding * (-len(content) % 4)
    return struct.pack("<I", len(content)) + kind + content
