// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Uniform numbers in [0, 1) of an index; see `sampling.hash01`.

uint permuted(uint x)
{
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}

float hash01(uint index, uint seed)
{
  return float(permuted(permuted(index + seed * 0x9E3779B9u)) >> 8u) * 5.9604644775390625e-08;
}
