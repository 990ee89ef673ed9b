// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What the light around one point brings to its surface; see lpv_received.py.

void kernel(int i)
{
  vec3 n = normal(i);
  float basis[9];
  basis[0] = 0.28209479177387814;
  basis[1] = -0.48860251190291992 * n.y;
  basis[2] = 0.48860251190291992 * n.z;
  basis[3] = -0.48860251190291992 * n.x;
  basis[4] = 1.0925484305920792 * n.x * n.y;
  basis[5] = -1.0925484305920792 * n.y * n.z;
  basis[6] = 0.31539156525252005 * (3.0 * n.z * n.z - 1.0);
  basis[7] = -1.0925484305920792 * n.x * n.z;
  basis[8] = 0.5462742152960396 * (n.x * n.x - n.y * n.y);
  vec3 light = vec3(0.0);
  vec3 product = vec3(0.0);
  vec3 square = vec3(0.0);
  vec3 change = vec3(0.0);
  for (int k = 0; k < BANDS; k++) {
    vec3 here = found(i * BANDS + k);
    light += basis[k] * here;
#if DAMPED
    vec3 further = ahead(i * BANDS + k) - here;
    product += here * further;
    square += here * here;
    change += further * further;
#endif
  }
  float counted = factor(i);
#if DAMPED
  vec3 norms = square * change;
  float believed = 0.0;
  for (int c = 0; c < 3; c++) {
    believed = max(believed, norms[c] > 0.0 ? product[c] / sqrt(norms[c]) : 0.0);
  }
  believed = min(believed, 1.0);
  counted *= believed > 0.0 ? pow(believed, exponent) : 0.0;
#endif
  set_irradiance(i, max(light, vec3(0.0)) * counted);
}
