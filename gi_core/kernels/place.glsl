// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// The lower 32 bits of a surfel's place, which comes in two halves: floats hold no more than 24.

uint place_of(int i)
{
  vec2 halves = place(i);
  return uint(halves.x) + 65536u * uint(halves.y);
}
