// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One pass of the joint bilateral filter; see bilateral.py.

void kernel(int i)
{
  int x = i % width;
  int y = i / width;
  float own = footprint(i);
  value_t total[COLORS];
  for (int k = 0; k < COLORS; k++) {
    total[k] = value_t(0.0);
  }
  if (own <= 0.0) {
    for (int k = 0; k < COLORS; k++) {
      set_result(i * COLORS + k, value_t(0.0));
    }
    return;
  }
  vec3 here = position(i);
  vec3 up = normal(i);
#if WALLS
  vec2 walls_here = walls(i);
#endif
  float inverse = 1.0 / max(own * float(step_), 1e-20);
  float spline[5] = float[5](0.0625, 0.25, 0.375, 0.25, 0.0625);
  float weights = 0.0;
  for (int b = 0; b < 5; b++) {
    int row = y + (b - 2) * step_;
    if (row < 0 || row >= height) {
      continue;
    }
    for (int a = 0; a < 5; a++) {
      int column = x + (a - 2) * step_;
      if (column < 0 || column >= width) {
        continue;
      }
      int tap = row * width + column;
      if (footprint(tap) <= 0.0) {
        continue;
      }
#if WALLS
      vec2 beside = walls(y * width + column);
      if (beside.x != walls_here.x || beside.y != walls(tap).y) {
        continue;
      }
#endif
      float plane = min(abs(dot(up, position(tap) - here)) * inverse, 1e4);
      float weight = max(dot(up, normal(tap)), 0.0);
      weight *= weight;
      weight *= weight;
      weight *= weight;
      weight *= weight;
      float falloff = 1.0 + plane * plane;
      weight *= spline[b] * spline[a] / (falloff * falloff);
      weights += weight;
      for (int k = 0; k < COLORS; k++) {
        total[k] += weight * value(tap * COLORS + k);
      }
    }
  }
  for (int k = 0; k < COLORS; k++) {
    set_result(i * COLORS + k, total[k] / max(weights, 1e-20));
  }
}
