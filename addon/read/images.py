# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Images: a Blender image as scene-linear pixels, each read once."""

from pathlib import Path
from typing import TYPE_CHECKING

import bpy
import numpy as np

from ...gi_core.scene import Texture
from ...gi_core.texture import srgb_to_linear
from ..sentence import Sentence

if TYPE_CHECKING:
    from .nodes import Reading

# Colour spaces of byte images whose values need no conversion.
_LINEAR_SPACES = {"Non-Color", "Generic Data", "Raw", "Linear", "Linear Rec.709", "scene_linear"}

# Sources of images that change with time.
_MOVING = {"SEQUENCE", "MOVIE"}


class ImageReader:
    """Textures of Image and Environment Texture nodes, kept so that no image is converted twice."""

    def __init__(self):
        self._pixels = {}
        self._textures = {}

    def texture(self, node: bpy.types.Node, reading: "Reading", channels: str = "COLOR") -> Texture:
        """The `Texture` of a node, of its "COLOR" or, as a grey, its "ALPHA".

        Raises ValueError where it has no image or the image cannot be loaded.
        """
        image = node.image
        if image is None:
            raise ValueError(f"{reading.owner}: node '{node.name}' has no image: choose one or remove the node")
        if not is_known_space(image):
            space = image.colorspace_settings.name
            reading.note(
                Sentence("image '{image}' of colour space {space} is taken as sRGB", image=image.name, space=space)
            )
        if not is_there(node):
            ways = "relink it" if image.source in _MOVING else "relink or pack it"
            raise ValueError(f"Image '{image.name}' cannot be read from '{image.filepath}': {ways}")
        if image.source in _MOVING:  # only what renders shows the frame of the current time
            return Texture(image.name, np.full((1, 1, 3), 0.5, np.float32))
        # Cycles multiplies colours by alpha, unless the node's alpha is used, or is no alpha but a channel of data.
        by_alpha = image.alpha_mode == "STRAIGHT" and not node.outputs[-1].is_linked
        extension = getattr(node, "extension", "REPEAT")
        interpolation = "CLOSEST" if node.interpolation == "Closest" else "LINEAR"
        key = (image.original.as_pointer(), channels if channels == "ALPHA" else by_alpha, extension, interpolation)
        if key not in self._textures:
            if key[:2] not in self._pixels:
                alpha = channels == "ALPHA"
                read = (read_alpha(image.original), None) if alpha else read_pixels(image.original, by_alpha)
                self._pixels[key[:2]] = read
            pixels, encoded = self._pixels[key[:2]]
            self._textures[key] = Texture(image.name, pixels, extension, interpolation, encoded)
        return self._textures[key]


def is_there(node: bpy.types.Node) -> bool:
    """Whether what the image of an evaluated node is read from is there."""
    image = node.image.original  # it keeps what is loaded to answer this
    if image.source in _MOVING:  # what is packed is one frame, of which Blender takes no notice
        return Path(bpy.path.abspath(image.filepath_from_user(image_user=node.image_user))).is_file()
    return bool(image.size[0])


def is_known_space(image: bpy.types.Image) -> bool:
    """Whether the colours of an image are read as Cycles reads them."""
    return image.is_float or image.colorspace_settings.name in {"sRGB", *_LINEAR_SPACES}


def read_pixels(image: bpy.types.Image, by_alpha: bool) -> tuple[np.ndarray, np.ndarray | None]:
    """Scene-linear (h, w, 3) float32 of a `bpy.types.Image`, row 0 at the bottom, multiplied by alpha where asked, and
    the sRGB bytes (h, w, 3) that they were decoded from, None where they were not.

    Raises ValueError where the image has no pixels.
    """
    pixels = _all_channels(image)
    color = pixels[..., :3] if image.channels >= 3 else np.repeat(pixels[..., :1], 3, axis=2)
    if image.is_float or image.colorspace_settings.name in _LINEAR_SPACES:
        # Floats are scene-linear and multiplied by alpha since they were loaded.
        return np.ascontiguousarray(color), None
    if by_alpha and image.channels == 4:
        color = color * pixels[..., 3:]  # before the transfer function is undone, as Cycles does
    encoded = (color * 255 + 0.5).astype(np.uint8)
    return _SRGB_TO_LINEAR[encoded], encoded


def read_alpha(image: bpy.types.Image) -> np.ndarray:
    """The alpha of a `bpy.types.Image` as a grey (h, w, 3) float32, row 0 at the bottom; 1 where it has none.

    Raises ValueError where the image has no pixels.
    """
    pixels = _all_channels(image)
    alpha = pixels[..., 3:].copy() if image.channels == 4 else np.ones((*pixels.shape[:2], 1), np.float32)
    if image.alpha_mode == "NONE":
        alpha[:] = 1
    return np.broadcast_to(alpha, (*pixels.shape[:2], 3))


def _all_channels(image: bpy.types.Image) -> np.ndarray:
    width, height = image.size
    if not width * height * image.channels:
        raise ValueError(f"Image '{image.name}' cannot be read from '{image.filepath}': relink or pack it")
    pixels = np.empty((height, width, image.channels), np.float32)
    image.pixels.foreach_get(pixels.reshape(-1))
    return pixels


# Of each value that a byte can have.
_SRGB_TO_LINEAR = srgb_to_linear(np.arange(256) / 255).astype(np.float32)
