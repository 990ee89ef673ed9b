// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// A ray down the hierarchy of boxes; see rays.py and bvh.py. ANY: whether it meets something counts, and not where.
// VEIL: triangles may let light through, see veil.glsl.

// Where a ray enters a box, or a number beyond all where it passes by. A little wider than the box, for rounding.
float entered(vec3 origin, vec3 inverse, float far_, vec3 low, vec3 high)
{
  vec3 a = (low - origin) * inverse;
  vec3 b = (high - origin) * inverse;
  vec3 near3 = min(a, b);
  vec3 far3 = max(a, b);
  float begin = max(max(near3.x, near3.y), max(near3.z, 0.0));
  float end = min(min(far3.x, far3.y), far3.z) * 1.0000008;
  return begin <= end && begin * 0.9999992 <= far_ ? begin : 3e38;
}

float inverted(float x)
{
  return abs(x) < 1e-18 ? (x < 0.0 ? -1e18 : 1e18) : 1.0 / x;
}

// A box as one number: the first of those in it, or, below zero, the triangles in it, at most seven.
int entry_of(vec4 low, vec4 high)
{
  int count = int(high.w);
  return count > 0 ? -(int(low.w) * 8 + count) : int(low.w);
}

// The nearest hit behind a distance, or of what lets no light through, in front of which all rays are: the triangle's
// place in the hierarchy, −1 for a miss, weights of its second and third corner, distance. Of hits at one distance it is
// the first triangle's.
vec4 traced(vec3 origin, vec3 direction, float far_, float beyond)
{
  vec4 hit = vec4(-1.0, 0.0, 0.0, far_);
  vec3 inverse = vec3(inverted(direction.x), inverted(direction.y), inverted(direction.z));
  int stack[60];
  int top = 0;
  int entry = entry_of(box_low(0), box_high(0));
  bool is_open = true;
  while (is_open) {
    bool is_pushed = false;
    if (entry < 0) {
      int first = (-entry) / 8;
      int last = first + (-entry) % 8;
      for (int k = first; k < last; k++) {
        vec3 a = corner_a(k) - origin;
        vec3 b = corner_b(k) - origin;
        vec3 c = corner_c(k) - origin;
        vec3 found = met(a, b, c, direction);
        float at = found.z;
        float k_ = float(k);
        bool is_nearer = at < hit.w || (at == hit.w && (hit.x < 0.0 || k_ < hit.x));
        if (at >= 0.0 && is_nearer) {
#if VEIL
          if (at > beyond || veil_second(k).z < 0.0) {
            hit = vec4(k_, found);
          }
#else
          hit = vec4(k_, found);
#endif
        }
      }
    }
    else {
      vec4 low_0 = box_low(entry);
      vec4 high_0 = box_high(entry);
      vec4 low_1 = box_low(entry + 1);
      vec4 high_1 = box_high(entry + 1);
      float at_0 = entered(origin, inverse, hit.w, low_0.xyz, high_0.xyz);
      float at_1 = entered(origin, inverse, hit.w, low_1.xyz, high_1.xyz);
      int entry_0 = entry_of(low_0, high_0);
      int entry_1 = entry_of(low_1, high_1);
      bool is_swapped = at_1 < at_0;
      float nearer = min(at_0, at_1);
      if (nearer < 3e38) {
        entry = is_swapped ? entry_1 : entry_0;
        is_pushed = true;
        if (max(at_0, at_1) < 3e38) {
          stack[top] = is_swapped ? entry_0 : entry_1;
          top++;
        }
      }
    }
    if (!is_pushed) {
      is_open = top > 0;
      if (is_open) {
        top--;
        entry = stack[top];
      }
    }
#if ANY && !VEIL
    is_open = is_open && hit.x < 0.0;
#endif
  }
  return hit;
}

// Where a ray ends, as `traced` has it; left: of it what comes through until there.
vec4 followed(vec3 origin, vec3 direction, float far_, float until_, out float left)
{
  vec4 found = vec4(-1.0, 0.0, 0.0, -1.0);
  float nearby = 1e-6 * max(max(abs(origin.x), abs(origin.y)), abs(origin.z));
  float beyond = -1.0;
  bool is_open = true;
  left = 1.0;
  while (is_open) {
    found = traced(origin, direction, far_, beyond);
    // What is as far is the same surface: an edge belongs to two triangles.
    beyond = found.w * 1.000015 + nearby;
    is_open = false;
    if (found.x >= 0.0) {
#if VEIL
      left *= 1.0 - solid(int(found.x), found.yz);
      is_open = left > until_;
#else
      left = 0.0;
#endif
    }
  }
  return found;
}

// The share of light that comes through.
float through(vec3 origin, vec3 direction, float far_)
{
  float left;
  followed(origin, direction, far_, 0.0, left);
  return left;
}
