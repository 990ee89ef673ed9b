# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What the preflight found, with buttons that help."""

import json
from collections.abc import Iterable

from bpy.app.translations import pgettext_iface as iface_

from ..operators.remedies import REMEDIES
from ..preflight import Finding
from ..sentence import translated
from .words import wrapped


def by_code(found: Iterable[Finding]) -> dict[tuple[str, str], list[Finding]]:
    grouped: dict[tuple[str, str], list[Finding]] = {}
    for finding in found:
        grouped.setdefault((finding.code, finding.severity), []).append(finding)
    return grouped


def finding_box(layout, code: str, severity: str, findings: list[Finding], context):
    """A box for what is wrong in one way: the first one's words, the others' number, the code and a button."""
    box = layout.box()
    box.alert = severity == "ERROR"
    first = findings[0]
    wrapped(box, translated(first.message, iface_), context, icon="ERROR" if severity == "ERROR" else "INFO", taken=20)
    if len(findings) > 1:
        names = ", ".join(f.object for f in findings[1:4]) + ("…" if len(findings) > 4 else "")
        wrapped(box, iface_("And {:d} more: {:s}").format(len(findings) - 1, names), context, "BLANK1", taken=20)
    box.alert = False
    if first.remedy:
        wrapped(box, translated(first.remedy, iface_), context, "BLANK1", taken=20)
    row = box.row()
    sub = row.row()
    sub.active = False
    sub.label(text=code, translate=False)
    names = json.dumps([f.object for f in findings if f.object], ensure_ascii=False)
    if code in REMEDIES:
        idname, text = REMEDIES[code]
        operator = row.operator(idname, text=text)
        if idname.startswith("gi.") and "objects" in operator.bl_rna.properties:
            operator.objects = names
    elif any(f.object in context.scene.objects for f in findings):
        row.operator("gi.select").objects = names
