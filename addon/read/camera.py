# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The camera: lens, sensor and lens shift as a window on the plane z = −1."""

from collections.abc import Iterator, Sequence

import bpy
import numpy as np

from ...gi_core.scene import Camera
from ...gi_core.settings import SettingError
from ..sentence import Sentence
from .render_depsgraph import reading


def reading_cameras(
    scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer, names: Sequence[str]
) -> Iterator[float]:
    """Cameras by their objects' names, as a render at the current frame has them. A generator of progress; returns a
    list of Camera.

    Raises SettingError for a name that is no camera's, or that of one which is not baked.
    """
    if not names:
        return []

    def read(depsgraph: bpy.types.Depsgraph) -> list[Camera]:
        render = depsgraph.scene_eval.render
        return [read_camera(scene.objects[name].evaluated_get(depsgraph), render, []) for name in names]

    for name in names:
        if name not in scene.objects or scene.objects[name].type != "CAMERA":
            raise SettingError(f"'{name}' is no camera of scene '{scene.name}'")
    cameras = yield from reading(scene, view_layer, read)
    for name, camera in zip(names, cameras):
        if camera is None:
            raise SettingError(f"camera '{name}' is neither perspective nor orthographic")
    return cameras


def read_camera(camera: bpy.types.Object, render: bpy.types.RenderSettings, notes: list[str]) -> Camera | None:
    """`camera`, an evaluated object, at the resolution of `render`; None where it is panoramic or no camera.

    The render border is ignored. What the bake does not have (depth of field, panoramas) is told in `notes`.
    """
    data = camera.data
    if camera.type != "CAMERA" or data.type not in {"PERSP", "ORTHO"}:
        notes.append(
            Sentence(
                "Camera '{name}': only perspective and orthographic cameras are baked; it is left out.",
                name=camera.name,
            )
        )  # fmt: skip
        return None
    if data.dof.use_dof:
        notes.append(Sentence("Camera '{name}': depth of field is left out.", name=camera.name))
    width = render.resolution_x * render.resolution_percentage // 100
    height = render.resolution_y * render.resolution_percentage // 100
    pixel = render.pixel_aspect_y / render.pixel_aspect_x
    fit = data.sensor_fit
    if fit == "AUTO":
        fit = "HORIZONTAL" if width >= height * pixel else "VERTICAL"
    # Lens and shift count in the side that the sensor is fitted to; an automatic fit takes the sensor's width for both.
    side = width if fit == "HORIZONTAL" else height * pixel
    sensor = data.sensor_height if data.sensor_fit == "VERTICAL" else data.sensor_width
    unit = (data.ortho_scale if data.type == "ORTHO" else sensor / data.lens) / side
    x, y = data.shift_x * side, data.shift_y * side
    half_width, half_height = width / 2, height * pixel / 2
    matrix = np.array(camera.matrix_world, np.float64)
    with np.errstate(invalid="ignore"):  # a camera scaled to nothing is the preflight's to refuse
        matrix[:3, :3] /= np.linalg.norm(matrix[:3, :3], axis=0)
    return Camera(
        kind="ORTHOGRAPHIC" if data.type == "ORTHO" else "PERSPECTIVE",
        matrix=matrix,
        window=tuple(float(edge * unit) for edge in (x - half_width, x + half_width, y - half_height, y + half_height)),
        resolution=(width, height),
        clip=(data.clip_start, data.clip_end),
    )
