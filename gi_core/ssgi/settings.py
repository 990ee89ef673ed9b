# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings of screen-space global illumination."""

from dataclasses import dataclass, replace

from ..settings import Settings, setting

FALLBACKS = ("none", "sky", "probes", "both")
QUALITIES = ("custom", "low", "medium", "high")

# HDRP's, of mode screen_space and of those with rays through the scene. What it has there besides, a clamp of 2, 3 and
# 5 and rays of 50 m, depends on a scene's exposure and scale.
ON_SCREEN = {
    "low": {"steps": 32, "radius": 0.75, "half_filter": True, "second_pass": True},
    "medium": {"steps": 64, "radius": 0.5, "half_filter": False, "second_pass": True},
    "high": {"steps": 128, "radius": 0.5, "half_filter": False, "second_pass": True},
}
BY_RAYS = {
    "low": {"mixed_steps": 32, "full_resolution": False, "radius": 1.0, "half_filter": True, "second_pass": True},
    "medium": {"mixed_steps": 48, "full_resolution": False, "radius": 1.0, "half_filter": False, "second_pass": True},
    "high": {"mixed_steps": 64, "full_resolution": True, "radius": 1.0, "half_filter": False, "second_pass": True},
}


@dataclass(frozen=True)
class SsgiSettings(Settings):
    """How a camera's picture lights itself."""

    mode: str = setting(
        "mixed",
        "Where reflected light is looked for: nowhere, on the screen, in the scene by rays, or on the screen and where "
        "that shows nothing by rays",
        choices=("off", "screen_space", "ray_traced", "mixed"),
    )
    tracer: str = setting(
        "march",
        "How the screen is searched: by rays marched through its depth, or by a horizon scan with a visibility bitmask",
        choices=("march", "bitmask"),
    )
    quality: str = setting(
        "custom",
        "Steps, resolution and filters as HDRP's presets have them for the mode; custom takes the settings' own",
        choices=QUALITIES,
    )
    steps: int = setting(
        64,
        "Steps of a ray on the screen, or of a scan to either side; more find what is thin and take longer",
        low=1,
        high=1024,
    )
    mixed_steps: int = setting(48, "Steps of a ray on the screen in mode mixed, before the scene", low=1, high=1024)
    thickness: float = setting(
        0.1, "How far what is seen reaches back, as a share of its distance from the camera", low=0.0, high=10.0
    )
    full_resolution: bool = setting(
        True, "Traces at every pixel; off, at one of four, and filters up: softer, in about a third of the time"
    )
    frames: int = setting(
        16,
        "Passes over each picture; they share out its samples, and each starts from what those before it found",
        low=1,
        high=4096,
    )
    fallback: str = setting(
        "both",
        "Light of rays that meet nothing on the screen: none, the sky where the scene hides it, probes in the scene, "
        "or probes and the sky beyond their reach",
        choices=FALLBACKS,
    )
    last_bounce: str = setting(
        "none", "Light that the last point of a traced ray gets besides direct light", choices=FALLBACKS
    )
    probes: str = setting(
        "grid",
        "What the probes are: a small grid baked by rays, or a light propagation volume with its own defaults",
        choices=("grid", "lpv"),
    )
    probe_cells: int = setting(8, "Probes along the longest side of the scene", low=1, high=128)
    probe_rays: int = setting(256, "Rays of each probe", low=1, high=65536)
    feedback: str = setting(
        "current",
        "What a ray sees on the screen: the present light and as many bounces as asked for, or the previous pass's "
        "picture, in which each pass adds a bounce (as in HDRP)",
        choices=("current", "previous"),
    )
    ray_length: float = setting(
        0.0, "How far traced rays go; 0 means through the whole scene (HDRP: 50)", low=0.0, high=1e6, unit="m"
    )
    clamp: float = setting(
        0.0, "The most that a ray brings, in its strongest channel; 0 clamps nothing (HDRP: 7)", low=0.0, high=1e6
    )
    accumulation: str = setting(
        "mean",
        "How passes and pictures add up: to their true mean, or with HDRP's memory of some 28 passes",
        choices=("mean", "hdrp"),
    )
    motion_rejection: bool = setting(
        True, "Things that move or bend forget earlier pictures' light: less of a trail, more noise on them"
    )
    radius: float = setting(
        0.5, "Radius of the diffuse filter; on the screen it is about a fifth of it [m] at a metre", low=0.0, high=10.0
    )
    half_filter: bool = setting(False, "Filters at one of four pixels, with a quarter of the points, and filters up")
    second_pass: bool = setting(True, "Filters a second time, with half the radius")
    weights: str = setting(
        "exact",
        "How much normals may differ in the diffuse filter: as in HDRP, or more, which blurs edges",
        choices=("exact", "literal"),
    )
    cameras: str = setting(
        "",
        "Cameras whose pictures light lightmaps and vertices, names of objects with commas between; empty means the "
        "scene's",
    )
    debug: bool = setting(False, "Writes what each pass found as layers of the camera image's EXR")

    @property
    def preset(self) -> "SsgiSettings":
        """The settings with those of the preset in place."""
        presets = ON_SCREEN if self.mode == "screen_space" else BY_RAYS
        return replace(self, **presets.get(self.quality, {}))

    @property
    def wants_probes(self) -> bool:
        kinds = {"screen_space": self.fallback, "ray_traced": self.last_bounce, "mixed": self.last_bounce}
        return kinds.get(self.mode) in ("probes", "both")
