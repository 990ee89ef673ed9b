// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Lattice points' light by their weights; see lattice.py.

void kernel(int i)
{
  vec4 rows = neighbours(i);
  vec4 weight = weights(i);
  vec3 total = vec3(0.0);
  for (int k = 0; k < 4; k++) {
    if (weight[k] > 0.0) {
      total += weight[k] * irradiance(int(rows[k]));
    }
  }
  set_result(i, total / max(weight.x + weight.y + weight.z + weight.w, 1e-20));
}
