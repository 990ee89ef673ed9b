// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One point's light from the lights that its pattern takes, without a list of them; see vpl_gather.py.

void kernel(int i)
{
  vec3 here = position(i);
  vec3 up = normal(i);
  vec4 state = state_of(i);
  float scale = scale_of(i);
  vec3 total = vec3(0.0);
  for (int k = begin; k < end; k++) {
    int light = light_of(state, k);
    if (light >= 0) {
      vec4 at = light_at(light);
      float arriving = transfer(here, up, at.xyz, light_axis(light).xyz, at.w);
      if (arriving > 0.0) {
        total += arriving * (weight_of(state, k) * scale) * flux(light);
      }
    }
  }
  set_irradiance(i, total);
}
