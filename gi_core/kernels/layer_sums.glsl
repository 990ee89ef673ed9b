// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What one layer of cells holds; see lpv_propagate.py.

void kernel(int i)
{
  vec3 total = vec3(0.0);
  for (int k = 0; k < count; k++) {
    total += front(i * count + k);
  }
  set_held(i, total);
}
