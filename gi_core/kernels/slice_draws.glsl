// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// What one slice is drawn by; see slice_draws.py.

void kernel(int i)
{
  int k = i % SLICES;
  int index = int(place(i / SLICES));
  uint own = uint(more) + 4u * uint(k);
  set_u(i, vec3(rotated(points(k), index, uint(seed)).x, hash01(uint(index), own + 2u), hash01(uint(index), own + 3u)));
}
