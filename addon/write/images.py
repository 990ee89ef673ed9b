# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Results as images: float data-blocks in the file, EXR and PNG files in a folder."""

import re
from pathlib import Path

import bpy
import numpy as np

from ...gi_core import display, encodings, exr, png
from ...gi_core.settings import Settings

# A custom property that marks a result of ours; its value is the name that was asked for, since Blender makes it
# "NAME.001" where the user has an image NAME.
MARK = "gi_bake_result"


def write_images(results: dict[str, np.ndarray], is_data: bool = False) -> dict[str, bpy.types.Image]:
    """Images in the file, packed so that they are saved with it: name -> (h, w, 3 or 4) float32 to name -> data-block.

    Values come back exactly. An earlier result of that name is replaced wherever it is used; an image of the user's
    never is, the result is then called "NAME.001". All images are made before the first is swapped in.
    is_data: the values are no colours (normals, positions) and are never converted. Light is kept in Blender's
        scene-linear space: the Image Editor shows it as it shows a render.
    Raises ValueError for arrays of other shapes.
    """
    for name, pixels in results.items():
        if pixels.ndim != 3 or pixels.shape[2] not in (3, 4) or 0 in pixels.shape:
            raise ValueError(f"image '{name}' needs (h, w, 3 or 4) values, not an array of shape {pixels.shape}")
    made = {}
    try:
        for name, pixels in results.items():
            made[name] = _new_image(pixels, is_data)
    except BaseException:
        bpy.data.batch_remove(list(made.values()))
        raise
    for name, image in made.items():
        _swap_in(image, name)
    return made


def save_image(folder: Path, name: str, pixels: np.ndarray, exposure: float | None = None) -> list[Path]:
    """Write FOLDER/NAME.exr, exact, and FOLDER/NAME.png, to look at; the paths. Arguments as for `save_png`."""
    path = Path(folder) / f"{file_stem(name)}.exr"
    exr.write_image(path, pixels)
    return [path, save_png(folder, name, pixels, exposure)]


def save_lightmap(folder: Path, name: str, pixels: np.ndarray, settings: Settings) -> list[Path]:
    """Write a lightmap (h, w, 4), alpha 1 where there is light, as FOLDER/NAME.exr and .png as the settings say; the
    paths. The files' metadata say what the values are."""
    path = Path(folder) / f"{file_stem(name)}.exr"
    exr.write_image(path, pixels, {"gi_bake": "E / pi, scene-linear Rec.709"}, half=settings.exr == "half")
    mask = pixels[..., 3] > 0
    exposure = settings.exposure or display.exposure_of(pixels, mask)
    values, decoding = encodings.encoded(pixels, settings.encoding, exposure, mask)
    picture = path.with_suffix(".png")
    png.write(picture, values, {"Decoding": decoding, "Values": "E / pi"}, linear=settings.encoding != "srgb")
    return [path, picture]


def save_png(folder: Path, name: str, pixels: np.ndarray, exposure: float | None = None) -> Path:
    """Write FOLDER/NAME.png, sRGB, to look at; the path.

    pixels: (h, w, 3 or 4) scene-linear; where alpha is 0 the picture is transparent. exposure: the factor that it is
        brightened by; None finds a fitting one.
    """
    path = Path(folder) / f"{file_stem(name)}.png"
    mask = pixels[..., 3] > 0 if pixels.shape[2] == 4 else None
    png.write(path, display.picture(pixels, exposure or display.exposure_of(pixels, mask), mask))
    return path


def file_stem(name: str) -> str:
    """A data-block's name as a file's, with what some file system forbids replaced."""
    return re.sub(r'[<>:"/\\|?*\x00-\x1f]', "_", name).rstrip(" .") or "_"


def _new_image(pixels, is_data):
    height, width, channels = pixels.shape
    image = bpy.data.images.new(".gi_bake", width, height, alpha=channels == 4, float_buffer=True, is_data=is_data)
    # Blender would multiply colours by alpha when it packs: empty texels would lose theirs.
    image.alpha_mode = "CHANNEL_PACKED"
    # Nothing uses a fresh result yet, and what nothing uses is not saved.
    image.use_fake_user = True
    rgba = np.ones((height, width, 4), np.float32)
    rgba[..., :channels] = pixels
    image.pixels.foreach_set(rgba.ravel())
    image.update()
    image.pack()
    return image


def _swap_in(image, name):
    image[MARK] = name
    for old in [i for i in bpy.data.images if i.get(MARK) == name and i != image and i.library is None]:
        old.user_remap(image)
        bpy.data.images.remove(old)
    image.name = name
