# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Arrays on the graphics card, as textures: Blender has no storage buffers.

A texture has WIDTH texels in a row, an item after the other, with the last axis in their channels. Whole numbers lie in
them as floats, exact up to 2²⁴.
"""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

if TYPE_CHECKING:
    from .device import GpuDevice

WIDTH_BITS = 11
WIDTH = 1 << WIDTH_BITS

# Formats by channels. Three are stored as four: cards write no images of three.
FORMATS = {1: "R32F", 2: "RG32F", 3: "RGBA32F", 4: "RGBA32F"}


@dataclass(frozen=True)
class GpuArray:
    """An array on the graphics card. channels: numbers in a texel; shape, kind: of what numpy makes of it; store: where
    its texels are, which arrays of other shapes may share."""

    store: "Store"
    shape: tuple[int, ...]
    channels: int
    kind: np.dtype

    def __len__(self) -> int:
        return self.shape[0]

    def __getitem__(self, part: slice) -> "GpuArray":
        if (part.start or 0, part.stop) not in ((0, None), (0, self.shape[0])):
            raise IndexError("arrays on the graphics card are worked on whole")
        return self

    def reshape(self, *shape: int) -> "GpuArray":
        """The same numbers in another shape, of which one side may be −1."""
        known = -int(np.prod(shape, dtype=np.int64))
        size = int(np.prod(self.shape, dtype=np.int64))
        return replace(self, shape=tuple(size // max(known, 1) if n < 0 else n for n in shape))

    @property
    def items(self) -> int:
        """Texels."""
        return int(np.prod(self.shape, dtype=np.int64)) // self.channels

    @property
    def texture(self):
        """Its texels on the card."""
        return self.store.there()


@dataclass(eq=False)
class Store:
    """Texels that are on the card while they are worked on, and here before, or while others need the room there.

    key: width, height and format. here: (width · height · channels,) float32. texture: there. is_made: whether there is
    anything to keep. is_kept: whether the texture is for others once nobody has it any more.
    """

    device: "GpuDevice"
    key: tuple[int, int, str]
    is_kept: bool
    here: np.ndarray | None = None
    texture: object = None
    is_made: bool = False

    def there(self, beside: "set[Store]" = frozenset()):
        """Its texture, now on the card. beside: what has to be there as well."""
        device = self.device
        if self.texture is None:
            pool = device.pools.get(self.key, ())
            if pool and self.here is None:
                self.texture = pool.pop()
            else:
                self.texture = device.texture(self.key, self.here, beside)
            self.here = None
        # The last one is the last that was needed.
        device.stores.pop(self, None)
        device.stores[self] = True
        return self.texture

    def read(self) -> np.ndarray:
        """Its texels, flat."""
        if self.texture is None:
            return np.zeros(size_of(self.key) // 4, np.float32) if self.here is None else self.here
        self.device.moved += size_of(self.key)
        buffer = self.texture.read()
        # Before Blender 5.2 the strides of a buffer of more than one dimension are wrong.
        buffer.dimensions = int(np.prod(buffer.dimensions))
        return np.array(buffer, np.float32)

    def leave(self) -> None:
        """Makes room on the card."""
        self.here = self.read() if self.is_made else None
        self.texture = None
        self.device.stores.pop(self, None)
        self.device.bytes -= size_of(self.key)

    def __del__(self):
        if self.texture is None:
            return
        if self.is_kept:
            self.device.pools.setdefault(self.key, []).append(self.texture)
        else:
            self.device.bytes -= size_of(self.key)


def extent(items: int) -> tuple[int, int]:
    """Width and height of a texture of so many texels."""
    return min(max(items, 1), WIDTH), max(1, -(-items // WIDTH))


def size_of(key: tuple[int, int, str]) -> int:
    """Bytes of a texture of a width, a height and a format."""
    return 4 * key[0] * key[1] * {"R32F": 1, "RG32F": 2, "RGBA32F": 4, "DEPTH_COMPONENT32F": 1}[key[2]]
