# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The result so far, in the Image Editors that are open; of light at vertices, in the 3D views.

The bake writes into arrays, on whatever thread it is; from them the main thread fills an image that lasts as long as
the bake. Editors that show something of the user's own are left alone.
"""

import threading
from collections.abc import Iterator

import bpy
import numpy as np

from .preview_3d import Preview3D
from .write.images import MARK

NAME = "GI Bake Preview"


class Preview:
    """Call it as `bake` calls a preview; `refresh` and `remove` belong on the main thread."""

    def __init__(self):
        self._lock = threading.Lock()
        self._canvases: dict[str, np.ndarray] = {}
        self._changed = ""
        self._before: list[tuple[bpy.types.SpaceImageEditor, str]] = []
        self.in_views = Preview3D()

    def __call__(self, name: str, rows: slice, light: np.ndarray, places: np.ndarray | None = None) -> None:
        if places is not None:
            self.in_views.put(name, rows, light, places)
            return
        with self._lock:
            canvas = self._canvases.get(name)
            width = light.shape[1]
            if canvas is None or len(canvas) < rows.stop:
                grown = np.zeros((rows.stop, width, 4), np.float32)
                grown[..., 3] = 1
                if canvas is not None:
                    grown[: len(canvas)] = canvas
                canvas = self._canvases[name] = grown
            canvas[rows, :, :3] = light
            self._changed = f"+{name}"

    def refresh(self) -> bool:
        """Shows what has come since the last time; whether there was anything."""
        drawn = self.in_views.show()
        with self._lock:
            if not self._changed:
                return drawn
            canvas = self._canvases[self._changed[1:]].copy()
            self._changed = ""
        height, width = canvas.shape[:2]
        image = bpy.data.images.get(NAME) or bpy.data.images.new(NAME, width, height, float_buffer=True)
        if tuple(image.size) != (width, height):
            image.scale(width, height)
        image.pixels.foreach_set(canvas.ravel())
        image.update()
        for window in bpy.context.window_manager.windows:
            for area, space in areas(window):
                if space.image != image and is_free(space):
                    self._before.append((space, space.image.name if space.image else ""))
                    space.image = image
                    _fit(window, area)
        return True

    def remove(self) -> None:
        """Takes the image out of the file; the editors and views show what they showed before."""
        self.in_views.remove()
        image = bpy.data.images.get(NAME)
        if image is None:
            return
        for space, name in self._before:
            if space in editors() and space.image == image:
                space.image = bpy.data.images.get(name)
        self._before.clear()
        drop()


def drop() -> None:
    """Takes the image out of the file, whoever made it."""
    if image := bpy.data.images.get(NAME):
        bpy.data.images.remove(image)


def editors() -> list[bpy.types.SpaceImageEditor]:
    """The Image Editors that are on the screen."""
    return [space for window in bpy.context.window_manager.windows for _, space in areas(window)]


def areas(window: bpy.types.Window) -> Iterator[tuple[bpy.types.Area, bpy.types.SpaceImageEditor]]:
    """A window's Image Editors with their areas."""
    for area in window.screen.areas:
        if area.type == "IMAGE_EDITOR" and area.ui_type == "IMAGE_EDITOR":
            yield area, area.spaces.active


def is_free(space: bpy.types.SpaceImageEditor) -> bool:
    """Whether an editor shows nothing of the user's own."""
    image = space.image
    return image is None or image.type == "RENDER_RESULT" or MARK in image or image.name == NAME


def show(image: bpy.types.Image) -> bool:
    """Shows an image in the first free Image Editor; whether there was one."""
    for window in bpy.context.window_manager.windows:
        for area, space in areas(window):
            if is_free(space):
                space.image = image
                _fit(window, area)
                return True
    return False


def _fit(window: bpy.types.Window, area: bpy.types.Area) -> None:
    """Lets an editor show all of its image."""
    region = next((region for region in area.regions if region.type == "WINDOW"), None)
    if region:
        with bpy.context.temp_override(window=window, area=area, region=region):
            bpy.ops.image.view_all(fit_view=True)
