// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The light that one cell gets in one step; see lpv_propagate.py. Numbers of an axis are 0, 1, 2; a cell's place is in C
// order.

vec3 component(int cell, int k)
{
  return front(k * size_x * size_y * size_z + cell);
}

float open_between(int cell, int axis)
{
#if WALLS
  return 1.0 - blocked(axis * size_x * size_y * size_z + cell);
#else
  return 1.0;
#endif
}

void kernel(int i)
{
  ivec3 size = ivec3(size_x, size_y, size_z);
  ivec3 stride = ivec3(size_y * size_z, size_z, 1);
  ivec3 at = ivec3(i / stride.x, (i / size_z) % size_y, i % size_z);
  int cells = size_x * size_y * size_z;
  float ahead = 0.894427190999916;
  float aside = 0.447213595499958;
  float front_share = 0.12753712170232;
  float side_share = 0.13478238622571;
  vec3 u = vec3(0.0);
  vec3 v[3];
  v[0] = vec3(0.0);
  v[1] = vec3(0.0);
  v[2] = vec3(0.0);
  for (int axis = 0; axis < 3; axis++) {
    for (int k = 0; k < 2; k++) {
      float direction = k == 0 ? 1.0 : -1.0;
      int turned = k == 0 ? 1 : -1;
#if BOUNCE
      // What this cell sends that way comes back from what stands there.
      for (int back = 0; back < 2; back++) {
#else
      for (int back = 0; back < 1; back++) {
#endif
        int other = at[axis] + (back == 1 ? turned : -turned);
        if (other < 0 || other >= size[axis]) {
          continue;
        }
        int source = back == 1 ? i : i - turned * stride[axis];
        // Of two neighbours the lower one knows what stands between them.
        int lower = min(at[axis], other) == at[axis] ? i : i + (other - at[axis]) * stride[axis];
        float open_share = open_between(lower, axis);
        vec3 su = component(source, 0);
        vec3 sv = component(source, 1 + axis);
        vec3 along = su + direction * ahead * sv;
        vec3 sent = max(su + direction * sv, vec3(0.0)) * front_share;
        vec3 total = sent;
        for (int turn = 1; turn < 3; turn++) {
          int side = (axis + turn) % 3;
          vec3 across = aside * component(source, 1 + side);
          vec3 plus = max(along + across, vec3(0.0)) * side_share;
          vec3 minus = max(along - across, vec3(0.0)) * side_share;
          total += plus + minus;
          if (back == 0) {
            v[side] += 0.5 * (plus - minus) * open_share;
          }
        }
        if (back == 0) {
          u += 0.25 * total * open_share;
          v[axis] += (0.5 * direction) * sent * open_share;
        }
#if BOUNCE
        else {
          vec3 returned = total * (1.0 - open_share) * albedo(axis * cells + lower);
          u += 0.25 * returned;
          v[axis] -= (0.5 * direction) * returned;
        }
#endif
      }
    }
  }
  set_next(i, u * damping);
  set_next(cells + i, v[0] * damping);
  set_next(2 * cells + i, v[1] * damping);
  set_next(3 * cells + i, v[2] * damping);
}
