// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The share of light that comes through; see rays.py.

void kernel(int i)
{
  set_share(i, through(origin(i), direction(i), far(i)));
}
