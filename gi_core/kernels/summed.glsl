// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The sum of what belongs to one cell; see lpv_inject.py.

void kernel(int i)
{
  int cell = i / COLUMNS;
  int column = i % COLUMNS;
  int first = int(start(cell));
  int last = min(int(start(cell + 1)), first + end);
  values_t total = values_t(0.0);
  for (int k = first + begin; k < last; k++) {
    total += values(int(order(k)) * COLUMNS + column);
  }
  set_total(i, total);
}
