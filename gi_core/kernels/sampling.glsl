// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sample points and the shapes they are mapped to, as gi_core/sampling.py has them; after angles.glsl and hash01.glsl.

// A point of a set, shifted for an index.
vec2 rotated(vec2 point, int index, uint seed)
{
  point += vec2(hash01(uint(index), 2u * seed), hash01(uint(index), 2u * seed + 1u));
  return vec2(point.x >= 1.0 ? point.x - 1.0 : point.x, point.y >= 1.0 ? point.y - 1.0 : point.y);
}

vec2 disk(vec2 u)
{
  float a = 2.0 * u.x - 1.0;
  float b = 2.0 * u.y - 1.0;
  bool wide = abs(a) > abs(b);
  float r = wide ? a : b;
  float phi = r == 0.0 ? 0.0 : 0.7853981633974483 * (wide ? b : a) / r;
  float along = small_cosine(phi);
  float across = small_sine(phi);
  return r * (wide ? vec2(along, across) : vec2(across, along));
}

vec3 tangent_of(vec3 normal)
{
  float sign_ = normal.z >= 0.0 ? 1.0 : -1.0;
  float a = -1.0 / (sign_ + normal.z);
  return vec3(1.0 + sign_ * normal.x * normal.x * a, sign_ * (normal.x * normal.y * a), -sign_ * normal.x);
}

vec3 bitangent_of(vec3 normal)
{
  float sign_ = normal.z >= 0.0 ? 1.0 : -1.0;
  float a = -1.0 / (sign_ + normal.z);
  return vec3(normal.x * normal.y * a, sign_ + normal.y * normal.y * a, -normal.y);
}

vec3 cosine_hemisphere(vec3 normal, vec2 u)
{
  vec2 d = disk(u);
  float z = sqrt(max(0.0, 1.0 - (d.x * d.x + d.y * d.y)));
  return d.x * tangent_of(normal) + d.y * bitangent_of(normal) + z * normal;
}
