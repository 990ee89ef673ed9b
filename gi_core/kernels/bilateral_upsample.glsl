// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One point between the pixels of a coarse image; see bilateral_upsample.py.

void kernel(int i)
{
  vec2 place = at(i);
  value_t total = value_t(0.0);
  float counted = 0.0;
  float shown = 0.0;
  if (place.x > -1e29 && place.y > -1e29) {
    vec3 here = position(i);
    vec3 up = normal(i);
    float z = depth(i) / far_;
    float metre = scale(i);
    place = clamp(place, vec2(0.0), vec2(float(width - 1), float(height - 1)));
    vec2 low = min(floor(place), vec2(float(max(width - 2, 0)), float(max(height - 2, 0))));
    vec2 part = place - low;
    for (int k = 0; k < 4; k++) {
      float share = ((k & 1) == 1 ? part.x : 1.0 - part.x) * (k >= 2 ? part.y : 1.0 - part.y);
      int tap = min(int(low.y) + (k >> 1), height - 1) * width + min(int(low.x) + (k & 1), width - 1);
      float there = coarse_depth(tap);
      if (!(there < 1e30)) {
        continue;
      }
      vec3 beside = coarse_position(tap);
      vec3 facing = coarse_normal(tap);
      float weight = share * max(surface_weight(z, here, up, there / far_, beside, facing, metre, 0), 1e-4);
      total += weight * value(tap);
      counted += weight;
      if (share > 0.0 && dot(up, facing) > 0.0) {
        vec3 dq = beside - here;
        shown = max(shown, plane_weight(dq, abs(dot(dq, facing)), metre));
      }
    }
  }
  set_result(i, total / max(counted, 1e-20));
  set_shown(i, shown);
}
