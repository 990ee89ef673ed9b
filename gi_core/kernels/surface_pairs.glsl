// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The weights of pairs of points; see surface_weight.py.

void kernel(int i)
{
  set_weight(i, surface_weight(depth(i), position(i), normal(i), tap_depth(i), tap_position(i), tap_normal(i), scale(i), literal));
}
