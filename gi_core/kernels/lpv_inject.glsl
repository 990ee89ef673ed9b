// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What one virtual light puts into its cell; see lpv_inject.py.

void kernel(int i)
{
  vec3 n = normal(i);
  vec3 light = flux(i);
  vec3 about = n;
  vec4 scale = vec4(0.28209479177387814, vec3(0.48860251190291992));
#if TOWARDS
  about = towards(i);
  float reach = sqrt(dot(about, about));
  about = reach > 0.0 ? about / reach : vec3(0.0);
  scale *= reach > 0.0 ? max(dot(n, about), 0.0) : 0.0;
#else
  // The clamped cosine's bands, over π.
  scale *= vec4(1.0, vec3(0.6666666666666667));
#endif
  set_intensity(i * 4, scale.x * light);
  set_intensity(i * 4 + 1, -scale.y * about.y * light);
  set_intensity(i * 4 + 2, scale.z * about.z * light);
  set_intensity(i * 4 + 3, -scale.w * about.x * light);
}
