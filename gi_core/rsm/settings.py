# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of reflective shadow maps."""

from dataclasses import dataclass

from ..settings import Settings, setting


@dataclass(frozen=True)
class RsmSettings(Settings):
    """How maps are made and gathered from."""

    map_resolution: int = setting(
        256,
        "Side of a lamp's map; a lamp with several maps shares as many texels among them. Larger ones know smaller "
        "patches of light; memory and time for maps grow with its square",
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
        "Weight of a disk sample: the exact ξ₁, or ξ₁², which is biased",
        choices=("exact", "literal"),
    )
    disk_radius: float = setting(0.3, "Radius of the disk pattern as a share of the map's side", low=0.001, high=2.0)
    pattern_per_point: bool = setting(
        True,
        "A sample pattern of its own for each point, which leaves noise; off, one for all points, which leaves bands "
        "(both as published)",
    )
    bound: str = setting(
        "compensated",
        "Keeps lights that are very near from making bright specks: clamped, with short rays that find again what the "
        "clamp takes (exact); or darker in corners, by the disk that each light stands for, by a least distance, by "
        "the greatest transfer, or by moving lights back into their surface (as published)",
        choices=("compensated", "disc", "distance", "geometry", "offset"),
    )
    bound_distance: float = setting(
        0.0,
        "How near a light counts as very near, for every bound: the radius of the disk, the least distance, the way "
        "back; 0 takes it from the area that each light stands for",
        low=0.0,
        high=1000.0,
        unit="m",
    )
    visibility: bool = setting(
        True, "Shadow rays between a point and the light reflected to it; without them light leaks"
    )
    candidates: int = setting(
        4,
        "Lights looked at for each sample, of which one that brings much is drawn and gets the shadow ray (flux "
        "pattern); more lower noise where light is uneven, and take time without a ray's worth of it",
        low=1,
        high=64,
    )
    interpolation: int = setting(
        1,
        "Gathers at every so many-th pixel or texel along each axis, mixes between them on even surfaces, and gathers "
        "fully at edges; 1 gathers everywhere",
        low=1,
        high=64,
        unit="pixels",
    )
