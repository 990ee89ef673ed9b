// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How much of the light from a direction counts on a surface with a mapped normal; see gi_core/bump.py.

float tangent2(float cosine)
{
  float square = clamp(cosine * cosine, 1e-12, 1.0);
  return (1.0 - square) / square;
}

float bump_shadowing(vec3 mesh_up, vec3 up, vec3 way)
{
  float of_normal = dot(mesh_up, up);
  float of_light = dot(mesh_up, way);
  float width = min(tangent2(of_normal) / 8.0, 1.0);
  return min(of_normal, of_light) > 0.0 ? 2.0 / (1.0 + sqrt(1.0 + width * tangent2(of_light))) : 0.0;
}
