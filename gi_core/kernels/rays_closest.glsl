// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Where a ray ends; see rays.py.

void kernel(int i)
{
#if VEIL
  float until_ = until(i);
#else
  float until_ = 0.0;
#endif
  float left;
  vec4 found = followed(origin(i), direction(i), far(i), until_, left);
  if (found.x >= 0.0) {
    found.x = which(int(found.x));
  }
  set_hit(i, found);
}
