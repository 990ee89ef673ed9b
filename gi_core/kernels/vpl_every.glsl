// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The pattern that takes every light; see `gathering.Every`.

vec4 state_of(int i)
{
  return vec4(0.0);
}

float scale_of(int i)
{
  return 1.0;
}

int light_of(vec4 state, int k)
{
  return k;
}

float weight_of(vec4 state, int k)
{
  return 1.0;
}
