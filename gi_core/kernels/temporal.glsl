// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One value with its history; see temporal.py.

void kernel(int i)
{
  vec4 tap = taps(i);
  vec4 weight = weights(i);
  float n = 0.0;
  value_t earlier = value_t(0.0);
  for (int k = 0; k < 4; k++) {
    n += weight[k] * history_count(int(tap[k]));
    earlier += weight[k] * history(int(tap[k]));
  }
  n = max(n - float(skipped), 0.0);
  float added = float(1 + skipped);
  float factor = n / (n + added);
  if (hdrp == 1) {
    factor = n >= 8.0 ? 0.93 : factor;
    n = min(n, 7.0);
  }
  set_mixed(i, value(i) * (1.0 - factor) + earlier * factor);
  set_count(i, n + added);
}
