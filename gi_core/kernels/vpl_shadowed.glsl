// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How much of its light a point sees; see vpl_shadowed.py.

void kernel(int item)
{
  int i = item % points;
  vec2 light = picked(item);
  if (light.y > 0.0) {
    vec3 start = origin(i);
    vec3 d = light_origin(int(light.x)) - start;
    float distance_ = length(d);
    if (dot(d, face(i)) > 0.0) {
      light.y *= through(start, d / max(distance_, 1e-20), distance_ * 0.9999);
    }
    else {
      light.y = 0.0;
    }
  }
  set_found(item, light);
}
