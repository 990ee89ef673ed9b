# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Shading normals of node trees: what normal maps, bumps and whatever else feed a shader's Normal input.

They are baked like all that only Cycles can tell, in the object's space. Tangents, derivatives of heights and what
nodes make of normals are then Cycles' own; what is left to do is what any mesh's normal needs, its object's matrix.
From behind a surface shows its relief's back, but for bumps, which stand out on either side. Displacement that is only
seen, as it is unless a material says so, is a bump on every normal that is not linked.
"""

import numpy as np

from ...gi_core.scene import NormalSource
from .baked import baked
from .constants import estimate
from .expression import key_of
from .nodes import Feed, Reading


def read_normal(source: Feed, reading: Reading) -> NormalSource | None:
    """The `Feed` of a Normal input as a normal in the object's space, None for the mesh's own."""
    source = _without_idle(source, reading)
    relief = _relief(reading)
    if relief and source.node is None:
        source = relief
    elif relief and _under_bumps(source, reading).node is None:
        reading.note("its displacement is left out under its bump map")
    if source.node is None:
        return None
    # What is asked for twice is one thing.
    key = "normal", key_of(source)
    if key not in reading.known:
        found, own, base = baked(source, reading, is_normal=True), source is relief, _under_bumps(source, reading)
        raised = own or base is not source
        under = baked(base, reading, is_normal=True) if raised and not own else None
        reading.known[key] = found and NormalSource(found.value, found.texture, found.uv, raised, own, under)
    if reading.known[key] is None:
        reading.note("its normal or bump map is left out")
    return reading.known[key]


def _relief(reading: Reading) -> Feed | None:
    """Displacement that is seen as a bump, None where it does nothing."""
    source = reading.displacement
    if source and source.node.type == "DISPLACEMENT":
        if source.input("Height").node is None or _is(source, "Scale", 0, reading):
            return None
    return source


def _under_bumps(source: Feed, reading: Reading) -> Feed:
    """What bumps stand out from; a normal without any itself."""
    while source.node is not None and source.node.type == "BUMP":
        source = _without_idle(source.input("Normal"), reading)
    return source


def _without_idle(source: Feed, reading: Reading) -> Feed:
    """The same without nodes that do nothing."""
    node = source.node
    match node and node.type:
        case "BUMP" if source.input("Height").node is None or _is(source, "Strength", 0, reading):
            return _without_idle(source.input("Normal"), reading)
        case "NORMAL_MAP" if _is(source, "Strength", 0, reading) or (
            node.space == "TANGENT" and _is(source, "Color", (0.5, 0.5, 1), reading)
        ):
            return Feed(None, source.socket, source.groups)
        case "NEW_GEOMETRY" if source.socket.name == "Normal":
            return Feed(None, source.socket, source.groups)
    return source


def _is(source: Feed, name: str, value, reading: Reading) -> bool:
    found = source.input(name)
    return found.node is None and np.allclose(estimate(found, reading)[0], value)
