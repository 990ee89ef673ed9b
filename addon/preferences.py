# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What belongs to the machine and its user, not to a .blend: device, threads, the cache folder."""

from pathlib import Path

import bpy
from bpy.props import EnumProperty, IntProperty, StringProperty
from bpy.types import AddonPreferences

from ..gi_core import tiles
from .read import texture_cache

# The root of the package: `gi_bake`, or `bl_ext.REPOSITORY.gi_bake` as an extension.
PACKAGE = __package__.rpartition(".")[0]

DEVICES = (
    ("AUTO", "Automatic", "The graphics card where it can be used, else the processor"),
    ("CPU", "Processor", "All cores of the processor, or as many as Threads says"),
    ("GPU", "Graphics Card", "The graphics card, through Blender's own graphics driver"),
)


def _threads_changed(preferences, _context):
    tiles.use_threads(preferences.threads)


def _cache_changed(preferences, _context):
    texture_cache.use_folder(cache_folder() / "materials" if preferences.cache else None)


class GiBakePreferences(AddonPreferences):
    """Preferences ▸ Add-ons ▸ GI Bake."""

    bl_idname = PACKAGE

    device: EnumProperty(
        name="Device", description="What computes where a scene's device is Auto", items=DEVICES, default="AUTO"
    )
    threads: IntProperty(
        name="Threads",
        description="Cores that a bake uses, 0 for all; fewer leave the machine usable and take longer. The result is "
        "the same with any number",
        default=0,
        min=0,
        max=1024,
        update=_threads_changed,
    )
    cache: StringProperty(
        name="Cache Folder",
        description="Folder for baked materials, comparisons of files that are not saved, and timings; empty takes "
        "Blender's own folders",
        subtype="DIR_PATH",
        update=_cache_changed,
    )

    def draw(self, _context):
        layout = self.layout
        layout.use_property_split, layout.use_property_decorate = True, False
        layout.prop(self, "device")
        layout.prop(self, "threads")
        layout.prop(self, "cache", placeholder=str(cache_folder()))
        split = layout.split(factor=0.4)
        split.label()
        row = split.row(align=True)
        size = cache_size() / 2**20
        row.label(text=bpy.app.translations.pgettext_iface("In use: {:.1f} MB").format(size), translate=False)
        row.operator("gi.clear_cache", text="Clear")


def preferences() -> GiBakePreferences | None:
    """The user's; None where the extension is used as a module and not enabled."""
    addon = bpy.context.preferences.addons.get(PACKAGE)
    return addon.preferences if addon else None


def device() -> str:
    """What the setting "auto" stands for on this machine."""
    chosen = preferences()
    return chosen.device.lower() if chosen else "auto"


def cache_folder() -> Path:
    """The folder for what belongs to no file; not made by asking."""
    chosen = preferences()
    if chosen and chosen.cache:
        return Path(bpy.path.abspath(chosen.cache)) / "gi_bake"
    try:
        return Path(bpy.utils.extension_path_user(PACKAGE, path="cache"))
    except ValueError:  # not an extension, but the package as pip installs it
        return Path(bpy.utils.user_resource("CONFIG")) / "gi_bake"


def cached_files() -> list[Path]:
    """Comparisons and timings, and baked materials, which may lie in a folder with other things."""
    found = (*cache_folder().rglob("*"), *texture_cache.default_folder().glob("*.npy"))
    return [path for path in dict.fromkeys(found) if path.is_file()]


def cache_size() -> int:
    """Bytes in the cache folder."""
    return sum(path.stat().st_size for path in cached_files())


def register():
    bpy.utils.register_class(GiBakePreferences)
    if chosen := preferences():
        tiles.use_threads(chosen.threads)
        _cache_changed(chosen, None)


def unregister():
    bpy.utils.unregister_class(GiBakePreferences)
    tiles.use_threads(0)
    texture_cache.use_folder(None)
