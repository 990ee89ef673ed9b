// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Memory read and written, and nothing else.

void kernel(int i)
{
  set_copy(i, values(i));
}
