// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One pixel's value out of a list; see spread.py.

void kernel(int i)
{
  int from = int(row(i));
  set_image_(i, from >= 0 ? values(from) : values_t(0.0));
}
