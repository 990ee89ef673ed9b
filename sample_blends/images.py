# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Small images made by formula and packed into the file, but for a sequence, which cannot be: it lies beside it."""

import tempfile
from pathlib import Path

import bpy
import numpy as np

SIZE = 64


def tiles():
    """Sixteen tiles in grout, each of its own colour; sRGB."""
    x, y = _pixels()
    column, row = (x // 16).astype(int), (y // 16).astype(int)
    hue = (5 * column + 3 * row) % 8 / 8
    rgb = 0.55 + 0.25 * np.cos(2 * np.pi * (hue[..., None] + np.array([0, 1 / 3, 2 / 3])))
    grout = (x % 16 < 1) | (y % 16 < 1)
    return _packed("Tiles", np.where(grout[..., None], 0.25, rgb))


def letter():
    """A dark F on a light ground, which shows a picture that is mirrored or turned; sRGB."""
    x, y = _pixels()
    f = (y > 8) & (y < 56) & ((x > 16) & (x < 26) | (x > 16) & (x < 48) & (y > 46)
                              | (x > 16) & (x < 40) & (y > 28) & (y < 37))
    return _packed("Letter", np.where(f[..., None], (0.55, 0.1, 0.15), (0.9, 0.85, 0.6)))


def spots():
    """A mask of soft round spots, 0…1; data, not colour."""
    x, y = _pixels()
    distance = np.hypot(x % 16 - 8, y % 16 - 8)
    return _packed("Spots", np.repeat(np.clip(6.5 - distance, 0, 1)[..., None], 3, axis=2), data=True)


def dents():
    """A tangent-space normal map of a grid of round dents; data, not colour."""
    x, y = _pixels()
    dx, dy = (x % 16 - 8) / 8, (y % 16 - 8) / 8
    slope = 0.6 * np.clip(1 - np.hypot(dx, dy), 0, None)[..., None] * np.stack([dx, dy], axis=2) * 2
    normal = np.concatenate([slope, np.ones((SIZE, SIZE, 1))], axis=2)
    normal /= np.linalg.norm(normal, axis=2, keepdims=True)
    return _packed("Dents", normal / 2 + 0.5, data=True)


def two_tiles():
    """Rings on two UDIM tiles, each of its own colour; sRGB."""
    x, y = _pixels()
    rings = np.cos(np.hypot(x - SIZE / 2, y - SIZE / 2) / 2)[..., None]
    with tempfile.TemporaryDirectory() as folder:
        for number, color in ((1001, (0.7, 0.45, 0.2)), (1002, (0.2, 0.55, 0.6))):
            _saved(Path(folder) / f"Two tiles.{number}.png", np.array(color) + 0.2 * rings)
        image = bpy.data.images.load(str(Path(folder) / "Two tiles.1001.png"))
        image.source = "TILED"
        image.filepath = str(Path(folder) / "Two tiles.<UDIM>.png")
        image.tiles.new(1002)
        image.pack()
    for file, number in zip(image.packed_files, (1001, 1002)):
        file.filepath = f"//Two tiles.{number}.png"
    image.name, image.filepath = "Two tiles", "//Two tiles.<UDIM>.png"
    return image


def frames():
    """Three frames of a bar that moves, in files; sRGB."""
    x, _ = _pixels()
    folder = Path(__file__).resolve().parent / "frames"
    folder.mkdir(exist_ok=True)
    for frame in (1, 2, 3):
        bar = np.abs(x - SIZE * frame / 4) < 6
        _saved(folder / f"bar.{frame}.png", np.where(bar[..., None], (0.85, 0.3, 0.15), (0.3, 0.35, 0.4)))
    image = bpy.data.images.load(str(folder / "bar.1.png"))
    image.name, image.source, image.filepath = "Bar", "SEQUENCE", "//frames/bar.1.png"
    return image


def _saved(path, rgb):
    image = bpy.data.images.new("saved", SIZE, SIZE)
    image.pixels.foreach_set(np.concatenate([rgb, np.ones((SIZE, SIZE, 1))], axis=2).astype(np.float32).ravel())
    image.filepath_raw, image.file_format = str(path), "PNG"
    image.save()
    bpy.data.images.remove(image)


def _pixels():
    """x and y of the pixels' middles, (SIZE, SIZE) each, row 0 at the bottom."""
    return np.meshgrid(np.arange(SIZE) + 0.5, np.arange(SIZE) + 0.5)


def _packed(name, rgb, data=False):
    image = bpy.data.images.new(name, SIZE, SIZE, is_data=data)
    image.pixels.foreach_set(np.concatenate([rgb, np.ones((SIZE, SIZE, 1))], axis=2).astype(np.float32).ravel())
    image.pack()
    return image
