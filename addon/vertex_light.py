# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What light at corners still needs: corners inside of things filled, and vertices their corners' mean."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ..gi_core.corners import Corners
from ..gi_core.geometry import Geometry
from .result import Light


def finished(geometry: Geometry, light: dict[str, Light], vertices: bool) -> Iterator[float]:
    """Light at triangles' corners as it is written. A generator of progress; returns the lights by their names, and
    sentences.

    vertices: at vertices, (v, 3), or else at corners, (3 t, 3).
    """
    done, hidden = {}, 0
    for k, (name, raw) in enumerate(light.items()):
        yield k / len(light)
        corners = Corners.of(geometry, name)
        hidden += int(raw.inside.sum())
        known = raw.valid & ~raw.inside
        direct, indirect = (corners.filled(values, known) for values in (raw.direct, raw.indirect))
        whole = replace(raw, direct=direct, indirect=indirect, centred=known, corners=corners, known=known)
        done[name] = _at_vertices(whole) if vertices else whole
    told = f"inside: {hidden} corners of triangles lie inside of something: filled from around them"
    return done, [told] if hidden else []


def _at_vertices(light: Light) -> Light:
    corners, known = light.corners, light.known
    mean = {name: corners.at_vertices(getattr(light, name), known) for name in ("direct", "indirect")}
    if light.coverage is not None:
        mean["coverage"] = corners.at_vertices(light.coverage[:, None], known)[:, 0]
    valid, centred = (np.bincount(corners.vertex, which, corners.count) > 0 for which in (light.valid, known))
    return replace(light, **mean, valid=valid, centred=centred, filled=valid)
