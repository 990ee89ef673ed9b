// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// One texel of any level of the closest-depth pyramid, from the finest level itself; see depth_pyramid.py.

void kernel(int i)
{
  int level = 0;
  while (level + 1 < levels && float(i) >= table(level + 1).x) {
    level++;
  }
  int texel = i - int(table(level).x);
  int across = int(table(level).y);
  int x = (texel % across) << level;
  int y = (texel / across) << level;
  int right = min(x + (1 << level), width);
  int top = min(y + (1 << level), height);
  float least = 1e30;
  for (int row = y; row < top; row++) {
    for (int column = x; column < right; column++) {
      least = min(least, nearest(row * width + column));
    }
  }
  set_pyramid(i, least);
}
