// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How far two points count as one surface; see surface_weight.py.

float plane_weight(vec3 dq, float off, float scale)
{
  float d2 = dot(dq, dq);
  if (d2 < (0.01 * scale) * (0.01 * scale)) {
    return 1.0;
  }
  float plane = max(0.0, 1.0 - 2.0 * off / sqrt(d2));
  return plane * plane;
}

float surface_weight(
    float depth, vec3 here, vec3 up, float tap_depth, vec3 there, vec3 tap_up, float scale, int literal)
{
  float cosine = max(dot(up, tap_up), 0.0);
  float closeness = literal == 1 ? sqrt(sqrt(cosine)) : cosine * cosine * (cosine * cosine);
  vec3 dq = there - here;
  float plane = plane_weight(dq, max(abs(dot(dq, up)), abs(dot(dq, tap_up))), scale);
  return max(0.0, 1.0 - abs(depth - tap_depth)) * min(closeness, 1.0) * plane;
}
