// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pattern that takes a disk around a point's projection; see `rsm.disk.Disk`.

float scale_of(int i)
{
  return scale(i);
}

int light_of(vec4 state, int k)
{
  vec2 xi = shifted(state, k);
  float phi = 6.28318531 * xi.y;
  vec2 st = state.xy + radius * xi.x * vec2(sin(phi), cos(phi));
  bool inside = st.x >= 0.0 && st.x < 1.0 && st.y >= 0.0 && st.y < 1.0;
  if (!inside) {
    return -1;
  }
  // Just below one the product rounds to the side itself.
  ivec2 texel = min(ivec2(st * float(side)), ivec2(side - 1));
  return int(light_of_texel(texel.y * side + texel.x));
}
