# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Looking before baking."""

from collections.abc import Iterator

import bpy
from bpy.types import Operator

from ...gi_core.tiles import finish
from .. import asked, preferences, preflight
from ..bake import HOLDING, ON_MAIN_THREAD, making_uvs
from ..session import session
from ..stages import Stages
from .findings import failure, report
from .modal import Modal


class GI_OT_check(Modal, Operator):
    """Look for everything that would make a bake fail or come out black, without baking; takes about as long as reading the scene"""  # noqa: E501

    bl_idname = "gi.check"
    bl_label = "Check"
    bl_options = {"REGISTER"}
    holding = HOLDING

    def _begin(self, context, seen):
        return _checked(context.scene, context.view_layer)

    def _on_main(self):
        return ON_MAIN_THREAD.__contains__

    def _end(self, context, findings):
        session.found(bpy.data.scenes.get(self._scene) or context.scene, findings)
        report(self, findings)
        if any(f.severity == "ERROR" for f in findings):
            return {"CANCELLED"}
        self.report({"INFO"}, "Ready to bake")
        return {"FINISHED"}


def check(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> list[preflight.Finding]:
    """What stands in the way of what the scene's properties ask for; kept for the panel."""
    try:
        findings = finish(_checked(scene, view_layer))
    except Exception as error:
        findings = failure(error)
    session.found(scene, findings)
    return findings


def _checked(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> Iterator[tuple[float, str]]:
    """The findings; a generator of (fraction, stage)."""
    job = asked.job(scene, view_layer, device=preferences.device())
    folder = scene.gi_bake.folder if asked.needs_folder(scene, job.target) else None
    stages = Stages()
    uvs = yield from stages.announced(making_uvs(scene, view_layer, job))
    work = preflight.inspecting(
        scene, view_layer, None,
        target=job.target, objects=job.objects, uv=job.uv, output=folder, denoise=job.settings.denoise,
        glossy=job.settings.glossy, uvs=uvs,
    )  # fmt: skip
    findings, _ = yield from stages.announced(work, 0.5)
    return findings


classes = (GI_OT_check,)
