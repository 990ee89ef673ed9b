// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One ray from a pixel to what the screen shows; see screen_trace.py.

void kernel(int i)
{
  int pixel = int(pixels(i / RAYS));
  vec3 here = position(pixel);
  vec3 up = normal(pixel);
  vec3 way = cosine_hemisphere(up, rotated(points(i % RAYS), int(place(i / RAYS)), uint(seed)));
  bool leaves = dot(way, face(pixel)) > 0.0;
  vec3 slanted = up;
#if BUMPY
  slanted = mesh_normal(pixel);
  float drawn = hash01(uint(place(i / RAYS)) + uint(points(i % RAYS).x * 16777216.0), ~uint(seed));
  leaves = leaves && drawn < bump_shadowing(slanted, up, way);
#endif
  if (!leaves) {
    set_hit(i, -2.0);
    return;
  }
  // Rows of axes: to the right, up, ahead; and the eye.
  vec3 right = axes(0);
  vec3 above = axes(1);
  vec3 ahead = axes(2);
  vec3 from = here - axes(3);
  vec3 view = parallel == 1 ? -ahead : -from / sqrt(dot(from, from));
  float z = depth(pixel) * (1.0 - 1e-3 / max(dot(slanted, view), 1e-2));
  vec3 origin = vec3(float(pixel % width) + 0.5, float(pixel / width) + 0.5, parallel == 1 ? z : -1.0 / z);
  vec3 local = vec3(dot(from, right), dot(from, above), dot(from, ahead));
  vec3 d = vec3(dot(way, right), dot(way, above), dot(way, ahead));
  vec2 flat_ = (parallel == 1 ? d.xy : d.xy * local.z - local.xy * d.z) * vec2(unit_x, unit_y);
  ivec2 found = marched(origin, vec3(flat_, d.z));
  bool kept = found.x >= 0;
  if (kept) {
    vec3 facing = face(found.x);
    // A surface turned away shows the eye another side than the one that the ray meets.
    kept = dot(facing, way) < 0.0;
#if CERTAIN
    vec3 at = position(found.x);
    vec3 past = at - here;
    float along = dot(past, way);
    past -= along * way;
    vec3 back_ = at - axes(3);
    float slant = abs(dot(facing, parallel == 1 ? ahead : back_ / sqrt(dot(back_, back_))));
    float size = parallel == 1 ? footprint : depth(found.x) * footprint;
    kept = kept && found.y == 0 && sqrt(dot(past, past)) * slant <= size && along * slant >= 4.0 * size;
#endif
#if VALID
    kept = kept && valid(found.x) > 0.0;
#endif
  }
  set_hit(i, kept ? float(found.x) : -1.0);
}
