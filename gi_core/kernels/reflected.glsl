// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What one pixel's surface sends; see reflected.py.

void kernel(int i)
{
  set_picture(i, base(i) + albedo(i) * light(i));
}
