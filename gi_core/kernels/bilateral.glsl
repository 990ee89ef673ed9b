// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One pass of the joint bilateral filter, six pixels of a column at once, as far from each other as taps are: most of
// their taps are the same, and reading is what costs. See bilateral.py.

#define PIXELS 6

vec3 here[PIXELS];
vec3 up[PIXELS];
float inverse[PIXELS];
float weights[PIXELS];
value_t total[PIXELS * COLORS];
#if WALLS
float walls_beside[PIXELS * 5];
#endif

// A row of taps, the b-th from below, for the pixels that reach so far.
void row_of_taps(int b, int x, int first)
{
  int row = first + (b - 2) * step_;
  if (row < 0 || row >= height) {
    return;
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
    value_t color[COLORS];
    for (int k = 0; k < COLORS; k++) {
      color[k] = value(tap * COLORS + k);
    }
    for (int p = 0; p < PIXELS; p++) {
      int off = abs(b - p - 2);
      if (off > 2) {
        continue;
      }
      float across = off == 0 ? 0.375 : (off == 1 ? 0.25 : 0.0625);
      float plane = dot(up[p], there - here[p]) * inverse[p];
      float weight = max(dot(up[p], beyond), 0.0);
      weight *= weight;
      weight *= weight;
      weight *= weight;
      weight *= weight;
      float falloff = 1.0 + plane * plane;
      weight *= across * along / (falloff * falloff);
#if WALLS
      weight = in_column == walls_beside[p * 5 + a] ? weight : 0.0;
#endif
      weights[p] += weight;
      for (int k = 0; k < COLORS; k++) {
        total[p * COLORS + k] += weight * color[k];
      }
    }
  }
}

void kernel(int i)
{
  int x = i % width;
  int band = i / width;
  int first = (band / step_) * (PIXELS * step_) + band % step_;
  for (int p = 0; p < PIXELS; p++) {
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
    float in_row = walls(y * width + x).x;
    for (int a = 0; a < 5; a++) {
      // A column's own count where the row has come to it, and one that none has where a wall is on the way.
      vec2 beside = walls(y * width + clamp(x + (a - 2) * step_, 0, width - 1));
      walls_beside[p * 5 + a] = beside.x == in_row ? beside.y : -1.0;
    }
#endif
  }
  // By constants, so that a compiler leaves out what no pixel needs.
  row_of_taps(0, x, first);
  row_of_taps(1, x, first);
  row_of_taps(2, x, first);
  row_of_taps(3, x, first);
  row_of_taps(4, x, first);
  row_of_taps(5, x, first);
  row_of_taps(6, x, first);
  row_of_taps(7, x, first);
  row_of_taps(8, x, first);
  row_of_taps(9, x, first);
  for (int p = 0; p < PIXELS; p++) {
    int y = first + p * step_;
    if (y < height) {
      for (int k = 0; k < COLORS; k++) {
        set_result((y * width + x) * COLORS + k, total[p * COLORS + k] / max(weights[p], 1e-20));
      }
    }
  }
}
