// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One hit to the colour that the previous frame had there; see reproject.py.

void kernel(int i)
{
  int from = int(hit(i));
  vec3 at = before(max(from, 0));
  bool known = from >= 0 && at.x > -0.5 && at.x < float(width) - 0.5 && at.y > -0.5 && at.y < float(height) - 0.5;
  color_t found = color_t(0.0);
  if (known) {
    int tap = clamp(int(roundEven(at.y)), 0, height - 1) * width + clamp(int(roundEven(at.x)), 0, width - 1);
    known = abs(depth(tap) - at.z) <= tolerance * at.z;
    found = known ? color(tap) : found;
  }
  set_found(i, found);
  set_valid(i, known ? 1.0 : 0.0);
}
