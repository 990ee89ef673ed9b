// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A point's samples in the disk; see `rsm.disk.Disk`. Its state is its projection and the shift of its samples.

vec4 state_of(int i)
{
  uint key = place_of(i);
  return vec4(projection(i), hash01(key, 2u * uint(pattern_seed)), hash01(key, 2u * uint(pattern_seed) + 1u));
}

vec2 shifted(vec4 state, int k)
{
  vec2 xi = sample_point(k) + state.zw;
  return xi - vec2(xi.x >= 1.0 ? 1.0 : 0.0, xi.y >= 1.0 ? 1.0 : 0.0);
}

float weight_of(vec4 state, int k)
{
  float xi = shifted(state, k).x;
  return literal != 0 ? xi * xi : xi;
}
