# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of reflective shadow maps."""

from dataclasses import dataclass

from ..settings import Settings, setting


@dataclass(frozen=True)
class RsmSettings(Settings):
    """How maps are made and gathered from."""

    map_resolution: int = setting(
        512,
        "Side of a lamp's map; a lamp with several maps shares as many texels among them",
        low=8,
        high=8192,
        unit="texels",
    )
    pattern: str = setting(
        "flux",
        "Which texels a point gathers from: drawn by their flux (least noise), a disk around its own place in the map "
        "(as published), or all of them (reference, slow)",
        choices=("flux", "disk", "all"),
    )
    weighting: str = setting(
        "exact",
        "Weight of a disk sample: the exact ξ₁, or the brief's ξ₁², which is biased",
        choices=("exact", "literal"),
    )
    disk_radius: float = setting(0.3, "Radius of the disk pattern as a share of the map's side", low=0.001, high=2.0)
    bound: str = setting(
        "compensated",
        "Keeps lights that are very near from making bright specks: clamped, with short rays that find again what the "
        "clamp takes (exact), or by the disk that each light stands for",
        choices=("compensated", "disc"),
    )
    visibility: bool = setting(
        True, "Shadow rays between a point and the light reflected to it; without them light leaks"
    )
