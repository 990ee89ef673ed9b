// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One colour, darkened; see clamped.py.

void kernel(int i)
{
  vec3 color = radiance(i);
  set_held(i, color * min(1.0, most / max(max(color.x, max(color.y, color.z)), 1e-20)));
}
