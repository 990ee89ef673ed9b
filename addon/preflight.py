# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Everything that would make a bake fail or come out black, found before it starts.

The scene is looked at as it is read for the bake, so that what is said here is what happens there. Codes are part of
the interface: scripts compare them, so they keep their names.
"""

import os
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import bpy
import numpy as np

from ..gi_core import tiles
from ..gi_core.scene import Camera, Mesh, Scene, Texture
from ..gi_core.texels import outside, overlap
from ..gi_core.tiles import named, whole
from . import denoise as denoiser
from .read import reading_scene
from .read.images import ImageReader, is_there
from .read.nodes import Reading
from .read.surface_bakes import SurfaceBakes
from .sentence import Sentence, said
from .write import lightmap_uvs, volumes
from .write.attributes import AttributeTargetError, check_targets

_SURFACES = {"MESH", "CURVE", "FONT", "SURFACE", "META"}


@dataclass(frozen=True)
class Finding:
    """One thing that is wrong.

    code: stable name, UPPER_SNAKE.
    severity: "ERROR" stops a bake, "WARNING" does not.
    object: name of the object or data-block, "" where it is none.
    message, remedy: a sentence each; a `Sentence` where there is a name in it, so that it can be translated.
    """

    code: str
    severity: str
    object: str
    message: str
    remedy: str

    @property
    def told(self) -> Sentence:
        """The code and the message, for where a bake goes on."""
        return Sentence("{code}: {message}", code=self.code, message=said(self.message))


def check(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, **job) -> list[Finding]:
    """What stands in the way of a bake of `view_layer` of `scene`, errors first; `job` as for `inspected`.

    The pixels of images are not read.
    """
    findings, _ = inspected(scene, view_layer, None, **job)
    return findings


def inspecting(
    scene: bpy.types.Scene,
    view_layer: bpy.types.ViewLayer,
    images: ImageReader | None,
    target: str = "image",
    objects: Sequence[str] = (),
    uv: str = "",
    output: str | Path | None = None,
    denoise: str = "bilateral",
    glossy: bool = False,
    bakes: SurfaceBakes | None = None,
    uvs: Mapping[bpy.types.Mesh, np.ndarray] | None = None,
) -> Iterator[tuple[str, float]]:
    """What stands in the way of a bake of `view_layer` of `scene`, errors first, and the scene as it was read. A
    generator of (stage, fraction of it), "read" and "checks", of which the latter touches nothing of Blender.

    images: reads textures; with None each is one white pixel, and the scene is good for nothing but findings.
    target: "image", "lightmap", "vertices" or "volume".
    objects: names of the objects that get results; empty for all that render.
    uv: name of the UV map that lightmaps lie on; "" for each mesh's active one.
    output: path of the folder for files; None where none are written.
    denoise: how noise is taken out, as in the settings. glossy: whether glossy surfaces are baked.
    bakes: collects what of the materials is to be baked; nothing is baked here. uvs: lightmap UVs to read as if they
    were in the file.

    The file is not changed. Raises RuntimeError where Blender cannot render now.
    """
    camera = scene.camera
    findings = [*_check_output(output), *_check_libraries(), *_check_denoiser(denoise, target)]
    if target == "image" and camera is None:
        findings.append(no_camera(scene))
    if target == "volume" and not volumes.available():
        message = "This Blender was built without openvdb, which writes volumes."
        findings.append(_error("OPENVDB_MISSING", "", message, "Use Blender's own build, or bake to vertices."))
    checked = _CheckedImages(images)

    def look(core: Scene, depsgraph: bpy.types.Depsgraph):
        findings.extend(checked.findings)
        findings.extend(_check_lights(depsgraph))

    yield "read", 0.0
    work = reading_scene(
        scene, view_layer, checked, look, with_panorama=images is not None, glossy=glossy, bakes=bakes,
        lent=lightmap_uvs.lent(uvs or {}),
    )  # fmt: skip
    core = yield from named("read", work)
    findings.extend(_check_light(core, scene))
    yield "checks", 0.0
    findings.extend(_check_geometry(core, objects))
    maps = {}
    if target == "lightmap":
        meshes = {id(mesh): mesh for _, mesh in _receivers(core, objects) if (uv or mesh.active_uv) in mesh.uvs}
        meshes = list(meshes.values())

        def measure(part: slice):
            maps.update({id(mesh): _Map.of(mesh.uvs[uv or mesh.active_uv]) for mesh in meshes[part]})

        yield from named("checks", tiles.run(measure, tiles.slices(len(meshes), 1)))
    yield "read", 1.0
    findings.extend(_check_receivers(core, scene, target, objects))
    if target == "image" and camera:
        findings.extend(_check_camera(core, camera))
    if target == "lightmap":
        findings.extend(_check_uvs(core, scene, objects, uv, maps))
    if target == "vertices":
        findings.extend(_check_vertices(core, scene, objects))
    return sorted(dict.fromkeys(findings), key=lambda finding: finding.severity), core


inspected = whole(inspecting)


def no_camera(scene: bpy.types.Scene) -> Finding:
    """What is wrong where a camera is needed and there is none."""
    message = Sentence("Scene '{scene}' has no camera.", scene=scene.name)
    return _error("NO_CAMERA", "", message, "Add one and make it active.")


def _error(code: str, name: str, message: str, remedy: str) -> Finding:
    return Finding(code, "ERROR", name, message, remedy)


def _warning(code: str, name: str, message: str, remedy: str) -> Finding:
    return Finding(code, "WARNING", name, message, remedy)


def _check_output(output: str | Path | None) -> Iterator[Finding]:
    if output is None:
        return
    if str(output).startswith("//") and not bpy.data.filepath:
        message = Sentence(
            "The output folder '{folder}' is relative to the .blend file, which is not saved.", folder=output
        )
        yield _error("UNSAVED_RELATIVE_PATH", "", message, "Save the file or give an absolute path.")
        return
    folder = Path(bpy.path.abspath(str(output))).absolute()
    existing = next(path for path in (folder, *folder.parents) if path.exists())
    if not existing.is_dir() or not os.access(existing, os.W_OK | os.X_OK):
        why = "may not be written to" if existing.is_dir() else "is a file"
        message = Sentence(
            "The output folder '{folder}' cannot be used: '{there}' {why}.",
            folder=folder, there=existing, why=Sentence(why),
        )  # fmt: skip
        yield _error("OUTPUT_NOT_WRITABLE", "", message, "Choose another folder.")


def _check_libraries() -> Iterator[Finding]:
    for library in bpy.data.libraries:
        if library.is_missing:
            message = Sentence(
                "The linked file '{file}' is missing; what it holds is left out.", file=library.filepath
            )
            yield _warning("MISSING_LIBRARY", library.name, message, "Relocate the library.")


def _check_denoiser(denoise: str, target: str) -> Iterator[Finding]:
    if denoise != "oidn":
        return
    if target == "vertices":
        message = "Open Image Denoise works on images; light at vertices keeps its noise."
        yield _warning("DENOISER_NOT_USED", "", message, "Take more samples, or bake to lightmaps.")
    elif not denoiser.is_available():
        message = "This Blender was built without Open Image Denoise, or the processor is too old for it."
        yield _error("DENOISER_MISSING", "", message, "Use denoise=bilateral.")


class _CheckedImages:
    """Stands before the reader of images: keeps from it what cannot be read."""

    def __init__(self, reader: ImageReader | None):
        self.findings: list[Finding] = []
        self._reader = reader

    def texture(self, node: bpy.types.Node, reading: Reading, channels: str = "COLOR") -> Texture:
        image = node.image
        if image is None:
            message = Sentence(
                "{owner}: its image node '{node}' has no image.", owner=reading.owner, node=node.name
            )
            self.findings.append(_error("MISSING_IMAGE", node.name, message, "Choose an image or remove the node."))
        elif not is_there(node):
            message = Sentence(
                "{owner}: image '{image}' cannot be read from '{file}'.",
                owner=reading.owner, image=image.name, file=image.filepath,
            )  # fmt: skip
            self.findings.append(_error("MISSING_IMAGE", image.name, message, "Relink the file or pack it."))
        elif self._reader:
            return self._reader.texture(node, reading, channels)
        return Texture("", np.ones((1, 1, 3), np.float32))


def _check_lights(depsgraph: bpy.types.Depsgraph) -> Iterator[Finding]:
    """Lights that render and give nothing."""
    for entry in depsgraph.object_instances:
        # A mesh's data is not asked for: Blender subdivides it then.
        if entry.object.type != "LIGHT" or not entry.show_self:
            continue
        name, data, matrix = entry.object.name, entry.object.data, np.array(entry.matrix_world)
        if not _finite(matrix):
            yield _not_finite(name)
        elif data.type == "AREA" and not _light_area(data, matrix):
            message = Sentence("Area light '{name}' has no area, so it gives no light.", name=name)
            yield _error("ZERO_AREA_LIGHT", name, message, "Give it a size and a scale, or hide it in render.")
        elif not data.energy or not any(data.color):
            message = Sentence("Light '{name}' has no power or is black.", name=name)
            yield _warning("DARK_LIGHT", name, message, "Give it power, or hide it in render.")


def _light_area(data: bpy.types.AreaLight, matrix: np.ndarray) -> float:
    size_y = data.size_y if data.shape in {"RECTANGLE", "ELLIPSE"} else data.size
    return data.size * size_y * np.linalg.norm(matrix[:3, 0]) * np.linalg.norm(matrix[:3, 1])


def _check_light(core: Scene, scene: bpy.types.Scene) -> Iterator[Finding]:
    """Whether there is any light, and anything that reflects it."""
    emitted = core.environment.color.any() or any(material.emission.value.any() for material in core.materials)
    if not core.lights and not emitted:
        idle = ", ".join(f"'{there.name}'" for there in scene.objects if there.type == "LIGHT")
        message = "No light shines in render, no material emits and the world is black."
        if idle:
            message = Sentence(
                "No light shines in render, no material emits and the world is black. There is {idle}, hidden in "
                "render or without power.", idle=idle,
            )  # fmt: skip
        yield _error("NO_LIGHT", "", message, "Add a light, show one in render or give the world a colour.")
    if core.instances and not any(material.albedo.value.any() for material in core.materials):
        message = "No material has a diffuse colour, so no light is reflected."
        yield _warning("NO_DIFFUSE_SURFACE", "", message, "Give some a diffuse colour: metal and glass have none.")


def _check_geometry(core: Scene, objects: Sequence[str]) -> Iterator[Finding]:
    """Surfaces that no ray can hit."""
    finite = [_finite(mesh.vertices) for mesh in core.meshes]
    extended = [
        any(_areas(mesh.vertices[mesh.triangles[part]]).any() for part in tiles.parts(len(mesh.triangles)))
        for mesh in core.meshes
    ]
    for instance in core.instances:
        name, mesh, matrix = instance.name, core.meshes[instance.mesh], instance.matrix[:3, :3]
        if not _finite(instance.matrix):
            yield _not_finite(name)
        elif not finite[instance.mesh]:
            message = Sentence(
                "'{name}' cannot be placed. A vertex of it is infinitely far or not a number.", name=name
            )
            yield _not_finite(name, message)
        elif not extended[instance.mesh] or (
            not np.linalg.det(matrix) and not _areas((mesh.vertices @ matrix.T)[mesh.triangles]).any()
        ):
            finding = _error if name in objects else _warning
            message = Sentence("No face of '{name}' has an area.", name=name)
            yield finding("ZERO_AREA", name, message, "Give it a shape and a scale, or hide it in render.")


def _finite(values: np.ndarray) -> bool:
    """Whether numbers are ones to reckon with: their squares must fit into float32 too."""
    return bool((np.abs(values) < 1e18).all())


def _not_finite(name: str, message: str = "") -> Finding:
    matrix = Sentence(
        "'{name}' cannot be placed. Its place, rotation or scale is infinitely far or not a number.", name=name
    )
    return _error("NON_FINITE", name, message or matrix, "Repair or delete it, or hide it in render.")


def _areas(corners: np.ndarray) -> np.ndarray:
    """Areas of triangles or UV triangles, twice: (n, 3, 2 or 3) -> (n,)."""
    with np.errstate(invalid="ignore", over="ignore"):
        a, b = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
        cross = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0] if corners.shape[2] == 2 else np.cross(a, b)
        return np.abs(cross) if cross.ndim == 1 else np.linalg.norm(cross, axis=1)


def _check_receivers(core: Scene, scene: bpy.types.Scene, target: str, objects: Sequence[str]) -> Iterator[Finding]:
    """Whether what is to get results is there."""
    own = {instance.name for instance in core.instances if not instance.is_copy}
    yield from (_why_not_there(scene, name) for name in objects if name not in own)
    if not core.instances or (target in {"lightmap", "vertices"} and not own):
        message = "Nothing with a surface renders in this view layer."
        yield _error("NOTHING_TO_BAKE", "", message, "Add a mesh, or show one in render.")


def _why_not_there(scene: bpy.types.Scene, name: str) -> Finding:
    there = scene.objects.get(name)
    if there is None:
        message = Sentence("Scene '{scene}' has no object '{name}'.", scene=scene.name, name=name)
        return _error("UNKNOWN_OBJECT", name, message, "Check the spelling.")
    if there.type not in _SURFACES:
        message = Sentence("'{name}' is of type {kind}.", name=name, kind=there.type)
        return _error("NOT_A_SURFACE", name, message, "Choose a mesh.")
    if there.type == "MESH" and not there.data.polygons and not there.modifiers:
        message = Sentence("Mesh object '{name}' has no faces.", name=name)
        return _error("NO_FACES", name, message, "Give it some, or leave it out.")
    message = Sentence(
        "'{name}' does not render: it or its collection is hidden or excluded, or nothing is left of its faces.",
        name=name,
    )
    return _error("HIDDEN_IN_RENDER", name, message, "Show it in render, or leave it out.")


def _check_camera(core: Scene, camera: bpy.types.Object) -> Iterator[Finding]:
    if core.camera is None:
        message = Sentence("Camera '{name}' is neither perspective nor orthographic.", name=camera.name)
        yield _error("UNSUPPORTED_CAMERA", camera.name, message, "Change its type.")
    elif not _finite(core.camera.matrix):
        yield _not_finite(camera.name)
    elif core.instances and not _sees(core.camera, core):
        message = Sentence("Camera '{name}' sees no surface.", name=camera.name)
        yield _warning("NOTHING_IN_VIEW", camera.name, message, "Turn it to the scene, or look at its clip distances.")


def _sees(camera: Camera, core: Scene) -> bool:
    """Whether the bounding box of any instance may be in the camera's view."""
    bounds = np.array([[mesh.vertices.min(0), mesh.vertices.max(0)] for mesh in core.meshes], np.float64)
    pick = np.indices((2, 2, 2)).reshape(3, 8)
    corners = np.stack([bounds[:, pick[axis], axis] for axis in range(3)] + [np.ones((len(bounds), 8))], 1)
    matrices = np.linalg.inv(camera.matrix) @ [instance.matrix for instance in core.instances]
    x, y, z, _ = np.moveaxis(matrices @ corners[[instance.mesh for instance in core.instances]], 1, 0)
    depth = -z if camera.kind == "PERSPECTIVE" else 1.0
    left, right, bottom, top = camera.window
    near, far = camera.clip
    outside = [x < left * depth, x > right * depth, y < bottom * depth, y > top * depth, -z < near, -z > far]
    return not np.any([side.all(1) for side in outside], axis=0).all()


