// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One pass of the joint bilateral filter, BLOCK pixels of a column at once, as far from each other as taps are: most of
// their taps are the same, and reading is what costs. See bilateral.py.

void kernel(int i)
{
  int x = i % width;
  int band = i / width;
  int first = (band / step_) * (BLOCK * step_) + band % step_;
  vec3 here[BLOCK];
  vec3 up[BLOCK];
  float inverse[BLOCK];
  float weights[BLOCK];
  value_t total[BLOCK * COLORS];
#if WALLS
  vec2 walls_here[BLOCK];
  float walls_beside[BLOCK * 5];
#endif
  for (int p = 0; p < BLOCK; p++) {
    // Pixels beyond the image are worked out as the last one, and not kept.
    int y = min(first + p * step_, height - 1);
    vec4 own = facing(y * width + x);
    here[p] = position(y * width + x);
    up[p] = own.xyz;
    inverse[p] = 1.0 / max(own.w * float(step_), 1e-20);
    weights[p] = 0.0;
    for (int k = 0; k < COLORS; k++) {
      total[p * COLORS + k] = value_t(0.0);
    }
#if WALLS
    walls_here[p] = walls(y * width + x);
    for (int a = 0; a < 5; a++) {
      // A column's own count where the row has come to it, and one that none has where a wall is on the way.
      vec2 beside = walls(y * width + clamp(x + (a - 2) * step_, 0, width - 1));
      walls_beside[p * 5 + a] = beside.x == walls_here[p].x ? beside.y : -1.0;
    }
#endif
  }
  for (int b = 0; b < BLOCK + 4; b++) {
    int row = first + (b - 2) * step_;
    if (row < 0 || row >= height) {
      continue;
    }
    for (int a = 0; a < 5; a++) {
      int column = x + (a - 2) * step_;
      if (column < 0 || column >= width) {
        continue;
      }
      int tap = row * width + column;
      vec3 there = position(tap);
      vec3 beyond = facing(tap).xyz;
      float along = a == 2 ? 0.375 : (a == 1 || a == 3 ? 0.25 : 0.0625);
#if WALLS
      float in_column = walls(tap).y;
#endif
      float weight[BLOCK];
      for (int p = 0; p < BLOCK; p++) {
        int off = abs(b - p - 2);
        float across = off == 0 ? 0.375 : (off == 1 ? 0.25 : (off == 2 ? 0.0625 : 0.0));
        float plane = min(abs(dot(up[p], there - here[p])) * inverse[p], 1e4);
        float w = max(dot(up[p], beyond), 0.0);
        w *= w;
        w *= w;
        w *= w;
        w *= w;
        float falloff = 1.0 + plane * plane;
        w *= across * along / (falloff * falloff);
#if WALLS
        w = in_column == walls_beside[p * 5 + a] ? w : 0.0;
#endif
        weight[p] = w;
        weights[p] += w;
      }
      for (int k = 0; k < COLORS; k++) {
        value_t color = value(tap * COLORS + k);
        for (int p = 0; p < BLOCK; p++) {
          total[p * COLORS + k] += weight[p] * color;
        }
      }
    }
  }
  for (int p = 0; p < BLOCK; p++) {
    int y = first + p * step_;
    if (y < height) {
      for (int k = 0; k < COLORS; k++) {
        set_result((y * width + x) * COLORS + k, total[p * COLORS + k] / max(weights[p], 1e-20));
      }
    }
  }
}
