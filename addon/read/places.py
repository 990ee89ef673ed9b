# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What materials may know of the object that they are on."""

from dataclasses import dataclass

import bpy
import numpy as np


@dataclass(frozen=True)
class Place:
    """What Object Info and Attribute nodes give. random: 0…1. properties: the object's own, by name."""

    name: str
    matrix: np.ndarray
    color: tuple[float, ...]
    pass_index: int
    random: float
    properties: dict[str, object]

    @staticmethod
    def of(entry: bpy.types.DepsgraphObjectInstance) -> "Place":
        """That of an evaluated instance."""
        source = entry.object
        properties = {k: source[k] for k in source.keys() if isinstance(source[k], (int, float))}
        properties |= {k: tuple(source[k]) for k in source.keys() if hasattr(source[k], "to_list")}
        # Blender tells the number of copies only.
        random = entry.random_id & 0xFFFFFFFF if entry.is_instance else _random_id(source.name)
        matrix = np.array(entry.matrix_world, np.float64)
        return Place(source.name, matrix, tuple(source.color), source.pass_index, random / 0xFFFFFFFF, properties)

    @property
    def signature(self) -> bytes:
        """All of it, as bytes."""
        return repr((self.matrix.tolist(), self.color, self.pass_index, self.random, self.properties)).encode()

    @property
    def shape(self) -> bytes:
        """How it is scaled, as bytes: the same wherever it stands and however it is turned."""
        matrix = self.matrix[:3, :3]
        return repr((np.round(matrix.T @ matrix, 5).tolist(), bool(np.linalg.det(matrix) < 0))).encode()


def _random_id(name: str) -> int:
    """The number that Cycles draws for an object by its name: Jenkins' lookup3 of a hash of the text and 0."""
    text = 0
    for byte in name.encode():
        text = (text * 37 + byte) & 0xFFFFFFFF
    start = 0xDEADBEEF + (2 << 2) + 13
    a, b, c = (start + text) & 0xFFFFFFFF, start, start

    def mixed(value: int, by: int, turn: int) -> int:
        return ((value ^ by) - ((by << turn | by >> 32 - turn) & 0xFFFFFFFF)) & 0xFFFFFFFF

    c = mixed(c, b, 14)
    a = mixed(a, c, 11)
    b = mixed(b, a, 25)
    c = mixed(c, b, 16)
    a = mixed(a, c, 4)
    b = mixed(b, a, 14)
    return mixed(c, b, 24)
