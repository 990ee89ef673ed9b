// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The diffuse filter at one pixel; see diffuse_filter.py.

void kernel(int i)
{
  int pixel = int(pixels(i));
  float z = depth(pixel);
  if (!(z < 1e30)) {
    set_result(i, value_t(0.0));
    return;
  }
  vec3 here = position(pixel);
  vec3 up = normal(pixel);
  vec3 tangent = tangent_of(up);
  vec3 bitangent = bitangent_of(up);
  float reach = radius(i);
  float metre = scale(i);
  vec4 row_x = matrix(0);
  vec4 row_y = matrix(1);
  vec4 row_z = matrix(2);
  vec4 row_w = matrix(3);
  vec2 turn = turned == 1 ? sine_cosine(6.283185307179586 * hash01(uint(pixel), uint(seed))) : vec2(0.0, 1.0);
  value_t total = value(pixel);
  float counted = 1.0;
  for (int k = 0; k < count; k++) {
    vec3 drawn = taps(SHARED == 1 ? k : i * count + k);
    vec2 tap = vec2(turn.y * drawn.x - turn.x * drawn.y, turn.x * drawn.x + turn.y * drawn.y);
    vec4 point = vec4(here + (reach * tap.x) * tangent + (reach * tap.y) * bitangent, 1.0);
    float ahead = dot(row_z, point);
    if (!(ahead > 0.0)) {
      continue;
    }
    float over = dot(row_w, point);
    float x = dot(row_x, point) / over;
    float y = dot(row_y, point) / over;
    if (!(x > -0.5 && x < float(width) - 0.5 && y > -0.5 && y < float(height) - 0.5)) {
      continue;
    }
    int there = clamp(int(roundEven(y)), 0, height - 1) * width + clamp(int(roundEven(x)), 0, width - 1);
    float beyond = depth(there);
    if (!(beyond < 1e30 && abs(beyond - ahead) <= reach * 0.16666667)) {
      continue;
    }
    float weight = drawn.z * surface_weight(
        z / far_, here, up, beyond / far_, position(there), normal(there), metre, literal);
    total += weight * value(there);
    counted += weight;
  }
  set_result(i, total / counted);
}
