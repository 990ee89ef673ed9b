// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Multiplications and additions that wait for no memory: 8 · 4 · 2 in each of 64 rounds.

void kernel(int i)
{
  vec4 a = values(i);
  vec4 b = a + 1.0;
  vec4 c = a + 2.0;
  vec4 d = a + 3.0;
  for (int k = 0; k < 64; k++) {
    a = a * 0.999 + 0.001;
    b = b * 0.999 + 0.002;
    c = c * 0.999 + 0.003;
    d = d * 0.999 + 0.004;
    a = a * 0.998 + b;
    b = b * 0.998 + c;
    c = c * 0.998 + d;
    d = d * 0.998 + a;
  }
  set_total(i, a + b + c + d);
}
