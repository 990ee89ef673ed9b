// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// How solid a triangle is at a point; see veil.py.

int wrapped(int i, int n, int extension)
{
  int period = extension == 1 ? 2 * n : n;
  int around = i - period * int(floor(float(i) / float(period)));
  // What is divided may be rounded up to the period.
  around = around < 0 ? around + period : (around >= period ? around - period : around);
  around = extension == 1 ? min(around, 2 * n - 1 - around) : around;
  return extension > 1 ? clamp(i, 0, n - 1) : around;
}

float texel_at(int x, int y, ivec2 size, int begin, int extension)
{
  return veil_texel(begin + wrapped(y, size.y, extension) * size.x + wrapped(x, size.x, extension));
}

// Of a triangle in the hierarchy at the weights of its second and third corner.
float solid(int k, vec2 weight)
{
  vec4 second = veil_second(k);
  int which_alpha = int(second.z);
  float share = 1.0;
  if (which_alpha >= 0) {
    vec4 texture_ = veil_alpha(2 * which_alpha);
    share = texture_.x;
    if (texture_.y >= 0.0) {
      vec4 kind = veil_alpha(2 * which_alpha + 1);
      vec4 first = veil_first(k);
      vec2 uv = first.xy * (1.0 - weight.x - weight.y) + first.zw * weight.x + second.xy * weight.y;
      ivec2 size = ivec2(texture_.zw);
      int begin = int(texture_.y) * 2048;
      int extension = int(kind.x);
      vec2 at = uv * texture_.zw;
      float color = 0.0;
      if (kind.y > 0.0) {
        color = texel_at(int(floor(at.x)), int(floor(at.y)), size, begin, extension);
      }
      else {
        vec2 low = floor(at - 0.5);
        vec2 part = at - 0.5 - low;
        int x = int(low.x);
        int y = int(low.y);
        float below = mix(texel_at(x, y, size, begin, extension), texel_at(x + 1, y, size, begin, extension), part.x);
        float above =
            mix(texel_at(x, y + 1, size, begin, extension), texel_at(x + 1, y + 1, size, begin, extension), part.x);
        color = mix(below, above, part.y);
        if (kind.z > 0.0) {
          color /= 255.0;
          color = color <= 0.04045 ? color / 12.92 : pow((color + 0.055) / 1.055, 2.4);
        }
      }
      bool is_beyond = extension == 3 && (min(uv.x, uv.y) < 0.0 || max(uv.x, uv.y) > 1.0);
      share *= is_beyond ? 0.0 : color;
    }
  }
  return clamp(share, 0.0, 1.0);
}
