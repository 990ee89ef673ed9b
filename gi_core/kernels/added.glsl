// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sums of arrays; see added.py.

void kernel(int i)
{
  set_sum_(i, one(i) + other(i));
}
