// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Irradiance over flux; see vpl_transfer.py. BOUND: its place in `vpl_gather.BOUNDS`.

float transfer(vec3 here, vec3 up, vec3 light, vec3 axis, float area)
{
  vec3 d = light - here;
  float cos_x = max(dot(up, d), 0.0);
  float cos_p = max(-dot(axis, d), 0.0);
#if BOUND == 3
  bool facing = cos_x > 0.0 && cos_p > 0.0;
  d -= sqrt(area / 3.14159265) * axis;
  cos_x = facing ? max(dot(up, d), 0.0) : 0.0;
  cos_p = -dot(axis, d);
#endif
  float d2 = dot(d, d);
  float disk = 3.14159265 * d2;
#if BOUND == 0
  disk += area;
#elif BOUND == 1
  disk = max(disk, area);
#endif
  float found = cos_x * cos_p / (max(d2, 1e-18) * max(disk, 1e-18));
#if BOUND == 2
  found = min(found, 1.0 / max(area, 1e-18));
#endif
  return found;
}
