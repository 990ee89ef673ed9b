// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The lattice points around a point of an image; see lattice.py.

void kernel(int i)
{
  ivec2 here = ivec2(pixel(i));
  ivec2 last = ivec2(width, height) - 1;
  ivec2 low = here / step_ * step_;
  ivec2 high = min(low + step_, last);
  vec2 u = vec2(here - low) / vec2(max(high - low, ivec2(1)));
  // Not every driver's quotient of equal numbers is one.
  u.x = here.x == high.x && high.x > low.x ? 1.0 : u.x;
  u.y = here.y == high.y && high.y > low.y ? 1.0 : u.y;
  vec4 bilinear = vec4((1.0 - u.y) * (1.0 - u.x), (1.0 - u.y) * u.x, u.y * (1.0 - u.x), u.y * u.x);
  vec4 rows = vec4(-1.0);
  vec4 like = vec4(0.0);
  vec3 at = position(i);
  vec3 up = normal(i);
  float unit = span(i);
  for (int k = 0; k < 4; k++) {
    int place = (k < 2 ? low.y : high.y) * width + (k == 0 || k == 2 ? low.x : high.x);
    float row = place < places ? row_of_place(place) : -1.0;
    rows[k] = row;
    if (row >= 0.0) {
      vec3 dn = normal(int(row)) - up;
      vec3 dp = position(int(row)) - at;
      float found = exp(-dot(dn, dn) - dot(dp, dp) / (4.0 * unit * unit));
      like[k] = found < 0.5 ? 0.0 : found;
    }
  }
  bool is_lattice = (here.x == low.x || here.x == high.x) && (here.y == low.y || here.y == high.y);
  set_neighbours(i, rows);
  set_weights(i, bilinear * like);
  set_kind(i, is_lattice ? 1.0 : (like.x + like.y + like.z + like.w > 3.0 ? 2.0 : 0.0));
}
