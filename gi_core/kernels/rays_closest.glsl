// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The nearest hit of a ray; see rays.py.

void kernel(int i)
{
  vec4 found = traced(origin(i), direction(i), far(i));
  if (found.x >= 0.0) {
    found.x = which(int(found.x));
  }
  set_hit(i, found);
}
