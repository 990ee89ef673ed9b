// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Texels read one after the other, near each other as a filter's are, and nothing else.

void kernel(int i)
{
  vec4 total = vec4(0.0);
  for (int k = 0; k < 64; k++) {
    total += values((i + k * 37) & MASK);
  }
  set_total(i, total);
}
