// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// BLOCK points' light where points are in an order in which neighbours take much the same lights, and further ones the
// further their state goes: each light between is fetched once for all of them; see vpl_gather.py.

void kernel(int i)
{
  int point[BLOCK];
  vec3 here[BLOCK];
  vec3 up[BLOCK];
  vec4 state[BLOCK];
  vec3 total[BLOCK];
  vec4 low = vec4(1e30);
  vec4 high = vec4(-1e30);
  for (int b = 0; b < BLOCK; b++) {
    point[b] = int(order(min(i * BLOCK + b, points - 1)));
    here[b] = position(point[b]);
    up[b] = normal(point[b]);
    state[b] = state_of(point[b]);
    total[b] = vec3(0.0);
    low = min(low, state[b]);
    high = max(high, state[b]);
  }
  for (int k = begin; k < end; k++) {
    int last = light_of(high, k);
    for (int light = light_of(low, k); light <= last; light++) {
      vec4 at = light_at(light);
      vec3 axis = light_axis(light).xyz;
      vec3 sent = flux(light);
      for (int b = 0; b < BLOCK; b++) {
        if (light_of(state[b], k) == light) {
          total[b] += transfer(here[b], up[b], at.xyz, axis, at.w) * sent;
        }
      }
    }
  }
  for (int b = 0; b < BLOCK; b++) {
    if (i * BLOCK + b < points) {
      set_irradiance(point[b], total[b] * scale_of(point[b]));
    }
  }
}
