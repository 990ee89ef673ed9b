// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What a march reads at one texel; see march_cells.py.

void kernel(int i)
{
  set_cells(i, i < size ? vec3(march_depth(i), march_slope(i)) : vec3(pyramid(i), 0.0, 0.0));
}
