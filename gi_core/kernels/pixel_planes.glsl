// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One pixel's plane; see pixel_planes.py and Screen.slopes.

void kernel(int i)
{
  float z = depth(i);
  if (!(z < 1e30)) {
    set_ground(i, 1e30);
    set_slope(i, vec2(0.0));
    set_nearest(i, 1e30);
    return;
  }
  // Rows of axes: to the right, up, ahead; and the eye.
  vec3 right = axes(0);
  vec3 above = axes(1);
  vec3 ahead = axes(2);
  vec3 from = position(i) - axes(3);
  vec3 facing = face(i);
  vec3 local = vec3(dot(from, right), dot(from, above), dot(from, ahead));
  vec3 n = vec3(dot(facing, right), dot(facing, above), dot(facing, ahead));
  float over = parallel == 1 ? n.z : dot(n, local);
  // Seen from its edge a plane is as steep as can be.
  vec2 slope = over == 0.0 ? -1e20 * sign(n.xy) : -n.xy / over / vec2(unit_x, unit_y);
  float most = 0.5 * abs(parallel == 1 ? local.z : -1.0 / local.z);
  slope *= min(1.0, most / max(abs(slope.x) + abs(slope.y), 1e-30));
  float ground = parallel == 1 ? z : -1.0 / z;
  set_ground(i, ground);
  set_slope(i, slope);
  set_nearest(i, ground - (abs(slope.x) + abs(slope.y)) / 2.0 - 1.9073486328125e-6 * abs(ground));
}
