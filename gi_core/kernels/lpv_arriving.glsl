// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The light of all sources in the middle of one cell; see lpv_arriving.py.

float beyond(float r, float limit)
{
  float t = clamp((r / max(limit, 1e-30) - 0.75) / 0.5, 0.0, 1.0);
  return limit <= 0.0 ? 1.0 : (limit >= 1e30 ? 0.0 : t * t * (3.0 - 2.0 * t));
}

void kernel(int i)
{
  vec3 here = middle(i);
  vec3 total[9];
  for (int k = 0; k < 9; k++) {
    total[k] = vec3(0.0);
  }
  for (int s = begin; s < end; s++) {
    vec3 d = here - centre(s);
    float r2 = dot(d, d);
    float weight = beyond(sqrt(r2), inner) - beyond(sqrt(r2), outer);
    if (weight != 0.0) {
      vec3 n = d / sqrt(max(r2, 1e-20));
      vec3 beam = n.x * vector(s * 3) + n.y * vector(s * 3 + 1) + n.z * vector(s * 3 + 2);
      vec4 even = rest(s);
      // Of a patch within its own cell, see lpv_transfer.py.
      float side = 0.517 * cell * cell;
      vec3 arrives = (max(beam, vec3(0.0)) + even.xyz) / sqrt(r2 * r2 + side * side) * weight;
      float share = (arrives.x + arrives.y + arrives.z) / 3.0 * max(r2, cell * cell) / even.w;
      if (share > 1e-5) {
#if SEEN
        bool is_bright = share > 0.05;
        float seen = 0.0;
        for (int k = 0; k < STARTS; k++) {
          if (is_bright || k == (s + i) % STARTS) {
            vec3 from = start(s * STARTS + k);
            vec3 way = here - from;
            float far_ = length(way);
            float free = through(from, way / max(far_, 1e-20), far_ * 0.9999);
            seen += is_bright ? free / float(STARTS) : free;
          }
        }
        arrives *= seen;
#endif
        // The clamped cosine about where it comes from: π, 2π/3, π/5 by band.
        n = -n;
        total[0] += 0.8862269254527580 * arrives;
        total[1] -= 1.0233267079464885 * n.y * arrives;
        total[2] += 1.0233267079464885 * n.z * arrives;
        total[3] -= 1.0233267079464885 * n.x * arrives;
        total[4] += 0.6864684246478268 * n.x * n.y * arrives;
        total[5] -= 0.6864684246478268 * n.y * n.z * arrives;
        total[6] += 0.19816636488030055 * (3.0 * n.z * n.z - 1.0) * arrives;
        total[7] -= 0.6864684246478268 * n.x * n.z * arrives;
        total[8] += 0.3432342123239134 * (n.x * n.x - n.y * n.y) * arrives;
      }
    }
  }
  for (int k = 0; k < 9; k++) {
    set_found(i * 9 + k, total[k]);
  }
}
