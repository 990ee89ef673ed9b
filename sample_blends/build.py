# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Build the sample files: `python sample_blends/build.py [NAME ...]`, with the bpy wheel of Blender 4.5.

Each `scenes/NAME.py` makes one scene out of nothing; the same code gives the same scene every time.
"""

import argparse
import importlib
from pathlib import Path

import bpy

FOLDER = Path(__file__).resolve().parent
NEWEST = (4, 5)  # a newer Blender's files may not open in Blender 4.5


def main():
    known = sorted(path.stem for path in (FOLDER / "scenes").glob("*.py"))
    parser = argparse.ArgumentParser(description="Build the sample .blend files.")
    parser.add_argument("names", nargs="*", metavar="NAME", help=f"{', '.join(known)}; all of them by default")
    parser.add_argument("--any-version", action="store_true", help="build with a Blender newer than 4.5 too")
    parser.add_argument("--thumbnails", action="store_true", help="render thumbnails of the files instead")
    args = parser.parse_args()
    if unknown := set(args.names) - set(known):
        parser.error(f"no such sample: {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    if bpy.app.version[:2] > NEWEST and not (args.any_version or args.thumbnails):
        parser.error(f"Blender {bpy.app.version_string} would write files that Blender 4.5 may not open; "
                     "use the bpy wheel of Blender 4.5, or say --any-version")
    for name in args.names or known:
        (thumbnail if args.thumbnails else build)(name)


def build(name):
    importlib.import_module(f"scenes.{name}").build()
    bpy.context.preferences.filepaths.save_version = 0  # no .blend1 beside it
    for space in (space for screen in bpy.data.screens for area in screen.areas for space in area.spaces):
        if space.type == "FILE_BROWSER":
            space.params.directory = b"//"  # not the home folder of whoever builds
    bpy.ops.wm.save_as_mainfile(filepath=str(FOLDER / f"{name}.blend"), compress=True, check_existing=False)


def thumbnail(name):
    """A Cycles render of the file's current frame, 256 pixels wide, as a JPEG."""
    bpy.ops.wm.open_mainfile(filepath=str(FOLDER / f"{name}.blend"))
    scene = bpy.context.scene
    render = scene.render
    render.resolution_y = round(256 * render.resolution_y / render.resolution_x)
    render.resolution_x = 256
    scene.cycles.samples = 256
    scene.cycles.seed = 0
    scene.cycles.use_denoising = True
    scene.view_settings.view_transform = "Standard"
    scene.view_settings.exposure = 0
    render.image_settings.file_format = "JPEG"
    render.image_settings.quality = 90
    for stamp in (key for key in render.bl_rna.properties.keys() if key.startswith("use_stamp_")):
        setattr(render, stamp, False)  # no paths, dates or times in the picture's metadata
    render.filepath = str(FOLDER / "thumbnails" / f"{name}.jpg")
    bpy.ops.render.render(write_still=True)


if __name__ == "__main__":
    main()
