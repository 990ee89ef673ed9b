// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Uniform numbers in [0, 1) of an index; see `sampling.hash01`. seed: what `vpl_gather.seeded` makes of it.

uint mixed(uint x)
{
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}

float hash01(uint index, int seed)
{
  return float(mixed(mixed(index + uint(seed))) >> 8u) * 5.9604644775390625e-08;
}
