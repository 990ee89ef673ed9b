# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Rectangles drawn on the graphics card, of which each pixel keeps what is nearest."""

import time
from collections.abc import Iterator

import numpy as np

from .gpu_shader import declared, sources

# Rectangles that are drawn at once at the most: the numbers of so many times six corners are kept on the card.
_MOST = 1 << 15

# Two triangles to a rectangle.
_VERTEX = """
void main()
{
  int k = first_ + corner_ / 6;
  int c = corner_ - 6 * (corner_ / 6);
  vec4 r = rectangle(k);
  vec2 at = vec2(c == 1 || c == 2 || c == 4 ? r.y : r.x, c == 2 || c == 4 || c == 5 ? r.w : r.z);
  k_ = k;
  gl_Position = vec4(2.0 * at / vec2(float(width_), float(height_)) - 1.0, 0.0, 1.0);
}
"""

_FRAGMENT = """
void main()
{
  ivec2 at = ivec2(gl_FragCoord.xy);
  vec4 found = kernel_(at.x + at.y * width_, k_);
  if (!(found.w >= 0.0) || found.w >= reach_) {
    discard;
  }
  nearest = found;
  gl_FragDepth = found.w / reach_;
}
"""


class Drawing:
    """A compiled shader that draws, with the corners that it draws."""

    def __init__(self, gpu, source: str, inputs: dict, with_sources: tuple[str, ...]):
        self._gpu = gpu
        info, interface = gpu.types.GPUShaderCreateInfo(), gpu.types.GPUStageInterfaceInfo("drawn")
        interface.flat("INT", "k_")
        readers = declared(info, inputs, ("first_", "width_", "height_"), ("reach_",), {})
        info.vertex_in(0, "INT", "corner_")
        info.vertex_out(interface)
        info.fragment_out(0, "VEC4", "nearest")
        info.depth_write("ANY")
        info.vertex_source("\n".join([*readers, _VERTEX]))
        info.fragment_source("\n".join([*readers, *sources(*with_sources, source), _FRAGMENT]))
        self.shader = gpu.shader.create_from_info(info)
        layout = gpu.types.GPUVertFormat()
        layout.attr_add(id="corner_", comp_type="I32", len=1, fetch_mode="INT")
        corners = gpu.types.GPUVertBuf(layout, 6 * _MOST)
        corners.attr_fill("corner_", np.arange(6 * _MOST, dtype=np.int32))
        self._batch = gpu.types.GPUBatch(type="TRIS", buf=corners)
        # Pixels that are drawn in a second.
        self.rate = 1e7
        self._compiled = False

    def draw(self, frame, fence, area: np.ndarray, seconds: float, bound) -> Iterator[float]:
        """Draws rectangles in turns of about so many seconds. A generator of progress.

        area: (m,) int64 pixels of each. bound: gives the shader what it needs, but which rectangle is the first.
        """
        end, first, state = np.cumsum(area), 0, self._gpu.state
        while first < len(area):
            most = end[first] - area[first] + int(self.rate * seconds)
            last = min(max(first + 1, int(np.searchsorted(end, most, "right"))), first + _MOST)
            begin = time.perf_counter()
            with frame.bind():
                test, mask, blend = state.depth_test_get(), state.depth_mask_get(), state.blend_get()
                state.depth_test_set("LESS")
                state.depth_mask_set(True)
                state.blend_set("NONE")
                self.shader.bind()
                bound(self.shader)
                self.shader.uniform_int("first_", first)
                self._batch.draw_range(self.shader, elem_start=0, elem_count=6 * (last - first))
                self._gpu.shader.unbind()
                state.depth_test_set(test)
                state.depth_mask_set(mask)
                state.blend_set(blend)
            fence.read()
            took = time.perf_counter() - begin
            # What is over in no time says little of how fast it is, and the first draw compiles.
            if took > seconds / 4 and self._compiled:
                self.rate = float(end[last - 1] - end[first] + area[first]) / took
            elif last < len(area):
                self.rate = min(4 * self.rate, 1e12)
            self._compiled = True
            first = last
            yield first / len(area)
