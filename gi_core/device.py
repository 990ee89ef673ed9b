# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""What kernels run on: the processor, with numpy, or a graphics card, through Blender's `gpu` module.

    near = device.run(bilateral, device.array(value), …)        a kernel on arrays
    light = yield from device.each(tile, n, size)               the same over any number of items
    picture = device.numpy(light)                               to the processor, where it is needed there

A kernel is a function of numpy arrays in `kernels/NAME.py`; that is its definition. Beside it lies `NAME.glsl`, which
computes one item, and in the same module `NAME_on_gpu`, which says what goes into that and what comes out. Arrays that
a kernel gives stay where it ran, so kernels that follow each other move nothing. Some kernels are drawn instead, by
`GpuDevice.draw`: of many at one pixel the nearest counts.
"""

import time
import weakref
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from . import tiles
from .gpu_array import FORMATS, WIDTH, GpuArray, Store, extent, size_of
from .gpu_draw import Drawing
from .gpu_shader import GROUP, ROW, compiled, given
from .kernels.added import added

# Seconds that one dispatch should take: drivers kill those of seconds, and a cancel waits for one.
_DISPATCH = 0.05

# Turns that the loops of one item make in one dispatch, one within the other counted too. Mesa's driver in software
# leaves loops after 65535 of them and says nothing; and others' watchdogs do not know that an item takes long.
_TURNS = 1 << 15


class NumpyDevice:
    """The processor: arrays are numpy's, kernels are called as they are."""

    name, software, traces, most, side = "cpu", True, False, 1 << 62, 1 << 62

    def array(self, values: np.ndarray, channels: int, nowhere: float | None = None) -> np.ndarray:
        """Values where kernels run; see `GpuDevice.array`."""
        return values

    def numpy(self, values: np.ndarray) -> np.ndarray:
        """Values where numpy is."""
        return values

    def run(self, kernel: Callable, *arguments, **settings):
        """A kernel's result for its arguments."""
        return kernel(*arguments, **settings)

    def each(self, function: Callable[[slice], object], n: int, size: int, axis: int = 0) -> Iterator[float]:
        """function(part) for range(n), by `size` items or fewer at once on all cores. A generator of progress; returns
        its results one after the other along an axis: an array, or a tuple where it returns one."""
        found = {}

        def tile(part: slice):
            found[part.start] = function(part)

        parts = tiles.slices(n, size) or [slice(0, 0)]
        yield from tiles.run(tile, parts)
        results = [found[part.start] for part in parts]
        if isinstance(results[0], tuple):
            return tuple(np.concatenate(one, axis) for one in zip(*results))
        return np.concatenate(results, axis)


NUMPY = NumpyDevice()


@dataclass
class _Program:
    """A compiled shader. rate: steps that it does in a second."""

    shader: object
    rate: float = 1e7
    compiled: bool = False


