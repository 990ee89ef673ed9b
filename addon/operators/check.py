# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Looking before baking."""

import bpy
from bpy.types import Operator

from .. import asked, preferences, preflight
from ..session import session
from .findings import failure, report
from .poll import busy


class GI_OT_check(Operator):
    """Look for everything that would make a bake fail or come out black, without baking; takes about as long as reading the scene"""  # noqa: E501

    bl_idname = "gi.check"
    bl_label = "Check"
    bl_options = {"REGISTER"}

    @classmethod
    def poll(cls, context):
        return not busy(cls)

    def execute(self, context):
        findings = check(context.scene, context.view_layer)
        report(self, findings)
        if any(f.severity == "ERROR" for f in findings):
            return {"CANCELLED"}
        self.report({"INFO"}, "Ready to bake")
        return {"FINISHED"}


def check(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> list[preflight.Finding]:
    """What stands in the way of what the scene's properties ask for; kept for the panel."""
    try:
        job = asked.job(scene, view_layer, device=preferences.device())
        folder = scene.gi_bake.folder if asked.needs_folder(scene, job.target) else None
        findings = preflight.check(
            scene, view_layer, target=job.target, objects=job.objects, uv=job.uv, output=folder,
            denoise=job.settings.denoise, glossy=job.settings.glossy,
        )  # fmt: skip
    except Exception as error:
        findings = failure(error)
    session.found(scene, findings)
    return findings


classes = (GI_OT_check,)
