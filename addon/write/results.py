# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""A bake's result put where it is wanted: data-blocks in the open file, files in a folder."""

from pathlib import Path

import bpy
import numpy as np

from ...gi_core import display, exr, glb, png
from ..result import Light, Result
from . import lightmap_uvs
from .attributes import write_corners, write_coverage, write_irradiance
from .images import file_stem, save_image, save_lightmap, save_png, write_images
from .placement import HASH, LIGHT, remember
from .volumes import save_volume, store_volume

# What the images of a directional lightmap hold.
HARMONICS = (
    "coefficients of E / pi over the world normal (x, y, z), scene-linear Rec.709: "
    "E / pi = 0.282095 c0 - 0.488603 y c1 + 0.488603 z c2 - 0.488603 x c3"
)


def store(result: Result, scene: bpy.types.Scene, folder: Path | None = None) -> list[str]:
    """Puts a result into the open file, replacing an earlier one; the names of what holds it.

    A camera image becomes the images "SCENE GI" and "SCENE GI Indirect", a lightmap "NAME Lightmap" after the object or
    what else lies on it, which remember it (see `placement`), light at vertices the attribute `gi_irradiance`
    (E [W/m²]) of the object's mesh, or `gi_irradiance_corner` of its face corners, a volume the object
    "SCENE GI Volume", which reads the file that `export` writes into the folder. Lightmap UVs that were made for the
    bake become the meshes' UV map "GI Lightmap".
    Raises ValueError, before anything is written, where a mesh was changed so that its UVs do not fit.
    """
    target = result.job.target
    if target == "image":
        layers = result.layers
        made = write_images(
            {f"{scene.name} GI": layers["Combined"], f"{scene.name} GI Indirect": layers["Diffuse Indirect"]}
        )
        return [image.name for image in made.values()]
    if target == "lightmap":
        return [image.name for image in _store_lightmaps(result, scene)]
    if target == "volume":
        return [store_volume(folder / "volume.vdb", result.volume, scene, result.job.settings.blend).name]
    irradiance = {name: np.float32(np.pi) * wanted(light, result) for name, light in result.light.items()}
    if result.job.settings.domain == "corner":
        write_corners(irradiance, {name: light.corners.vertex for name, light in result.light.items()})
    else:
        write_irradiance(irradiance)
        write_coverage({name: light.coverage for name, light in result.light.items() if light.coverage is not None})
    for name in result.light:
        bpy.data.objects[name].data[LIGHT] = result.job.settings.light
    return list(result.light)


def _store_lightmaps(result: Result, scene: bpy.types.Scene) -> list[bpy.types.Image]:
    lightmap_uvs.put_all({bpy.data.meshes[name, None]: uvs for name, uvs in result.uvs.items()})
    maps = {f"{name} Lightmap": pixels for name, pixels in lightmaps(result).items()} | coverages(result)
    made = write_images(maps) | write_images(harmonics(result), is_data=True)
    for page in result.pages:
        image = made[f"{page.name} Lightmap"]
        image[LIGHT] = result.job.settings.light
        for place in page.places:
            remember(scene.objects[place.name], image, page, place)
            scene.objects[place.name][HASH] = result.hashes.get(place.name, "")
    return list(made.values())


def export(result: Result, folder: Path, view_layer: str) -> list[Path]:
    """Writes a result's images into a folder; the paths. Light at vertices has no image and stays in the file."""
    folder.mkdir(parents=True, exist_ok=True)
    if result.job.target == "image":
        path = folder / "image.exr"
        exr.write_layers(path, result.layers, view_layer)
        return [path, save_png(folder, "image", result.layers["Combined"])]
    if result.job.target == "volume":
        return [save_volume(folder / "volume.vdb", result.volume, result.job.settings.half)]
    paths, taken = [], set()

    def stem(name: str) -> str:
        """A name that no other file here has: names may differ in what a file's name cannot show, or only in case."""
        found, number = name, 1
        while file_stem(found).lower() in taken:
            number += 1
            found = f"{name} {number}"
        taken.add(file_stem(found).lower())
        return found

    for name, pixels in lightmaps(result).items():
        paths += save_lightmap(folder, stem(f"{name} Lightmap"), pixels, result.job.settings)
    for name, pixels in coverages(result).items():
        paths += save_image(folder, stem(name), pixels)
    if result.meshes:
        paths.append(save_gltf(folder / "baked.glb", result))
    for name, pixels in harmonics(result).items():
        paths.append(folder / f"{file_stem(stem(name))}.exr")
        exr.write_image(paths[-1], pixels, {"gi_bake": HARMONICS})
    return paths


def save_gltf(path: Path, result: Result) -> Path:
    """Writes the baked objects with what they send out as pictures on them, unlit; the path.

    The pictures are sRGB and clipped at white; the file's extras hold the exposure, of all alike.
    """
    lights = [result.light[page.name] for page in result.pages]
    seen = np.concatenate([light.radiance[light.valid] for light in lights])
    exposure = result.job.settings.exposure or display.exposure_of(seen)
    pictures = [
        (page.name, png.encode(display.picture(light.radiance, exposure)))
        for page, light in zip(result.pages, lights)
    ]
    parts = []
    for k, page in enumerate(result.pages):
        for place in page.places:
            mesh, matrix = result.meshes[place.name]
            uvs = place.on(mesh.uvs[place.uv], page.width, page.height)
            parts.append(glb.Part(place.name, mesh.vertices[mesh.triangles], mesh.normals, uvs, matrix, k))
    glb.write(path, parts, pictures, {"exposure": exposure})
    return path


def wanted(light: Light, result: Result) -> np.ndarray:
    """The light that the settings ask for, E/π: (h, w, 3) or (v, 3) float32."""
    return result.job.settings.wanted(light.direct, light.indirect)


def lightmaps(result: Result) -> dict[str, np.ndarray]:
    """Name of a page -> (h, w, 4) float32: E/π, islands grown by the margin, alpha 1 where there is a value."""
    maps = {}
    for name, light in result.light.items():
        if light.valid.ndim == 2:
            filled = light.filled
            maps[name] = np.dstack([np.where(filled[..., None], wanted(light, result), 0), filled.astype(np.float32)])
    for name, before in result.kept.items():
        maps[name] = np.where(maps[name][..., 3:] > 0, maps[name], before) if name in maps else before
    return maps


def coverages(result: Result) -> dict[str, np.ndarray]:
    """"OBJECT Coverage" -> (h, w, 3) float32, how surely a camera saw each texel, 0…1; empty where none was asked."""
    return {
        f"{name} Coverage": np.repeat(light.coverage[..., None], 3, -1)
        for name, light in result.light.items()
        if light.coverage is not None and light.coverage.ndim == 2
    }


def harmonics(result: Result) -> dict[str, np.ndarray]:
    """"NAME SH 0" … 3 -> (h, w, 3) float32 of directional lightmaps, see HARMONICS."""
    return {
        f"{name} SH {k}": np.where(light.filled[..., None], light.directional[..., k, :], 0)
        for name, light in result.light.items()
        if light.directional is not None
        for k in range(4)
    }
