# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""The horizon scan with a visibility bitmask (Therrien, Levesque & Gilet, "Screen Space Indirect Lighting with
Visibility Bitmask", 2023).

A slice is a plane through the view ray; in it angles θ are measured from the view ray, and the projected normal lies at
γ. A step on the screen shows a stretch of surface, from half way back to the last step to half way on to the next. It
covers the angles from its beginning to its end and on to its back, `thickness` further from the eye, and lights through
those sectors of 32 that nothing before it covers.

    E/π = mean over slices of |n_p| ∫ L cos(θ − γ) |sin θ| dθ,   θ from γ − π/2 to γ + π/2

The published form spreads the sectors evenly over the angles, counts each alike and multiplies by the sender's cosine
too. Here a sector is a 32nd of the integral above, by its closed form: then counting bits is exact. Bits are rounded at
random, so that 32 of them leave noise and no bias. And there a step shows a point: walls far off, whose points lie
behind one another in no one's eye, are full of holes.
"""

import numpy as np

from ..sampling import frame
from ..vectors import dot, normalize

SECTORS = 32
_ONE = np.uint64(1)
_RIGHT = np.float32(np.pi / 2)

# How quickly steps grow with the distance.
_POWER = 2.5

# A stretch of surface reaches no nearer and no further than this times its depth.
_STRETCH = np.float32(1.5)


def horizon_scan(
    pixels, position, normal, color, u, pixel, parallel: bool, thickness: float, steps: int, span: float, shown=None
):
    """Light that pixels get from what the image shows, over one slice each.

    pixels: (n,) int32, which ones, of each as many slices as u has rows for it. position, normal: (h, w, 3) float32 in
        camera space, x to the right, y up, z ahead; a normal of zero where no surface is. color: (h, w, c) float32
        radiance. u: (m, 3) float32 in [0, 1): the slice's turn, the first step, the rounding. pixel: pixels in a unit
        along x and along y, on the plane z = 1 in perspective. parallel: the projection. thickness: of what is seen, as
        a share of its distance. steps: on either side. span: the longest way [pixels]. shown: (h, w, 3), the normals of
    the surfaces that the image shows, where those that light arrives by are others.
    Returns (m, c) float32, mean radiance E/π, and (m,) float32, the share of it from where the image shows nothing.
    """
    h, w, c = color.shape
    pixels = np.repeat(pixels, len(u) // max(1, len(pixels)))
    position, normal, color = position.reshape(-1, 3), normal.reshape(-1, 3), color.reshape(-1, c)
    away = np.broadcast_to(np.array([0, 0, 1], np.float32), position.shape) * position[:, 2:] if parallel else position
    here, up = position[pixels], normal[pixels]
    facings = normal if shown is None else shown.reshape(-1, 3)
    view = -normalize(away[pixels])
    b1, b2 = frame(view)
    turn = (np.float32(np.pi) * u[:, 0])[:, None]
    along = np.cos(turn) * b1 + np.sin(turn) * b2
    a, b = dot(up, view), dot(up, along)
    gamma, projected = np.arctan2(b, a), np.hypot(a, b)
    low, high = (_integral(gamma + s * _RIGHT, gamma) for s in (-1, 1))
    whole = high - low

    # How the image of a point moves that moves along.
    way = along[:, :2] if parallel else along[:, :2] * here[:, 2:] - here[:, :2] * along[:, 2:]
    unit = np.asarray(pixel, np.float32)
    way = way * unit
    way = way / np.maximum(np.hypot(way[:, :1], way[:, 1:]), np.float32(1e-20))
    row, column = np.divmod(pixels, w)
    covered = np.zeros(len(pixels), np.uint64)
    lit, arrived = np.zeros(len(pixels), np.float32), np.zeros((len(pixels), c), np.float32)

    def reach(k: int) -> np.ndarray:
        """Pixels to the k-th step; at least one more each time."""
        return 1 + k + span * (np.maximum(k + u[:, 1], 0) / steps) ** _POWER

    def angle(d: np.ndarray) -> np.ndarray:
        return np.arctan2(dot(d, along), dot(d, view))

    def sector(theta: np.ndarray) -> np.ndarray:
        return (_integral(np.clip(theta, gamma - _RIGHT, gamma + _RIGHT), gamma) - low) / whole

    def bits_of(edges: list[np.ndarray]) -> np.ndarray:
        edges = np.clip(edges, 0, 1) * SECTORS + u[:, 2]
        low_bit, high_bit = (np.floor(f(edges, 0)).astype(np.uint64) for f in (np.min, np.max))
        return ((_ONE << high_bit) - _ONE) & ~((_ONE << low_bit) - _ONE)

    if shown is not None:  # what lies below the surface is neither seen nor open
        horizon = angle(facings[pixels])
        covered |= ~bits_of([sector(horizon + s * _RIGHT) for s in (-1, 1)]) & np.uint64(0xFFFFFFFF)
        lit += _count(covered)

    for k in range(steps):
        last, r, following = reach(k - 1), reach(k), reach(k + 1)
        begin, end = (last - r) / 2 if k else np.float32(0.5) - r, (following - r) / 2
        for side in (1, -1):
            x, y = (np.round(a + side * r * way[:, i]) for i, a in enumerate((column, row)))
            inside = (x >= 0) & (x < w) & (y >= 0) & (y < h)
            tap = (np.where(inside, y, 0) * w + np.where(inside, x, 0)).astype(np.int32)
            at, facing = position[tap], facings[tap]
            # From the pixel's centre to the stretch's ends.
            off = np.stack([column - x, row - y], -1)
            first, final = (
                _on_plane(at, facing, (off + (side * (r + e))[:, None] * way) / unit, parallel) for e in (begin, end)
            )
            back = final + np.float32(thickness) * (final * (0, 0, 1) if parallel else final)
            bits = bits_of([sector(angle(e - here)) for e in (first, final, back)])
            bits = np.where(inside & facing.any(-1), bits, np.uint64(0))
            # A surface turned away shows the eye another side than the one that this point sees.
            share = _count(bits & ~covered) * (dot(facing, at - here) < 0)
            covered |= bits
            arrived += share[:, None] * color[tap]
            lit += share
    scale = projected * whole / SECTORS * up.any(-1)
    return arrived * scale[:, None], ((SECTORS - lit) * scale).astype(np.float32)


def horizon_scan_on_gpu(
    gpu, pixels, position, normal, color, u, pixel, parallel: bool, thickness: float, steps: int, span: float,
    shown=None,
):  # fmt: skip
    (h, w, c), n = color.shape, len(u)
    arrived, open_share = gpu.empty((n, c), c), gpu.empty((n,), 1)
    inputs = {"pixels": (pixels, 1), "position": (position, 3), "normal": (normal, 3), "color": (color, c), "u": (u, 3)}
    inputs |= {} if shown is None else {"shown": (shown, 3)}
    gpu.dispatch(
        "horizon_scan", n, inputs, {"arrived": arrived, "open_share": open_share},
        integers={"width": w, "height": h, "parallel": parallel, "steps": steps},
        floats={"unit_x": pixel[0], "unit_y": pixel[1], "thickness": thickness, "span": span},
        defines={"SLICES": n // max(1, len(pixels)), "SHOWN": int(shown is not None)},
        with_sources=("angles", "hash01", "sampling"), steps=8 * steps,
    )  # fmt: skip
    return arrived, open_share


def _on_plane(at, normal, shift, parallel: bool):
    """Where the plane through points (n, 3) is, seen so far from them, shift (n, 2) on the plane z = 1: (n, 3)."""
    z = at[:, 2]
    with np.errstate(divide="ignore", invalid="ignore"):
        if parallel:
            z = z - dot(normal[:, :2], shift) / normal[:, 2]
        else:
            ray = at + z[:, None] * np.concatenate([shift, np.zeros_like(shift[:, :1])], -1)
            z = z * dot(normal, at) / dot(normal, ray)
    z = np.clip(np.where(np.isfinite(z) & (z > 0), z, np.inf), at[:, 2] / _STRETCH, at[:, 2] * _STRETCH)
    flat = at[:, :2] + shift if parallel else (at[:, :2] / np.maximum(at[:, 2:], 1e-20) + shift) * z[:, None]
    return np.concatenate([flat, z[:, None]], -1)


def _integral(theta, gamma):
    """∫ cos(t − γ) |sin t| dt from 0 to θ, for θ in [−3π/2, 3π/2]."""
    theta = np.clip(theta, -np.pi, np.pi)
    whole = (2 * theta * np.sin(gamma) - np.cos(2 * theta - gamma) + np.cos(gamma)) / 4
    return np.where(theta < 0, -whole, whole)


def _count(bits):
    """How many bits are set in each of (n,) uint64: (n,) float32. numpy has it from 2.0 on only."""
    bits = bits - ((bits >> np.uint64(1)) & np.uint64(0x55555555))
    bits = (bits & np.uint64(0x33333333)) + ((bits >> np.uint64(2)) & np.uint64(0x33333333))
    bits = (bits + (bits >> np.uint64(4))) & np.uint64(0x0F0F0F0F)
    return (((bits * np.uint64(0x01010101)) >> np.uint64(24)) & np.uint64(0xFF)).astype(np.float32)
