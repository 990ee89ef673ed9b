// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Rays marched through the depth of an image; see depth_march.py.

void kernel(int i)
{
  ivec2 found = marched(origin(i), direction(i));
  set_hit(i, float(found.x));
  set_hidden(i, float(found.y));
}
