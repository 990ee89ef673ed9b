// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Whether a ray meets anything; see rays.py.

void kernel(int i)
{
  set_blocked(i, traced(origin(i), direction(i), far(i)).x < 0.0 ? 0.0 : 1.0);
}