def _receivers(core: Scene, objects: Sequence[str]) -> Iterator[tuple[str, Mesh]]:
    """Name and mesh of each object that results are for."""
    for instance in core.instances:
        if not instance.is_copy and (instance.name in objects if objects else instance.receives):
            yield instance.name, core.meshes[instance.mesh]


@dataclass(frozen=True)
class _Map:
    """How lightmaps lie on a UV map. area: of all faces. outside: share of it in faces that leave the unit square.
    overlap: share of what is covered that several faces cover."""

    area: float
    outside: float
    overlap: float

    @staticmethod
    def of(uvs: np.ndarray) -> "_Map":
        return _Map(_areas(uvs).sum() / 2, outside(uvs), overlap(uvs, lightmap_uvs.ROUGHLY))


def _check_uvs(
    core: Scene, scene: bpy.types.Scene, objects: Sequence[str], uv: str, maps: dict[int, _Map]
) -> Iterator[Finding]:
    """maps: how they lie, by the identity of the mesh; without those that have none."""
    for name, mesh in _receivers(core, objects):
        chosen = uv or mesh.active_uv
        lies = maps.get(id(mesh))
        if lies is None:
            why, remedy = _why_no_map(scene.objects[name])
            message = Sentence("'{name}' has no UV map{why}.", name=name, why=why)
            if uv:
                message = Sentence("'{name}' has no UV map '{map}'{why}.", name=name, map=uv, why=why)
            yield _error("NO_UV_MAP", name, message, Sentence("{remedy} Or leave it out.", remedy=Sentence(remedy)))
            continue
        if not lies.area > 0:
            message = Sentence("No face of '{name}' has an area on UV map '{map}'.", name=name, map=chosen)
            yield _error("EMPTY_UV_MAP", name, message, "Unwrap it.")
        elif share := lies.outside:
            message = Sentence(
                "{share:.1%} of UV map '{map}' of '{name}' is in faces that leave the unit square: not baked.",
                share=share, map=chosen, name=name,
            )  # fmt: skip
            yield _warning("UV_OUTSIDE", name, message, "Pack the islands, or bake to another UV map.")
        elif (share := lies.overlap) > lightmap_uvs.TOLERANCE:
            message = Sentence(
                "Faces of '{name}' overlap on {share:.1%} of UV map '{map}' and share their light there.",
                name=name, share=share, map=chosen,
            )  # fmt: skip
            remedy = "Unwrap it without overlaps, or bake to another UV map; apply modifiers that copy faces."
            yield _warning("UV_OVERLAP", name, message, remedy)


