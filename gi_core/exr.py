# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Layered and plain OpenEXR files, float32, with the names that Blender gives to render passes.

A layered file holds channels "LAYER.PASS.CHANNEL" ("ViewLayer.Diffuse Direct.R"). We write one part with the long pass
names of Blender 5, which 4.5, 5.x and other tools all open; we read one part (Blender up to 4.5) and one part per pass
(Blender 5), and short pass names come out long. Arrays have row 0 at the bottom, files have it at the top.
"""

import os
from pathlib import Path

import numpy as np
import OpenEXR

# Blender up to 4.5 abbreviates pass names in files.
LONG_NAMES = {
    "DiffDir": "Diffuse Direct",
    "DiffInd": "Diffuse Indirect",
    "DiffCol": "Diffuse Color",
    "GlossDir": "Glossy Direct",
    "GlossInd": "Glossy Indirect",
    "GlossCol": "Glossy Color",
    "TransDir": "Transmission Direct",
    "TransInd": "Transmission Indirect",
    "TransCol": "Transmission Color",
    "VolumeDir": "Volume Direct",
    "VolumeInd": "Volume Indirect",
    "Emit": "Emission",
    "Env": "Environment",
    "AO": "Ambient Occlusion",
    "IndexOB": "Object Index",
    "IndexMA": "Material Index",
}
# Passes whose channels are not colours.
CHANNELS = {"Depth": "Z", "Mist": "Z", "Normal": "XYZ", "Position": "XYZ", "Vector": "XYZW", "UV": "UVA"}
# The order in which channels of a pass come, whatever the order in the file (OpenEXR sorts them by name).
CHANNEL_ORDER = "RGBXYZWUVA"


def write_layers(
    path: str | os.PathLike,
    layers: dict[str, np.ndarray],
    view_layer: str = "ViewLayer",
    metadata: dict[str, str] | None = None,
) -> None:
    """Write passes of one view layer to a multilayer EXR; the file appears whole or not at all.

    layers: pass name -> (h, w, c) or (h, w) float32; one channel is Z for Depth and X otherwise, three are RGB, or XYZ
        for Normal and Position, four are RGBA.
    metadata: header attributes, shown by Blender's Image Editor.
    Raises ValueError for passes of different sizes, channel counts other than 1, 3 and 4, and an empty `layers`;
    OSError where the file cannot be written.
    """
    channels = {}
    for name, pixels in layers.items():
        pixels = np.atleast_3d(pixels)
        letters = CHANNELS.get(name, {1: "X", 3: "RGB", 4: "RGBA"}.get(pixels.shape[2], ""))
        if len(letters) != pixels.shape[2]:
            raise ValueError(f"EXR pass {name!r} cannot have {pixels.shape[2]} channels")
        channels |= {f"{view_layer}.{name}.{c}": pixels[..., i] for i, c in enumerate(letters)}
    # Blender marks its own layered files so; some readers look for it.
    _write(path, channels, {"BlenderMultiChannel": "Blender V2.55.1 and newer"} | (metadata or {}))


def write_image(
    path: str | os.PathLike, pixels: np.ndarray, metadata: dict[str, str] | None = None, half: bool = False
) -> None:
    """Write (h, w, 3) or (h, w, 4) float32 as a plain RGB or RGBA EXR; whole or not at all, as above.

    half: 16 bits for each value; what these cannot hold becomes their largest.
    """
    if pixels.ndim != 3 or pixels.shape[2] not in (3, 4):
        raise ValueError(f"an EXR image needs 3 or 4 channels, not an array of shape {pixels.shape}")
    _write(path, {c: pixels[..., i] for i, c in enumerate("RGBA"[: pixels.shape[2]])}, metadata or {}, half)


def read_layers(path: str | os.PathLike, view_layer: str | None = None) -> dict[str, np.ndarray]:
    """Passes of one view layer: Blender 5's pass name -> (h, w, c) float32; a plain image is the pass "Combined".

    view_layer: which one; None takes the file's only one.
    Raises ValueError where there is no such view layer, or several and none was named; OSError for a file that cannot
    be read.
    """
    found = {}
    try:
        file = OpenEXR.File(os.fspath(path), separate_channels=True)
    except RuntimeError as error:
        raise OSError(f"{path}: cannot be read as an EXR: {error}") from error
    with file:
        for part in file.parts:
            for channel, value in part.channels.items():
                *layer, name, letter = (channel if "." in channel else f"Combined.{channel}").rsplit(".", 2)
                passes = found.setdefault("".join(layer), {})
                passes.setdefault(LONG_NAMES.get(name, name), {})[letter] = value.pixels
    if view_layer is None and len(found) == 1:
        (view_layer,) = found
    if view_layer not in found:
        wanted = "one to be named" if view_layer is None else repr(view_layer)
        raise ValueError(f"{path}: has the view layers {sorted(found)}, needs {wanted}")
    return {name: _stack(letters) for name, letters in found[view_layer].items()}


def _stack(channels: dict[str, np.ndarray]) -> np.ndarray:
    ordered = sorted(channels, key=lambda letter: CHANNEL_ORDER.find(letter.upper()))
    return np.stack([channels[c][::-1] for c in ordered], axis=-1).astype(np.float32, copy=False)


def _write(
    path: str | os.PathLike, channels: dict[str, np.ndarray], metadata: dict[str, str], half: bool = False
) -> None:
    sizes = {c.shape for c in channels.values()}
    if len(sizes) != 1:
        raise ValueError(f"an EXR needs channels of one size, not {sorted(sizes)}")
    header = metadata | {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    kind = np.float16 if half else np.float32
    limit = np.finfo(kind).max
    rows = {name: np.ascontiguousarray(np.clip(c[::-1], -limit, limit), kind) for name, c in channels.items()}
    path = Path(path)
    part = path.with_name(f".{path.name}.part")
    try:
        OpenEXR.File(header, rows).write(os.fspath(part))
        part.replace(path)
    except RuntimeError as error:
        raise OSError(f"{path}: cannot be written: {error}") from error
    finally:
        part.unlink(missing_ok=True)
