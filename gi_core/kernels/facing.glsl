// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A pixel's normal and footprint in one place; a normal of zero where there is no surface.

void kernel(int i)
{
  float size = footprint(i);
  set_facing(i, vec4(size > 0.0 ? normal(i) : vec3(0.0), size));
}
