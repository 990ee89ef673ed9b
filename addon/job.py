# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What to bake: a technique, a target and settings."""

from __future__ import annotations

from dataclasses import dataclass, field

from ..gi_core.rsm.settings import RsmSettings
from ..gi_core.settings import SettingError, Settings
from ..gi_core.techniques import METHODS

TARGETS = ("image", "lightmap", "vertices", "volume")


class NotThere(ValueError):
    """What was asked for is not part of this version."""


@dataclass(frozen=True)
class Job:
    """What to bake.

    method: a technique, see METHODS. target: see TARGETS.
    objects: names of the objects that get lightmaps or vertex light; empty means every mesh that renders.
    resolution: side of each lightmap, or the longer side of the camera image [px]; None means `layout.SIDE`, or the
        scene's own.
    uv: name of the UV map that lightmaps lie on; "" means each mesh's active one.
    settings: of the technique.
    part_of: the technique of the job that this is a part of: only objects whose technique is `method` get light, but
        lightmaps are laid out for all; "" of a whole job.
    """

    method: str = "rsm"
    target: str = "image"
    objects: tuple[str, ...] = ()
    resolution: int | None = None
    uv: str = ""
    settings: Settings = field(default_factory=RsmSettings)
    part_of: str = ""

    @property
    def cameras(self) -> tuple[str, ...]:
        """Names of the cameras whose pictures light the target, empty for the scene's."""
        names = getattr(self.settings, "cameras", "") if self.target != "image" else ""
        return tuple(name for text in names.split(",") if (name := text.strip()))

    def __post_init__(self):
        if self.method not in METHODS:
            raise NotThere(f"the method '{self.method}' is not there yet; there is {', '.join(METHODS)}")
        if self.target not in TARGETS:
            raise NotThere(f"the target '{self.target}' is not there yet; there are {', '.join(TARGETS)}")
        if self.target == "volume" and self.method != "lpv":
            raise NotThere("only the method 'lpv' makes a volume: add --method lpv")
        if self.resolution is not None and not 4 <= self.resolution <= 16384:
            raise SettingError(f"the resolution is {self.resolution}; it goes from 4 to 16384 pixels")
        if self.settings.rebake == "changed" and (self.settings.directional or self.settings.gltf):
            raise SettingError("setting 'rebake=changed' keeps plain lightmaps only: not with directional or gltf")
        if self.settings.glossy and self.target != "image":
            raise SettingError(
                f"setting 'glossy' is for the camera image: what glossy surfaces reflect depends on the view, and the "
                f"target '{self.target}' holds one light for all views"
            )

        if getattr(self.settings, "fog_density", 0) and self.target != "image":
            raise SettingError(f"setting 'fog_density' is for the camera image: the target '{self.target}' has no view")

    def wants(self, light: str) -> bool:
        """Whether "direct" or "indirect" light is asked for; a camera image shows both."""
        return self.target == "image" or self.settings.light in (light, "combined")
