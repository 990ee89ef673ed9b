// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pattern that takes every so many-th light; see `gathering.Strided`.

vec4 state_of(int i)
{
  return vec4(start(i), 0.0, 0.0, 0.0);
}

float scale_of(int i)
{
  return stride;
}

int light_of(vec4 state, int k)
{
  return min(int((float(k) + state.x) * stride), count - 1);
}

float weight_of(vec4 state, int k)
{
  return 1.0;
}
