// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a point's samples in the disk count, over their weights; see `rsm.disk.Disk`.

void kernel(int i)
{
  vec4 state = state_of(i);
  float total = 0.0;
  for (int k = 0; k < taken; k++) {
    total += weight_of(state, k);
  }
  set_scale(i, texels_in_disk / max(total, 1e-20));
}
