# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What a bake computes on: the graphics card where Blender can reach one.

With a window Blender has a context; in the background one is made. Where no driver is that would end the process, so a
child process tries first.
"""

import functools
import logging
import os
import subprocess
import sys
from pathlib import Path

import bpy

from ..gi_core.device import NUMPY, Device, GpuDevice
from .gpu_engine import make_context
from .read.render_depsgraph import own_render_slot
from .standard_output import quiet

_LOG = logging.getLogger(__name__)

# Seconds that a child may take to try, on a busy machine.
_PATIENCE = 120

# Where Linux keeps graphics cards.
_LINUX_CARDS = ("/dev/dri", "/dev/nvidia0")


# Seconds of a processor that a driver in software spares numpy for each pixel and sample of a camera image, and what it
# takes to reach one: a child of a second, a context, shaders. It is to spare twice of that. Measured on two cores.
_SPARES, _TAKES = {"rsm": 0.5e-6, "ssgi": 4e-6}, 1.5


def spared(method: str, pixels: int, samples: int) -> float:
    """Seconds that a driver in software would spare in a camera image: nothing with other techniques."""
    return _SPARES.get(method, 0.0) * pixels * samples / os.cpu_count()


def device(wanted: str, memory: int = 1 << 30, spares: float = 0.0) -> tuple[Device, str]:
    """What to compute on, and why it is not the graphics card where one is wanted. On the main thread.

    wanted: "cpu", "gpu", or "auto": the graphics card where there is one. memory: bytes that it may hold. spares:
    seconds that a driver that computes on the processor itself would spare: "auto" takes one where these are many, in
    the background, where nobody waits for the main thread, and from Blender 5.0 on, which ends as it should after it.
    """
    pays = spares > 2 * _TAKES and bpy.app.background and bpy.app.version >= (5, 0)
    if wanted == "cpu" or (wanted == "auto" and not _may_have_card() and not pays):
        return NUMPY, ""
    reason = why_not() if bpy.app.background else ""
    try:
        found = None if reason else _gpu()
    except (RuntimeError, SystemError) as error:
        reason = f"Blender gives no context: {error}"
    if reason:
        _LOG.info("no driver of a graphics card: %s", reason)
        return NUMPY, reason if wanted == "gpu" or _may_have_card() else ""
    found.budget = memory
    return (NUMPY if wanted == "auto" and found.software and not pays else found), ""


def _may_have_card() -> bool:
    """Whether it is worth the second or two that looking for a graphics card takes."""
    return not bpy.app.background or sys.platform != "linux" or any(Path(p).exists() for p in _LINUX_CARDS)


@functools.cache
def _gpu() -> GpuDevice:
    """The graphics card, made once: its shaders are kept from bake to bake."""
    if bpy.app.background:
        # Blender tries one version of OpenGL after the other and says of each that the driver has it not.
        with own_render_slot(), quiet(2):
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
