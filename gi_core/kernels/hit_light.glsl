// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The light that one pixel's rays bring; see hit_light.py.

void kernel(int i)
{
  light_t total = light_t(0.0);
#if REST
  total = rest(i * levels + level);
#endif
  float none = 0.0;
  for (int k = 0; k < RAYS; k++) {
    int from = int(hit(i * RAYS + k));
    if (from >= 0) {
      total += picture(from) / float(RAYS);
    }
    none += from == -1 ? 1.0 : 0.0;
  }
  set_light(i, total);
  set_missed(i, none / float(RAYS));
}
