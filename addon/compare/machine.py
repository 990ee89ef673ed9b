# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a report says of the program and the machine that made it."""

import importlib.metadata
import platform
import tomllib
from pathlib import Path


def version() -> str:
    """Of GI Bake, by its manifest, or by the package where it was installed as one."""
    manifest = Path(__file__).parents[2] / "blender_manifest.toml"
    if manifest.is_file():
        return tomllib.loads(manifest.read_text(encoding="utf-8"))["version"]
    return importlib.metadata.version("gi-bake")


def processor() -> str:
    """The processor's name, where the system tells it."""
    info = Path("/proc/cpuinfo")
    if info.is_file():
        for line in info.read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                return line.partition(":")[2].strip()
    return platform.processor() or platform.machine()
