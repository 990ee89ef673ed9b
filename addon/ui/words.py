# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Texts and numbers as people read them: in lines that fit, and short."""

import re

import blf
import bpy
from bpy.app.translations import pgettext_iface as iface_

# Where a line may end: after a word, and after any character of a script that has no spaces,
# but not before what closes a sentence.
_CJK = "\u3000-\u9fff\uff00-\uffef"
_CLOSING = "，。：；、！？）》”’"
_PIECES = re.compile(rf"[{_CJK}][{_CLOSING}]*|\s*[^\s{_CJK}]+|\s+")


def wrapped(layout: bpy.types.UILayout, text: str, context, icon: str = "NONE", taken: int = 0) -> None:
    """A text in as many lines as the region's width asks for. taken: of the width by other things [px at scale 1]."""
    scale = context.preferences.system.ui_scale
    blf.size(0, 11 * scale)
    width = context.region.width - (68 + taken + (20 if icon != "NONE" else 0)) * scale
    lines, line = [], ""
    for piece in _PIECES.findall(text):
        if line and blf.dimensions(0, (line + piece).rstrip())[0] > width:
            lines.append(line.rstrip())
            line = ""
        line += piece if line else piece.lstrip()
    column = layout.column(align=True)
    column.scale_y = 0.8
    for i, part in enumerate([*lines, line]):
        column.label(text=part, icon=icon if i == 0 else "BLANK1" if icon != "NONE" else "NONE", translate=False)


def duration(seconds: float) -> str:
    """Seconds as people say them."""
    if seconds < 60:
        return iface_("{:.0f} s").format(seconds) if seconds >= 10 else iface_("{:.1f} s").format(seconds)
    if seconds < 3600:
        return iface_("{:.0f} min {:.0f} s").format(seconds // 60, seconds % 60)
    return iface_("{:.0f} h {:.0f} min").format(seconds // 3600, seconds % 3600 // 60)


def short(seconds: float) -> str:
    """Seconds in one number."""
    if seconds < 100:
        return duration(seconds) if seconds < 60 else iface_("{:.0f} s").format(seconds)
    return iface_("{:.0f} min").format(seconds / 60) if seconds < 5400 else iface_("{:.1f} h").format(seconds / 3600)


def amount(count: float) -> str:
    """A large number, short."""
    for size, unit in ((1e9, "G"), (1e6, "M"), (1e3, "k")):
        if count >= size:
            return f"{count / size:.1f} {unit}"
    return f"{count:.0f}"
