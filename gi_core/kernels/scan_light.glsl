// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The light of one pixel's slices; see scan_light.py.

void kernel(int i)
{
  light_t total = light_t(0.0);
  float none = 0.0;
  for (int k = 0; k < SLICES; k++) {
    float share = open_share(i * SLICES + k);
    total += arrived(i * SLICES + k);
#if REST
    total += share * rest(i * levels + level);
#endif
    none += share;
  }
  set_light(i, total / float(SLICES));
  set_missed(i, none / float(SLICES));
}
