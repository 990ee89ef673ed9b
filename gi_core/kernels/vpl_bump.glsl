// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a point's own relief hides of its light; see vpl_bump.py.

void kernel(int item)
{
  int i = item % points;
  vec2 light = picked(item);
  if (light.y > 0.0) {
    vec3 d = light_at(int(light.x)).xyz - position(i);
    light.y *= bump_shadowing(mesh_normal(i), normal(i), d / max(length(d), 1e-20));
  }
  set_found(item, light);
}
