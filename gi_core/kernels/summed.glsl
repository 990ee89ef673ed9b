// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The sum of what belongs to one cell; see lpv_inject.py.

void kernel(int i)
{
  int cell = i / COLUMNS;
  int column = i % COLUMNS;
  int last = int(start(cell + 1));
  values_t total = values_t(0.0);
  for (int k = int(start(cell)); k < last; k++) {
    total += values(int(order(k)) * COLUMNS + column);
  }
  set_total(i, total);
}