class GpuDevice:
    """The graphics card, or what stands in for it. To be made and used on the main thread, where there is a context.

    name: what Blender calls it. software: whether the processor does its work. traces: whether rays are its own work
    too: a processor is better at that with Embree. bytes: in textures now; peak: so far, to be set back by who asks.
    budget: bytes beyond which no texture is kept for later, and those that nothing works on wait in the processor's
    memory; what one dispatch works on may be more. most: points that an array may be about, of four items each. pools:
    textures kept for later, by width, height and format. stores: arrays that are there, the one that was not needed for
    longest first. side: of a picture that is drawn, in pixels, at the most.
    """

    def __init__(self):
        import gpu

        self._gpu = gpu
        self.name = f"gpu ({gpu.platform.renderer_get()})"
        self.software = gpu.platform.device_type_get() == "SOFTWARE"
        self.traces = not self.software
        self._programs: dict[object, _Program] = {}
        self.pools: dict[tuple, list] = {}
        self.stores: weakref.WeakKeyDictionary[Store, bool] = weakref.WeakKeyDictionary()
        self._waiting: list[Callable[[], None]] = []
        self.moved = self.bytes = self.peak = 0
        self.budget = 1 << 30
        self.side = gpu.capabilities.max_texture_size_get()
        self.most = WIDTH * self.side // 4
        self._fence = gpu.types.GPUTexture((1, 1), format="R32F")

    def array(self, values: np.ndarray | GpuArray, channels: int, nowhere: float | None = None) -> GpuArray:
        """Values on the card, in items of so many channels, 1 to 4, that lie together on the last axes.

        nowhere: what stands for NaN there, which shaders need not know.
        """
        if isinstance(values, GpuArray):
            if values.channels != channels:
                raise ValueError(f"an array of {values.channels} channels is asked for as one of {channels}")
            return values
        values = np.asarray(values)
        if nowhere is not None:
            values = np.nan_to_num(values, nan=nowhere, posinf=np.inf, neginf=-np.inf)
        kind = np.dtype(np.float32) if values.dtype.kind == "f" else values.dtype
        stored = 4 if channels == 3 else channels
        items = values.size // channels
        width, height = extent(items)
        data = np.zeros((width * height, stored), np.float32)
        if stored == channels:
            data[:items] = values.reshape(items, channels)
        else:
            # Three at a time numpy copies four times slower.
            for to, plane in zip(data[:items].T, values.reshape(items, channels).T):
                to[:] = plane
        store = Store(self, (width, height, FORMATS[channels]), False, data.ravel(), is_made=True)
        return GpuArray(store, values.shape, channels, kind)

    def numpy(self, values: GpuArray | np.ndarray) -> np.ndarray:
        """Values on the processor, once all that makes them is done."""
        if isinstance(values, np.ndarray):
            return values
        tiles.finish(self._done())
        data = values.store.read().reshape(-1, 4 if values.channels == 3 else values.channels)
        data = np.ascontiguousarray(data[: values.items, : values.channels])
        return data.reshape(values.shape).astype(values.kind, copy=False)

    def run(self, kernel: Callable, *arguments, **settings):
        """A kernel's result for its arguments, numpy arrays or the card's: the card's."""
        module = __import__(kernel.__module__, fromlist=["_"])
        return getattr(module, f"{kernel.__name__}_on_gpu")(self, *arguments, **settings)

    def each(self, function: Callable[[slice], object], n: int, size: int, axis: int = 0) -> Iterator[float]:
        """function(range(n)) in one go: what it dispatches is cut by itself. A generator of progress."""
        result = function(slice(0, n))
        yield from self._done()
        return result

    def added_up(self, n: int, turns: int, part: Callable[[int, int], GpuArray]) -> GpuArray:
        """The sum over range(n) of what an item's loop finds, part(first, last) for some of it.

        turns: of all loops for one of n, as many as there may be.
        """
        total = None
        for one in tiles.slices(n, _TURNS // turns) or [slice(0, 0)]:
            found = part(one.start, one.stop)
            total = found if total is None else self.run(added, total, found)
        return total

    def empty(self, shape: tuple[int, ...], channels: int, kind: type = np.float32) -> GpuArray:
        """An array of whatever was there."""
        key = (*extent(int(np.prod(shape, dtype=np.int64)) // channels), FORMATS[channels])
        return GpuArray(Store(self, key, True), shape, channels, np.dtype(kind))

    def texture(self, key: tuple[int, int, str], texels: np.ndarray | None, beside: "set[Store]"):
        """A new texture of a width, a height and a format, with texels or whatever was there. beside: what stays."""
        size = size_of(key)
        if self.bytes + size > self.budget:
            for kept, pool in self.pools.items():
                self.bytes -= len(pool) * size_of(kept)
                pool.clear()
        for store in list(self.stores):
            if self.bytes + size > self.budget and store not in beside:
                store.leave()
        self.bytes += size
        self.peak = max(self.peak, self.bytes)
        if texels is None:
            return self._gpu.types.GPUTexture(key[:2], format=key[2])
        self.moved += size
        buffer = self._gpu.types.Buffer("FLOAT", texels.size, texels)
        return self._gpu.types.GPUTexture(key[:2], format=key[2], data=buffer)

    def dispatch(
        self,
        source: str,
        n: int,
        inputs: dict[str, tuple[np.ndarray | GpuArray, int]],
        outputs: dict[str, GpuArray],
        integers: dict[str, int] | None = None,
        floats: dict[str, float] | None = None,
        defines: dict[str, int] | None = None,
        with_sources: tuple[str, ...] = (),
        steps: int = 1,
    ):
        """Runs `void kernel(int i)` of kernels/SOURCE.glsl for each i in range(n), sometime before results are read.

        inputs: values and their channels. In the source an input is a function of an item's index,
        `vec3 position(int i)`, float, vec2, vec3 or vec4 by its channels, a type that is also called `position_t`; an
        output is `set_NAME(i, value)`; integers, floats and defines are there by their names.
        with_sources: files that it builds on. steps: what one item costs, in loops.
        """
        if not n:
            return
        inputs = {name: self.array(*values) for name, values in inputs.items()}
        integers, floats, defines = dict(integers or {}), dict(floats or {}), defines or {}
        key = (source, *((k, v.channels) for k, v in (*inputs.items(), *outputs.items())), *defines.items())
        key = (key, tuple(integers), tuple(floats))
        program = self._programs.get(key)
        if program is None:
            program = self._programs[key] = _Program(
                compiled(self._gpu, source, inputs, outputs, integers, floats, defines, with_sources)
            )

        self._waiting.append(lambda: self._worked(program, n, inputs, outputs, integers, floats, max(1, steps)))

    def draw(
        self,
        source: str,
        size: tuple[int, int],
        rectangle: np.ndarray,
        inputs: dict[str, tuple[np.ndarray | GpuArray, int]],
        nothing: tuple[float, float, float, float],
        reach: float,
        with_sources: tuple[str, ...] = (),
    ) -> GpuArray:
        """Draws rectangles of pixels into a picture: `vec4 kernel(int i, int k)` of kernels/SOURCE.glsl is what
        rectangle k has at pixel i; its last channel says how far away that is, below zero or from `reach` on for
        nothing there.

        size: width and height of the picture. rectangle: (m, 4) integers, first and last column and row, the last not
        included. inputs, with_sources: as for `dispatch`.
        Returns of each pixel the value that is nearest, `nothing` where none is: (w · h, 4), to be read and not to be
        worked on, for it lies in a picture's rows.
        """
        inputs = {"rectangle": (rectangle, 4)} | inputs
        inputs = {name: self.array(*values) for name, values in inputs.items()}
        key = ("draw", source, *((k, v.channels) for k, v in inputs.items()))
        if key not in self._programs:
            self._programs[key] = Drawing(self._gpu, source, inputs, with_sources)
        picture, depth = (Store(self, (*size, form), False) for form in ("RGBA32F", "DEPTH_COMPONENT32F"))
        together = {picture, depth, *(values.store for values in inputs.values())}
        area = (rectangle[:, 1] - rectangle[:, 0]) * (rectangle[:, 3] - rectangle[:, 2]).astype(np.int64)

        def bound(shader):
            for name, values in inputs.items():
                given(shader.uniform_sampler, f"{name}_", values.store.there(together))
            for name, value in zip(("width_", "height_"), size):
                shader.uniform_int(name, value)
            shader.uniform_float("reach_", float(reach))

        def work():
            # Blender's frame buffers do not keep their textures.
            slots = [store.there(together) for store in (picture, depth)]
            frame = self._gpu.types.GPUFrameBuffer(color_slots=slots[:1], depth_slot=slots[1])
            with frame.bind():
                frame.clear(color=nothing, depth=1.0)
            picture.is_made = True
            yield from self._programs[key].draw(frame, self._fence, area, _DISPATCH, bound)

        self._waiting.append(work)
        return GpuArray(picture, (size[0] * size[1], 4), 4, np.dtype(np.float32))

    def _done(self) -> Iterator[float]:
        """Does what waits: a generator of progress."""
        waiting, self._waiting = self._waiting[::-1], []
        count = len(waiting)
        while waiting:
            # Not kept any longer, so that what only this one needs is gone after it.
            for done in waiting.pop()():
                yield (count - 1 - len(waiting) + done) / count
        yield 1.0

    def _worked(self, program, n, inputs, outputs, integers, floats, steps) -> Iterator[float]:
        gpu, shader, first = self._gpu, program.shader, 0
        together = {values.store for values in (*inputs.values(), *outputs.values())}
        while first < n:
            for values in (*inputs.values(), *outputs.values()):
                values.store.there(together)
            count = min(n - first, max(GROUP, int(program.rate * _DISPATCH / steps)))
            begin = time.perf_counter()
            shader.bind()
            for name, values in inputs.items():
                given(shader.uniform_sampler, f"{name}_", values.texture)
            for name, values in outputs.items():
                given(shader.image, f"{name}_", values.texture)
                values.store.is_made = True
            for name, value in (*integers.items(), ("first_", first), ("last_", first + count)):
                given(shader.uniform_int, name, int(value))
            for name, value in floats.items():
                given(shader.uniform_float, name, float(value))
            groups = -(-count // GROUP)
            gpu.compute.dispatch(shader, min(groups, ROW), -(-groups // ROW), 1)
            # A shader that is freed while it is bound takes Blender down at the next bind.
            gpu.shader.unbind()
            self._fence.read()
            seconds = time.perf_counter() - begin
            # What is over in no time says little of how fast it is, and the first dispatch compiles.
            if seconds > _DISPATCH / 4 and program.compiled:
                program.rate = count * steps / seconds
            elif first + count < n:
                program.rate *= 4
            program.compiled = True
            first += count
            yield first / n


Device = NumpyDevice | GpuDevice
