// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One slice of the horizon scan; see horizon_scan.py.

// ∫ cos(t − γ) |sin t| dt from 0 to θ; around: the sine and the cosine of γ.
float arc(float theta, float gamma, vec2 around)
{
  theta = clamp(theta, -3.141592653589793, 3.141592653589793);
  float whole = (2.0 * theta * around.x - sine_cosine(2.0 * theta - gamma).y + around.y) * 0.25;
  return theta < 0.0 ? -whole : whole;
}

// The sectors up to a number of them.
uint sectors(float edge)
{
  uint n = uint(floor(edge));
  return n >= 32u ? 0xFFFFFFFFu : (1u << n) - 1u;
}

float bits_in(uint bits)
{
  bits = bits - ((bits >> 1u) & 0x55555555u);
  bits = (bits & 0x33333333u) + ((bits >> 2u) & 0x33333333u);
  bits = (bits + (bits >> 4u)) & 0x0F0F0F0Fu;
  return float((bits * 0x01010101u) >> 24u);
}

float reached(float k, float shift)
{
  float way = max(k + shift, 0.0) / float(steps);
  return 1.0 + k + span * way * way * sqrt(way);
}

// Where the plane through a point is, seen so far from it on the plane z = 1.
vec3 on_plane(vec3 at, vec3 up, vec2 shift)
{
  float z;
  if (parallel == 1) {
    z = at.z - dot(up.xy, shift) / up.z;
  }
  else {
    z = at.z * dot(up, at) / dot(up, at + at.z * vec3(shift, 0.0));
  }
  // Not where z is no number, as of a plane seen from its edge.
  bool there = z > 0.0 && z < 1e30;
  z = clamp(there ? z : 1e30, at.z / 1.5, at.z * 1.5);
  return vec3(parallel == 1 ? at.xy + shift : (at.xy / max(at.z, 1e-20) + shift) * z, z);
}

void kernel(int i)
{
  int pixel = int(pixels(i / SLICES));
  vec3 random = u(i);
  vec3 here = position(pixel);
  vec3 up = normal(pixel);
  vec3 away = parallel == 1 ? vec3(0.0, 0.0, here.z) : here;
  float far_off = sqrt(dot(away, away));
  vec3 view = far_off > 0.0 ? -away / far_off : vec3(0.0);
  vec2 turn = sine_cosine(3.141592653589793 * random.x);
  vec3 along = turn.y * tangent_of(view) + turn.x * bitangent_of(view);
  float a = dot(up, view);
  float b = dot(up, along);
  float gamma = angle_of(b, a);
  vec2 around = sine_cosine(gamma);
  float low = arc(gamma - 1.5707963267948966, gamma, around);
  float whole = arc(gamma + 1.5707963267948966, gamma, around) - low;

  vec2 unit = vec2(unit_x, unit_y);
  vec2 way = (parallel == 1 ? along.xy : along.xy * here.z - here.xy * along.z) * unit;
  way /= max(sqrt(dot(way, way)), 1e-20);
  float column = float(pixel % width);
  float row = float(pixel / width);
  uint covered = 0u;
  float lit = 0.0;
  color_t arrived = color_t(0.0);
#if SHOWN
  // What lies below the surface is neither seen nor open.
  vec3 mesh_up = shown(pixel);
  float horizon = angle_of(dot(mesh_up, along), dot(mesh_up, view));
  float edges[2];
  for (int e = 0; e < 2; e++) {
    float theta = horizon + (e == 0 ? -1.5707963267948966 : 1.5707963267948966);
    theta = clamp(theta, gamma - 1.5707963267948966, gamma + 1.5707963267948966);
    edges[e] = clamp((arc(theta, gamma, around) - low) / whole, 0.0, 1.0) * 32.0 + random.z;
  }
  covered = ~(sectors(max(edges[0], edges[1])) & ~sectors(min(edges[0], edges[1])));
  lit = bits_in(covered);
#endif
  float r = reached(-1.0, random.y);
  float following = reached(0.0, random.y);
  for (int k = 0; k < steps; k++) {
    float last = r;
    r = following;
    following = reached(float(k + 1), random.y);
    float begin = k > 0 ? (last - r) / 2.0 : 0.5 - r;
    float end = (following - r) / 2.0;
    for (int other = 0; other < 2; other++) {
      float side = other == 0 ? 1.0 : -1.0;
      float x = roundEven(column + side * r * way.x);
      float y = roundEven(row + side * r * way.y);
      if (!(x >= 0.0 && x < float(width) && y >= 0.0 && y < float(height))) {
        continue;
      }
      int tap = int(y) * width + int(x);
#if SHOWN
      vec3 facing = shown(tap);
#else
      vec3 facing = normal(tap);
#endif
      if (facing == vec3(0.0)) {
        continue;
      }
      vec3 at = position(tap);
      vec2 off = vec2(column - x, row - y);
      vec3 first = on_plane(at, facing, (off + side * (r + begin) * way) / unit);
      vec3 final = on_plane(at, facing, (off + side * (r + end) * way) / unit);
      vec3 behind = final + thickness * (parallel == 1 ? vec3(0.0, 0.0, final.z) : final);
      float least = 1.0;
      float most = 0.0;
      for (int e = 0; e < 3; e++) {
        vec3 d = (e == 0 ? first : e == 1 ? final : behind) - here;
        float theta = angle_of(dot(d, along), dot(d, view));
        theta = clamp(theta, gamma - 1.5707963267948966, gamma + 1.5707963267948966);
        float share = clamp((arc(theta, gamma, around) - low) / whole, 0.0, 1.0);
        least = min(least, share);
        most = max(most, share);
      }
      uint bits = sectors(most * 32.0 + random.z) & ~sectors(least * 32.0 + random.z);
      if (dot(facing, at - here) < 0.0) {
        float share = bits_in(bits & ~covered);
        arrived += share * color(tap);
        lit += share;
      }
      covered |= bits;
    }
  }
  float scale = up == vec3(0.0) ? 0.0 : sqrt(a * a + b * b) * whole / 32.0;
  set_arrived(i, arrived * scale);
  set_open_share(i, (32.0 - lit) * scale);
}
