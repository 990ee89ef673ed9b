// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pixels of the history that show one point; see temporal.py.

void kernel(int i)
{
  vec2 at = before(i);
  bool known = at.x > -1e29 && at.y > -1e29;
  at = known ? at : vec2(0.0);
  vec2 low = floor(at);
  vec2 part = at - low;
  float reach = max(limit(i), 4.0 * footprint(i) / max(slant(i), 1e-6));
  vec3 up = normal(i);
  vec3 there = expected(i);
  vec4 pixels = vec4(0.0);
  vec4 counted = vec4(0.0);
  for (int k = 0; k < 4; k++) {
    float column = low.x + float(k & 1);
    float row = low.y + float(k >> 1);
    bool inside = known && column >= 0.0 && column < float(width) && row >= 0.0 && row < float(height);
    int tap = inside ? int(row) * width + int(column) : 0;
    vec3 d = position(tap) - there;
    bool same = dot(history_normal(tap), up) >= 0.65 && dot(d, d) <= reach * reach;
    float a = (k & 1) == 1 ? part.x : 1.0 - part.x;
    float b = k >= 2 ? part.y : 1.0 - part.y;
    pixels[k] = float(tap);
    counted[k] = inside && same ? a * b : 0.0;
  }
  float total = counted.x + counted.y + counted.z + counted.w;
  set_taps(i, pixels);
  set_weights(i, total > 1e-3 ? counted / total : vec4(0.0));
}
