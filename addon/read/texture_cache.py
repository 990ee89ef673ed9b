# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Baked textures kept on disk from one bake to the next, by a hash of all that they depend on."""

import contextlib
import os
import tempfile
from pathlib import Path

import bpy
import numpy as np

# What the folder holds at most [bytes]; what was not used for longest goes first.
_LIMIT = 1 << 30

# What half floats hold.
_HALF = 65000.0

_chosen: list[Path] = []


def use_folder(folder: Path | None) -> None:
    """Takes another default folder; None for the usual one."""
    _chosen[:] = [folder] if folder else []


def default_folder() -> Path:
    """$GI_BAKE_CACHE, or what `use_folder` said, or where Blender keeps what it can make again, or else where the
    system does."""
    if told := os.environ.get("GI_BAKE_CACHE"):
        return Path(told)
    if _chosen:
        return _chosen[0]
    base = getattr(bpy.app, "cachedir", "") or tempfile.gettempdir()
    return Path(base) / "gi_bake" / "materials"


class TextureCache:
    """Arrays (h, w, 3) float32 in a folder, None for none. One that cannot be used is as good as an empty one."""

    def __init__(self, folder: Path | None):
        self._folder = folder

    def load(self, key: str) -> np.ndarray | None:
        """What was kept by a key, None where nothing was."""
        if self._folder is None:
            return None
        file = self._folder / f"{key}.npy"
        try:
            pixels = np.load(file, allow_pickle=False)
            os.utime(file)
        except (OSError, ValueError, EOFError):
            return None
        return pixels.astype(np.float32) if pixels.ndim == 3 else None

    def save(self, key: str, pixels: np.ndarray) -> np.ndarray:
        """Keeps an array, and returns it as it will be loaded, folder or not: half floats have to do where they can."""
        kept = pixels.astype(np.float16) if np.abs(pixels).max(initial=0) < _HALF else pixels
        if self._folder is not None:
            self._write(key, kept)
        return kept.astype(np.float32)

    def _write(self, key: str, pixels: np.ndarray) -> None:
        part = self._folder / f".{key}.{os.getpid()}.part"
        with contextlib.suppress(OSError):
            self._folder.mkdir(parents=True, exist_ok=True)
            try:
                with part.open("wb") as out:
                    np.save(out, pixels)
                part.replace(self._folder / f"{key}.npy")
            finally:
                part.unlink(missing_ok=True)

    def trim(self) -> None:
        """Makes room again."""
        if self._folder is None:
            return
        with contextlib.suppress(OSError):
            states = {file: file.stat() for file in self._folder.glob("*.npy")}
            size = sum(state.st_size for state in states.values())
            for file in sorted(states, key=lambda file: states[file].st_mtime):
                if size <= _LIMIT:
                    break
                size -= states[file].st_size
                file.unlink(missing_ok=True)
