// SPDX-FileCopyrightText: 2026 GI Bake authors
// SPDX-License-Identifier: GPL-3.0-or-later
//
// Sines, cosines and angles to a unit or two in the last place (after Cephes, single precision): what GLSL has may be
// off by as much as each driver likes.

// x in −π/4 … π/4.
float small_sine(float x)
{
  float z = x * x;
  return ((-1.9515295891e-4 * z + 8.3321608736e-3) * z - 1.6666654611e-1) * z * x + x;
}

float small_cosine(float x)
{
  float z = x * x;
  return ((2.443315711809948e-5 * z - 1.388731625493765e-3) * z + 4.166664568298827e-2) * z * z - 0.5 * z + 1.0;
}

// The sine and the cosine of x, no more than some turns from 0.
vec2 sine_cosine(float x)
{
  float quarters = floor(x * 0.6366197723675814 + 0.5);
  float rest = ((x - quarters * 1.5703125) - quarters * 4.837512969970703e-4) - quarters * 7.549789954891882e-8;
  vec2 both = vec2(small_sine(rest), small_cosine(rest));
  int turn = int(quarters) & 3;
  both = (turn & 1) == 1 ? both.yx : both;
  return vec2(turn >= 2 ? -both.x : both.x, turn == 1 || turn == 2 ? -both.y : both.y);
}

// The angle of the point x, y.
float angle_of(float y, float x)
{
  float longer = max(abs(x), abs(y));
  float t = longer > 0.0 ? min(abs(x), abs(y)) / longer : 0.0;
  float base = 0.0;
  if (t > 0.4142135623730950) {
    base = 0.7853981633974483;
    t = (t - 1.0) / (t + 1.0);
  }
  float z = t * t;
  float angle = base + ((((8.05374449538e-2 * z - 1.38776856032e-1) * z + 1.99777106478e-1) * z - 3.33329491539e-1) * z * t + t);
  angle = abs(y) > abs(x) ? 1.5707963267948966 - angle : angle;
  angle = x < 0.0 ? 3.141592653589793 - angle : angle;
  return y < 0.0 ? -angle : angle;
}
