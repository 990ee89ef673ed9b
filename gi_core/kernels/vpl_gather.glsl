// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One sample's light of CANDIDATES, for one point; see vpl_gather.py. Points that follow each other take the same sample
// after each other: in most patterns their lights lie together.

void kernel(int item)
{
  // Some drivers divide whole numbers one by one; by floats it is off by one at the most.
  int s = int(float(item) / float(points));
  int i = item - s * points;
  int off = i < 0 ? -1 : (i >= points ? 1 : 0);
  s += off;
  i -= off * points;
  vec3 here = position(i);
  vec3 up = normal(i);
  vec4 state = state_of(i);
  float scale = scale_of(i);
  float brought[CANDIDATES];
  float sum = 0.0;
  int first = -1;
  for (int c = 0; c < CANDIDATES; c++) {
    int k = s * CANDIDATES + c;
    int light = light_of(state, k);
    first = c == 0 ? light : first;
    if (light >= 0) {
      vec4 at = light_at(light);
      vec4 axis = light_axis(light);
      float arriving = transfer(here, up, at.xyz, axis.xyz, at.w) * (weight_of(state, k) * scale);
      sum += CANDIDATES == 1 ? arriving : arriving * axis.w;
    }
    brought[c] = sum;
  }
#if CANDIDATES == 1
  set_picked(item, vec2(float(first), sum));
#else
  float drawn = hash01(place_of(i) * uint(samples) + uint(s) + uint(first) * 2654435761u, uint(CANDIDATES)) * sum;
  int survivor = 0;
  for (int c = CANDIDATES - 1; c >= 0; c--) {
    survivor = brought[c] > drawn ? c : survivor;
  }
  int light = light_of(state, s * CANDIDATES + survivor);
  float brightness = light < 0 ? 0.0 : light_axis(light).w;
  set_picked(item, vec2(float(light), brightness > 0.0 ? sum / brightness : 0.0));
#endif
}