def _why_no_map(obj: bpy.types.Object) -> tuple[str, str]:
    """Why an object has no lightmap UVs, as the end of a sentence, and the remedy."""
    if obj.type != "MESH":
        return Sentence(": it is of type {kind}", kind=obj.type), "Convert it to a mesh."
    if reason := lightmap_uvs.why_not(obj.data):
        return Sentence(": {reason}", reason=Sentence(reason[0])), reason[1]
    if obj.modifiers:
        return Sentence(": its modifiers make faces without one"), "Apply them."
    return "", "Unwrap it."


def _check_vertices(core: Scene, scene: bpy.types.Scene, objects: Sequence[str]) -> Iterator[Finding]:
    """Whether results can be written to the vertices of the meshes as the user made them."""
    for name, mesh in _receivers(core, objects):
        there, remedy = scene.objects[name], "Leave the object out, or bake to a lightmap."
        try:
            check_targets([there])
        except AttributeTargetError as error:
            yield _error("VERTICES_NOT_WRITABLE", name, Sentence("{reason}.", reason=error.args[0]), remedy)
            continue
        if len(there.data.vertices) != len(mesh.vertices):
            message = Sentence(
                "Modifiers change the number of vertices of '{name}', so light cannot go to them.", name=name
            )
            remedy = "Apply the modifiers, leave the object out, or bake to a lightmap."
            yield _error("VERTICES_MODIFIED", name, message, remedy)
