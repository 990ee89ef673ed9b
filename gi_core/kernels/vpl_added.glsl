// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Irradiance of lights by their weights; see vpl_gather.py.

void kernel(int i)
{
  vec3 total = vec3(0.0);
  for (int s = begin; s < end; s++) {
    vec2 light = picked(s * points + i);
    if (light.y > 0.0) {
      total += light.y * flux(int(light.x));
    }
  }
  set_irradiance(i, total);
}
