// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Where pixel i's ray meets rectangle k's triangle; see raster.py.
vec4 kernel(int i, int k)
{
  int t = int(which(k));
  vec3 start = origin(i);
  vec3 hit = met(corner_a(t) - start, corner_b(t) - start, corner_c(t) - start, direction(i));
  return vec4(float(t), hit);
}
