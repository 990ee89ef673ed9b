# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The console script `gi-bake`, for the bpy wheel."""

import importlib.util
import os
import sys
from pathlib import Path

from .standard_output import quiet


def main() -> int:
    """Runs the command line on sys.argv; the exit code."""
    # bpy speaks already when it is imported.
    with quiet():
        find_blenders_modules()
        from . import cli
    code = cli.main()
    sys.stdout.flush()
    sys.stderr.flush()
    bpy = sys.modules["bpy"]
    if bpy.app.version < (5, 0) and "gpu" in sys.modules:
        # Blender 4.5 hangs while it ends, once it has had a context.
        os._exit(code)
    # What Blender says of its memory as it ends is none of the answer.
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.close(nowhere)
    return code


def find_blenders_modules() -> None:
    """Puts modules that come with Blender, openvdb among them, on the path: its program has them there, the wheel has
    not."""
    folder = Path(importlib.util.find_spec("bpy").origin).parent
    sys.path.extend(str(p) for p in folder.glob("*/python/lib/python3.*/site-packages"))
