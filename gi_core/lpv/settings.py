# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of light propagation volumes."""

from dataclasses import dataclass

from ..settings import Settings, setting


@dataclass(frozen=True)
class LpvSettings(Settings):
    """Where the volume lies, how light gets into it, through it and out of it."""

    map_resolution: int = setting(
        512,
        "Side of a lamp's map, whose texels are injected; time for maps grows with its square",
        low=8,
        high=8192,
        unit="texels",
    )
    cells: int = setting(
        32,
        "Cells along the longest side of each cascade; finer ones keep light apart that lies near, memory and time "
        "grow with their cube",
        low=16,
        high=128,
        unit="cells",
    )
    cascades: int = setting(
        0, "Grids one in another; the largest holds the whole scene, or the box where one is given. 0: as many as "
        "leave nearly all points that are lit in the finest, so one for a room that is seen whole",
        low=0, high=6,
    )  # fmt: skip
    cascade_ratio: int = setting(2, "How many times larger the cells of a cascade are than the next finer one's",
                                 low=2, high=4)  # fmt: skip
    center: str = setting(
        "receivers",
        "What the finer cascades lie around: the points that are lit, the camera, or the middle of the volume",
        choices=("receivers", "camera", "middle"),
    )
    box: str = setting(
        "",
        "Corners of the box that the largest cascade holds, as 'x y z x y z', or the name of an object, such as an "
        "empty, that is as large; nothing for the whole scene",
        unit="m",
    )
    injection: str = setting(
        "lobe",
        "What a virtual light puts into its cell: the cosine lobe about its normal, or a form which counts "
        "the cosine twice",
        choices=("lobe", "literal"),
    )
    injection_bias: float = setting(
        0.5, "How far along its normal a light is moved before its cell is chosen", low=0.0, high=2.0, unit="cells"
    )
    propagation: str = setting(
        "hierarchical",
        "How light travels: in straight lines over grids that are coarser the further it has come, or from neighbour "
        "to neighbour (as published)",
        choices=("hierarchical", "flat"),
    )
    reach: float = setting(
        4.0, "Hierarchical: after how many cells light moves on to a coarser grid", low=2.0, high=8.0, unit="cells"
    )
    visibility: bool = setting(
        True, "Hierarchical: rays from cell to cell, and from cells to what they light; without them light leaks"
    )
    iterations: int = setting(
        8, "Flat: steps from neighbour to neighbour; 0 goes on until the front holds less than `front_share`",
        low=0, high=256,
    )  # fmt: skip
    front_share: float = setting(
        0.02, "Flat: what share of the injected flux the front may still hold at the end", low=1e-4, high=0.5
    )
    damping: float = setting(1.0, "Flat: what is left of light after each step (CryEngine: 0.82)", low=0.0, high=1.0)
    geometry_volume: bool = setting(
        True, "Flat: surfaces stop light, by their area in each cell; without it light leaks"
    )
    occlusion_amplifier: float = setting(1.0, "Flat: how much more than its area a surface stops", low=0.0, high=8.0)
    geometry_bias: float = setting(
        0.0, "Flat: how far surfaces are moved along their normals in the geometry volume (Unreal: 0.384)",
        low=0.0, high=1.0, unit="cells",
    )  # fmt: skip
    secondary_bounce: float = setting(
        0.0, "Flat: share of the light that surfaces stop which they send back, times their albedo", low=0.0, high=1.0
    )
    emissive: float = setting(
        0.0,
        "Share of emitting surfaces' own light that the volume holds besides what is reflected; a bake adds it by "
        "itself, so this is for volumes that light other things",
        low=0.0,
        high=1.0,
    )
    derivative_damping: float = setting(
        0.0, "Flat: exponent by which light is taken away where the volume changes against it, 0 for not at all",
        low=0.0, high=8.0,
    )  # fmt: skip
    directional_occlusion: float = setting(
        0.0, "How much nearby surfaces, seen against the light, darken what they hide", low=0.0, high=1.0
    )
    occlusion_radius: float = setting(8.0, "How near is nearby", low=0.5, high=64.0, unit="cells")
    intensity: float = setting(1.0, "Factor on all light of the volume", low=0.0, high=100.0)
    fade: float = setting(
        0.0, "Width in which light fades out towards the border of the largest cascade",
        low=0.0, high=32.0, unit="cells",
    )  # fmt: skip
    glossy_lookup: str = setting(
        "rays",
        "Camera image, with `glossy`: what else is reflected in glossy surfaces by rays, or from the volume, which "
        "has no noise but knows no more than three bands: for rough ones",
        choices=("rays", "volume"),
    )
    fog_density: float = setting(
        0.0, "Camera image: extinction of a homogeneous medium that fills the scene, or the box; what it scatters once "
        "to the camera is shown as layers Volume Direct and Volume Indirect. 0 for none",
        low=0.0, high=100.0, unit="1/m",
    )  # fmt: skip
    fog_albedo: float = setting(1.0, "Share of the light that the medium stops which it scatters", low=0.0, high=1.0)
    fog_anisotropy: float = setting(
        0.0, "Where the medium scatters to: back, evenly (0) or ahead (Henyey-Greenstein)", low=-0.95, high=0.95
    )
    fog_steps: int = setting(16, "Points in the medium that each subpixel's ray looks at", low=1, high=1024)
    half: bool = setting(True, "The volume's file: 16 bits for each value, which is enough for light; else 32")
    blend: float = setting(2.0, "Width in which a cascade goes over into the next larger one", low=0.0, high=8.0,
                           unit="cells")  # fmt: skip
