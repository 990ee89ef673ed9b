# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How long bakes take on this machine, learnt from the last one of each kind."""

import json

import bpy

from .asked import extent
from .preferences import cache_folder

_FILE = "timings.json"
_known: dict[str, float] = {}


def expected(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> float | None:
    """Seconds that a bake of the scene takes about; None where none of its kind was baked here yet."""
    if not _known:
        _known[""] = 0.0  # looked for once
        try:
            read = json.loads((cache_folder() / _FILE).read_text(encoding="utf-8"))
            _known.update({str(k): float(v) for k, v in read.items()})
        except (OSError, ValueError, AttributeError, TypeError):
            pass
    kind, amount = work(scene, view_layer)
    return _known[kind] * amount if kind in _known else None


def learn(kind: str, amount: float, seconds: float) -> None:
    """Notes how long so much work took, as `work` gave it before the bake."""
    _known[kind] = seconds / amount
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        (folder / _FILE).write_text(json.dumps({k: v for k, v in _known.items() if k}), encoding="utf-8")
    except OSError:
        pass  # an estimate less is no reason to lose a bake


def work(scene: bpy.types.Scene, view_layer: bpy.types.ViewLayer) -> tuple[str, float]:
    """What kind of bake the scene asks for, and how much it is: roughly what time grows with, samples at points."""
    group = scene.gi_bake
    points = extent(scene, view_layer).points
    if group.target == "IMAGE":
        points /= group.antialias**2  # which share out the samples
    samples = 1 if group.method == "LPV" else group.samples * group.bounces
    return f"{group.method} {group.target}", max(1.0, points * samples)
