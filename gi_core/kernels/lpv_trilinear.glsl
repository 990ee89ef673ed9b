// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What one point has of the eight cells around it; see lpv_trilinear.py.

void kernel(int i)
{
  float part = share(i);
  ivec3 size = ivec3(size_x, size_y, size_z);
  vec3 at = clamp(local(i) - 0.5, vec3(0.0), vec3(size - 1));
  ivec3 low = min(ivec3(at), max(size - 2, ivec3(0)));
  vec3 t = at - vec3(low);
  vec3 total[BANDS];
  for (int k = 0; k < BANDS; k++) {
#if BEFORE
    total[k] = before(i * BANDS + k);
#else
    total[k] = vec3(0.0);
#endif
  }
  for (int corner = 0; corner < 8; corner++) {
    ivec3 way = ivec3(corner >> 2, (corner >> 1) & 1, corner & 1);
    ivec3 cell = min(low + way, size - 1);
    vec3 along = mix(1.0 - t, t, vec3(way));
    float weight = along.x * along.y * along.z * part;
    int place = (cell.x * size_y + cell.y) * size_z + cell.z;
    for (int k = 0; k < BANDS; k++) {
      total[k] += weight * values(place * BANDS + k);
    }
  }
  for (int k = 0; k < BANDS; k++) {
    set_found(i * BANDS + k, total[k]);
  }
}
