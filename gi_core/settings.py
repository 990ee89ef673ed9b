# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Settings: frozen dataclasses whose fields say what they do, in which unit and between which bounds.

A setting has one name everywhere: the field here, `--set NAME=VALUE` on the command line, the property in Blender, the
report.
"""

from dataclasses import dataclass, field, fields, replace


def setting(default, description: str, *, low=None, high=None, choices: tuple[str, ...] = (), unit: str = ""):
    """A dataclass field with what the command line, the panel and the validation need to know about it."""
    return field(
        default=default,
        metadata={"description": description, "low": low, "high": high, "choices": choices, "unit": unit},
    )


class SettingError(ValueError):
    """A setting's name or value is wrong; the message says which and what is allowed."""


@dataclass(frozen=True)
class Settings:
    """What every technique shares. Raises SettingError when made with a value out of bounds."""

    samples: int = setting(
        64,
        "Samples of reflected light for each pixel, texel or vertex, and as many of emitting surfaces and of the sky; "
        "noise falls with their number, time grows with it",
        low=1,
        high=65536,
    )
    noise_threshold: float = setting(
        0.0,
        "Ends before all samples are taken once the noise is this low: relMSE of reflected light before it is "
        "denoised, estimated by the spread of passes; 0 takes all samples",
        low=0.0,
        high=1.0,
    )
    time_limit: float = setting(
        0.0,
        "Ends before all samples are taken after so long, points and maps not counted; 0 takes all samples",
        low=0.0,
        high=1e6,
        unit="s",
    )
    bounces: int = setting(
        1,
        "How often light is reflected before it arrives; 1 is the first bounce, more brighten what lamps do not reach "
        "and take longer",
        low=1,
        high=32,
    )
    light_samples: int = setting(
        32,
        "Samples of each soft lamp for each pixel, texel or vertex; more give smoother shadows and take longer",
        low=1,
        high=4096,
    )
    shadow_map_resolution: int = setting(
        0,
        "Shadows of lamps in direct light by maps of so many texels along their side, one for each sample of a lamp: "
        "for graphics cards; edges are off by a texel or two. 0 finds them by rays, which is exact",
        low=0,
        high=8192,
        unit="texels",
    )
    seed: int = setting(0, "Start of the random sequence; the same seed gives the same picture", low=0, high=2**20)
    device: str = setting("auto", "What computes: the processor or the graphics card", choices=("auto", "cpu", "gpu"))
    denoise: str = setting(
        "auto",
        "Takes noise out: not at all, by a filter along surfaces, or by Open Image Denoise; auto takes the latter for "
        "RSM's camera images where this Blender has it, else the filter; vertices stay as they are",
        choices=("auto", "none", "bilateral", "oidn"),
    )
    denoise_passes: int = setting(
        3, "Passes of the bilateral filter; each doubles its reach: 4, 12, 28 pixels", low=1, high=6
    )
    light: str = setting(
        "combined",
        "Light that lightmaps and vertices hold: direct, indirect or both",
        choices=("combined", "direct", "indirect"),
    )
    margin: int = setting(
        2,
        "Texels by which a lightmap's islands grow, so that filtering finds no black there",
        low=0,
        high=64,
        unit="texels",
    )
    domain: str = setting(
        "point",
        "Light at vertices: one value for each vertex, or one for each corner of each face, which keeps hard edges",
        choices=("point", "corner"),
    )
    atlas: str = setting(
        "object",
        "Lightmaps: one image for each object, for each collection, or one for all",
        choices=("object", "collection", "all"),
    )
    density: float = setting(
        0.0,
        "Lightmaps: texels per metre of surface; 0 makes them as many as the resolution gives; memory and time "
        "grow with its square",
        low=0.0,
        high=1e5,
        unit="texels/m",
    )
    unwrap: str = setting(
        "missing",
        "Lightmap UVs are made, in a map of their own, where a mesh has none that is free of overlaps, or never",
        choices=("missing", "never"),
    )
    stitch: bool = setting(True, "Lightmaps: makes the light on both sides of each seam of the UV map agree")
    directional: bool = setting(
        False,
        "Lightmaps: also how the light changes with the normal, for bump maps, as four images of spherical harmonics; "
        "takes four times as long",
    )
    encoding: str = setting(
        "srgb",
        "Lightmaps as PNG: to look at, or with the full range of light: colour times (rgbm) or over (rgbd) alpha; the "
        "file says how it is decoded",
        choices=("srgb", "rgbm", "rgbd"),
    )
    exposure: float = setting(
        0.0, "Lightmaps as PNG: factor on light before it is encoded; 0 finds a fitting one", low=0.0, high=1e6
    )
    rebake: str = setting(
        "all",
        "Lightmaps: all, or only of objects that were changed since they were baked into the file, or all where the "
        "lamps, the sky or the settings were; what changed objects reflect onto others then stays as it was",
        choices=("all", "changed"),
    )
    gltf: bool = setting(
        False, "Lightmaps: also writes baked.glb, the objects with their colour times the light, unlit, for any viewer"
    )
    exr: str = setting("float", "Lightmaps as EXR: 32 bits for each value, or 16", choices=("float", "half"))
    padding: int = setting(
        -1,
        "Texels that stay free around each island of lightmap UVs that are made, and around each object on an image; "
        "-1 leaves as many as islands grow by (margin), so that none grows into another's room",
        low=-1,
        high=64,
        unit="texels",
    )
    antialias: int = setting(
        2,
        "Points seen per pixel along each axis in a camera image; smooths silhouettes; memory grows with its square",
        low=1,
        high=8,
    )

    glossy: bool = setting(
        False,
        "Camera image: also what glossy surfaces reflect to the camera, as layers of its own, found by rays with every "
        "technique, which takes longer; for Glossy and Principled BSDFs",
    )
    memory: int = setting(
        1024,
        "Memory that the points being worked on may take; bigger bakes are cut into tiles, which never changes the "
        "result",
        low=1,
        high=1 << 20,
        unit="MB",
    )

    @property
    def smooths(self) -> bool:
        """Whether noise is taken out by the filter along surfaces."""
        return self.denoise in ("auto", "bilateral")

    @property
    def room(self) -> int:
        """Texels that stay free around islands.

        No filter of a bake needs them: the bilateral one ends where an island does, and Open Image Denoise gets each
        island by itself. Look-ups of the finished image do: 1 texel where they are bilinear, 2ᵏ on mipmap k.
        """
        return self.margin if self.padding < 0 else self.padding

    def wanted(self, direct, indirect):
        """Of two parts of light, arrays, what the setting `light` asks for."""
        return {"combined": direct + indirect, "direct": direct, "indirect": indirect}[self.light]

    def __post_init__(self):
        for f in fields(self):
            value, m = getattr(self, f.name), f.metadata
            if m["choices"] and value not in m["choices"]:
                raise SettingError(f"setting '{f.name}' is '{value}'; choose one of {', '.join(m['choices'])}")
            # Written so that what is not a number is out of bounds too.
            if m["low"] is not None and not m["low"] <= value <= m["high"]:
                raise SettingError(f"setting '{f.name}' is {value}; it goes from {m['low']} to {m['high']}")


def updated(settings: Settings, texts: dict[str, str]) -> Settings:
    """The settings with values given as text, as on a command line. Raises SettingError for unknown names and wrong
    values."""
    known = {f.name: f for f in fields(settings)}
    values = {}
    for name, text in texts.items():
        if name not in known:
            raise SettingError(f"there is no setting '{name}'; there are {', '.join(known)}")
        kind = type(known[name].default)
        try:
            if kind is bool:
                values[name] = {"true": True, "1": True, "on": True, "false": False, "0": False, "off": False}[
                    text.lower()
                ]
            else:
                values[name] = kind(text)
        except (ValueError, KeyError):
            raise SettingError(f"setting '{name}' takes a value of type {kind.__name__}, not '{text}'") from None
    return replace(settings, **values)
