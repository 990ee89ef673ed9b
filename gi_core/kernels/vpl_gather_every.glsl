// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// BLOCK points' light from every light, each of which is fetched for all of them at once; see vpl_gather.py.

void kernel(int i)
{
  vec3 here[BLOCK];
  vec3 up[BLOCK];
  vec3 total[BLOCK];
  for (int b = 0; b < BLOCK; b++) {
    int point = min(i * BLOCK + b, points - 1);
    here[b] = position(point);
    up[b] = normal(point);
    total[b] = vec3(0.0);
  }
  for (int k = begin; k < end; k++) {
    vec4 at = light_at(k);
    vec3 axis = light_axis(k).xyz;
    vec3 sent = flux(k);
    for (int b = 0; b < BLOCK; b++) {
      total[b] += transfer(here[b], up[b], at.xyz, axis, at.w) * sent;
    }
  }
  for (int b = 0; b < BLOCK; b++) {
    if (i * BLOCK + b < points) {
      set_irradiance(i * BLOCK + b, total[b]);
    }
  }
}
