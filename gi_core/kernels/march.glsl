// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One ray through the depth of an image; see depth_march.py. Integers width, height, steps, top, sure; floats near_,
// back; cells: of march_cells.glsl, so that each step reads once.

float past_edge(float position, float reciprocal)
{
  return position + (reciprocal > 0.0 ? 0.000244140625 : -0.000244140625);
}

float off_axis(float x)
{
  return abs(x) < 1e-20 ? 1e-20 : x;
}

// The pixel hit, −1 for none; and 1 where some of the way lay behind what the image shows.
ivec2 marched(vec3 o, vec3 direction)
{
  vec3 d = vec3(off_axis(direction.x), off_axis(direction.y), off_axis(direction.z));
  float rx = 1.0 / d.x;
  float ry = 1.0 / d.y;
  float rz = 1.0 / d.z;
  float t = min(abs(0.5 * rx), abs(0.5 * ry));
  float end = min(
      ((rx > 0.0 ? float(width) - 0.5 : 0.5) - o.x) * rx,
      ((ry > 0.0 ? float(height) - 0.5 : 0.5) - o.y) * ry);
  end = min(end, rz > 0.0 ? (o.z < 0.0 ? -o.z * rz : 1e30) : (near_ - o.z) * rz);
  int mip = 0;
  // Where the level lies among all.
  int offset = 0;
  bool below = false;
  int hidden = 0;
  for (int k = 0; k < steps; k++) {
    if (!(t <= end)) {
      break;
    }
    float x = o.x + t * d.x;
    float y = o.y + t * d.y;
    int column = int(past_edge(x, rx)) >> mip;
    int row = int(past_edge(y, ry)) >> mip;
    float wall = min(
        (float((column + (rx > 0.0 ? 1 : 0)) << mip) - o.x) * rx,
        (float((row + (ry > 0.0 ? 1 : 0)) << mip) - o.y) * ry);
    bool fine = mip == 0;
    int across = (width + (1 << mip) - 1) >> mip;
    vec3 cell = cells(offset + row * across + column);
    vec2 tilt = cell.yz;
    float ground = cell.x + tilt.x * (x - float(column) - 0.5) + tilt.y * (y - float(row) - 0.5);
    float z = o.z + t * d.z;
    float gap = z - ground;
    float closing = d.z - tilt.x * d.x - tilt.y * d.y;
    bool under = gap > 0.0;
    float crossing = closing == 0.0 ? -1.0 : t - gap / closing;
    bool crosses = crossing >= t && crossing <= wall;
    bool enters = crosses && !under && closing > 0.0;
    bool inside = under && z <= ground * back;
    bool ends = fine && ((inside && below) || (under && !inside && crosses) || (under && sure == 1));
    if (fine && under) {
      hidden = 1;
    }
    if (ends) {
      break;
    }
    if (fine && (enters || inside)) {
      return ivec2(row * width + column, hidden);
    }
    t = enters ? crossing : (fine || !under ? wall : t);
    if (enters || under) {
      if (mip > 0) {
        mip--;
        offset -= ((width + (1 << mip) - 1) >> mip) * ((height + (1 << mip) - 1) >> mip);
      }
    }
    else if (mip < top) {
      offset += across * ((height + (1 << mip) - 1) >> mip);
      mip++;
    }
    below = fine && under;
  }
  return ivec2(-1, hidden);
}
