# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake computes on: the graphics card where Blender can reach one.

With a window Blender has a context; in the background one is made. Where no driver is that would end the process, so a
child process tries first.
"""

import functools
import subprocess
import sys
from pathlib import Path

import bpy

from ..gi_core.device import NUMPY, Device, GpuDevice
from .gpu_engine import make_context
from .read.render_depsgraph import own_render_slot

# Seconds that a child may take to try, on a busy machine.
_PATIENCE = 120

# Where Linux keeps graphics cards.
_LINUX_CARDS = ("/dev/dri", "/dev/nvidia0")


def device(wanted: str, memory: int = 1 << 30) -> tuple[Device, str]:
    """What to compute on, and why it is not the graphics card where one is wanted. On the main thread.

    wanted: "cpu", "gpu", or "auto": the graphics card where there is one. A driver that computes on the processor
    itself counts for "gpu" only. memory: bytes of the card's that it may keep for later.
    """
    if wanted == "cpu" or (wanted == "auto" and not _may_have_card()):
        return NUMPY, ""
    reason = why_not() if bpy.app.background else ""
    if reason:
        return NUMPY, reason
    found = _gpu()
    found.budget = memory
    return (NUMPY if wanted == "auto" and found.software else found), ""


def _may_have_card() -> bool:
    """Whether it is worth the second or two that looking for a graphics card takes."""
    return not bpy.app.background or sys.platform != "linux" or any(Path(p).exists() for p in _LINUX_CARDS)


@functools.cache
def _gpu() -> GpuDevice:
    """The graphics card, made once: its shaders are kept from bake to bake."""
    if bpy.app.background:
        with own_render_slot():
            make_context()
    return GpuDevice()


@functools.cache
def why_not() -> str:
    """Why a context cannot be made in the background; "" where it can."""
    engine = str(Path(__file__).with_name("gpu_engine.py"))
    if bpy.app.binary_path:
        command = [bpy.app.binary_path, "--background", "--factory-startup", "--python-exit-code", "1"]
        command += ["--python", engine]
    else:
        command = [sys.executable, engine]
    try:
        child = subprocess.run(command, capture_output=True, text=True, timeout=_PATIENCE, check=False)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"a process that tries to reach the graphics card did not end: {error}"
    if child.returncode or "renderer:" not in child.stdout:
        said = [line for line in child.stderr.splitlines() if line.strip()]
        last = f", saying: {said[-1].strip()}" if said else ""
        return f"no driver that Blender can use: a process that tried one ended with {child.returncode}{last}"
    return ""
