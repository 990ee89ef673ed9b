// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later

// Where a ray meets a triangle, whose corners are seen from the ray's start; see rays.py: weights of the second and third
// corner, and the distance, below zero for none.
vec3 met(vec3 a, vec3 b, vec3 c, vec3 direction)
{
  float u = dot(cross(c - a, c + a), direction);
  float v = dot(cross(a - b, a + b), direction);
  float w = dot(cross(b - c, b + c), direction);
  float total = u + v + w;
  float slack = 1.1920929e-07 * abs(total);
  vec3 found = vec3(0.0, 0.0, -1.0);
  if (min(min(u, v), w) >= -slack || max(max(u, v), w) <= slack) {
    vec3 normal = cross(b - a, c - a);
    float slant = dot(normal, direction);
    found = vec3(u / total, v / total, slant != 0.0 ? dot(normal, a) / slant : -1.0);
  }
  return found;
}
