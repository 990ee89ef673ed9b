# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What shaders are made from: how they read and write arrays, and the text of kernels."""

import re
from collections.abc import Callable
from pathlib import Path

from . import kernels
from .gpu_array import FORMATS, WIDTH, WIDTH_BITS, GpuArray

# Invocations of a work group, and groups in a row of them.
GROUP, ROW = 64, 1024

_TYPES = {1: "float", 2: "vec2", 3: "vec3", 4: "vec4"}
_SWIZZLE = {1: "x", 2: "xy", 3: "xyz", 4: "xyzw"}


def compiled(
    gpu,
    source: str,
    inputs: dict[str, GpuArray],
    outputs: dict[str, GpuArray],
    integers,
    floats,
    defines: dict[str, int],
    with_sources: tuple[str, ...],
):
    """A compute shader of kernels/SOURCE.glsl, see `GpuDevice.dispatch`, whose items are `first_` to `last_`."""
    info = gpu.types.GPUShaderCreateInfo()
    lines = declared(info, inputs, (*integers, "first_", "last_"), floats, defines)
    for slot, (name, values) in enumerate(outputs.items()):
        info.define(f"{name}_t", _TYPES[values.channels])
        info.image(slot, FORMATS[values.channels], "FLOAT_2D", f"{name}_", qualifiers={"WRITE"})
        filled = {1: "v, 0.0, 0.0, 0.0", 2: "v, 0.0, 0.0", 3: "v, 0.0", 4: "v"}[values.channels]
        lines.append(
            f"void set_{name}(int i, {_TYPES[values.channels]} v) {{ imageStore({name}_, ivec2(i & {WIDTH - 1}, "
            f"i >> {WIDTH_BITS}), vec4({filled})); }}"
        )
    info.local_group_size(GROUP, 1, 1)
    lines += sources(*with_sources, source)
    lines.append(
        f"void main() {{ int i = first_ + int(gl_GlobalInvocationID.y) * {GROUP * ROW} "
        "+ int(gl_GlobalInvocationID.x); if (i < last_) { kernel_(i); } }"
    )
    info.compute_source("\n".join(lines))
    return gpu.shader.create_from_info(info)


def declared(info, inputs: dict[str, GpuArray], integers, floats, defines: dict[str, int]) -> list[str]:
    """Gives a shader's description its inputs and numbers; returns the lines that read the inputs."""
    lines = []
    for slot, (name, values) in enumerate(inputs.items()):
        info.sampler(slot, "FLOAT_2D", f"{name}_")
        info.define(f"{name}_t", _TYPES[values.channels])
        lines.append(
            f"{_TYPES[values.channels]} {name}(int i) {{ return texelFetch({name}_, ivec2(i & {WIDTH - 1}, "
            f"i >> {WIDTH_BITS}), 0).{_SWIZZLE[values.channels]}; }}"
        )
    for name in integers:
        info.push_constant("INT", name)
    for name in floats:
        info.push_constant("FLOAT", name)
    for name, value in defines.items():
        info.define(name, str(value))
    return lines


def sources(*names: str) -> list[str]:
    """Text of kernels/NAME.glsl. `kernel` is a word of Metal's own."""
    folder = Path(kernels.__file__).parent
    return [re.sub(r"\bkernel\(", "kernel_(", (folder / f"{name}.glsl").read_text()) for name in names]


def given(setter: Callable, name: str, value):
    """Sets what a shader has. OpenGL drops what a shader does not use, and Blender then finds no such name."""
    try:
        setter(name, value)
    except ValueError:
        pass
