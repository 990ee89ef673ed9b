# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""8-bit PNG files (W3C PNG, third edition) out of arrays, so that a picture needs no other library."""

import os
import struct
import zlib
from pathlib import Path

import numpy as np


def encode(pixels: np.ndarray, text: dict[str, str] | None = None, linear: bool = False) -> bytes:
    """(h, w, 3) or (h, w, 4) uint8, row 0 at the bottom, as the bytes of a PNG file.

    text: keyword -> sentence, kept with the picture. linear: values are no sRGB colours.
    """
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or pixels.dtype != np.uint8:
        raise ValueError(f"a PNG needs (h, w, 3 or 4) uint8, not {pixels.shape} {pixels.dtype}")
    height, width, channels = pixels.shape
    # Filter 1 (Sub): each byte minus the one of the pixel to the left, so that smooth pictures compress.
    rows = np.empty((height, 1 + width * channels), np.uint8)
    rows[:, 0] = 1
    top_down = pixels[::-1]
    rows[:, 1:] = np.diff(top_down, axis=1, prepend=np.uint8(0)).reshape(height, -1)
    color_type = {3: 2, 4: 6}[channels]
    header = struct.pack(">IIBBBBB", width, height, 8, color_type, 0, 0, 0)
    space = (b"gAMA", struct.pack(">I", 100000)) if linear else (b"sRGB", b"\0")
    told = [(b"iTXt", k.encode("latin-1") + b"\0\0\0\0\0" + v.encode()) for k, v in (text or {}).items()]
    chunks = [(b"IHDR", header), space, *told, (b"IDAT", zlib.compress(rows.tobytes())), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(_chunk(kind, data) for kind, data in chunks)


def write(
    path: str | os.PathLike, pixels: np.ndarray, text: dict[str, str] | None = None, linear: bool = False
) -> None:
    """Write what `encode` gives; the file appears whole or not at all."""
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        part.write_bytes(encode(pixels, text, linear))
        part.replace(path)
    finally:
        part.unlink(missing_ok=True)


def _chunk(kind: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))
