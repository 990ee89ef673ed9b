// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later

// One point in a shadow map; see shadow_map.py.
void kernel(int i)
{
  float before = lit(i);
  vec3 forward = frame(3);
  vec3 normal = face(i);
  vec3 away = position(i) - frame(4);
  float depth = dot(away, frame(2));
  vec3 direction = parallel == 1 ? forward : away / max(length(away), 1e-20);
  float cosine = dot(normal, direction);
  float slant = sqrt(max(1.0 - cosine * cosine, 0.0));
  float width = texel * (parallel == 1 ? 1.0 : max(depth, 0.0));
  away -= normal * (sign(cosine) * 1.41421356 * width * slant);
  vec3 local = vec3(dot(away, frame(0)), dot(away, frame(1)), dot(away, frame(2)));
  float far_ = parallel == 1 ? local.z : length(away);
  vec2 plane = parallel == 1 ? local.xy : local.xy / (local.z == 0.0 ? 1e-30 : local.z);
  vec2 st = (plane - vec2(left, bottom)) / vec2(right - left, top - bottom);
  float off = max(abs(st.x - 0.5), abs(st.y - 0.5));
  float result = before;
  if (before < 0.0 && local.z > 0.0 && off <= 0.5 + margin) {
    vec2 at = st * vec2(float(columns), float(rows)) - 0.5;
    vec2 corner = floor(at);
    vec2 part = at - corner;
    result = 0.0;
    for (int tap = 0; tap < 4; tap++) {
      ivec2 shift = ivec2(tap / 2, tap - 2 * (tap / 2));
      ivec2 pixel = clamp(ivec2(corner) + shift, ivec2(0), ivec2(columns - 1, rows - 1));
      vec2 weight = abs(vec2(1.0) - vec2(shift) - part);
      float blocker = distance_of(pixel.y * columns + pixel.x);
      result += far_ <= blocker * 1.0001 ? weight.x * weight.y : 0.0;
    }
  }
  set_share(i, result);
}
