# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""FLIP, the difference that an eye sees when two pictures alternate.

Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating Images", and 2021, "Visualizing Errors in Rendered
High Dynamic Range Images". Constants are the papers'; the picture is looked at from 0.7 m on a 0.7 m wide screen of
3840 pixels, which makes 67 pixels a degree.
"""

import numpy as np

PIXELS_PER_DEGREE = 0.7 * 3840 / 0.7 * np.pi / 180
_XYZ = (
    np.array([[10135552, 8788810, 4435075], [5226144, 17577620, 1774030], [1425312 / 3, 8788810 / 3, 70074185 / 3]])
    / 24577794
)
_WHITE = _XYZ.sum(axis=1)
# Contrast sensitivity of the eye in each opponent channel: weights and widths [1/cycles²] of two Gaussians.
_SENSITIVITY = (((1, 0.0047), (0, 1e-5)), ((1, 0.0053), (0, 1e-5)), ((34.1, 0.04), (13.5, 0.025)))
_FEATURE_WIDTH = 0.082  # of edges and points that are seen best [degrees]
_EXPONENT, _FEATURE_EXPONENT = 0.7, 0.5
_KNEE, _KNEE_VALUE = 0.4, 0.95
# The ACES curve after Narkowicz, x(ax + b) / (x(cx + d) + e), with the exposure of 0.6 inside.
_ACES = (0.6 * 0.6 * 2.51, 0.6 * 0.03, 0.6 * 0.6 * 2.43, 0.6 * 0.59, 0.14)


def error_map(test: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """HDR-FLIP of (h, w, 3) scene-linear images: (h, w) in 0…1, the largest error over exposures.

    The exposures are the reference's: from where its brightest pixel is nearly white to where its median is. Negative
    values count as 0. Raises ValueError for a reference without light.
    """
    test, reference = (np.maximum(i, 0).astype(np.float64) for i in (test, reference))
    worst = np.zeros(reference.shape[:2])
    for exposure in exposures(reference):
        shown = [_aces(i * 2.0**exposure) for i in (test, reference)]
        np.maximum(worst, ldr_error_map(*shown), out=worst)
    return worst


def exposures(reference: np.ndarray) -> np.ndarray:
    """Exposures in f-stops at which HDR-FLIP looks at the pictures: (n ≥ 2,) float."""
    luminance = np.maximum(reference, 0) @ _XYZ[1]
    if not luminance.any():
        raise ValueError("FLIP needs a reference with light")
    high = luminance.max()
    low = np.partition(luminance.ravel(), luminance.size // 2)[luminance.size // 2]
    # Where less than half the picture has light, the median says nothing; the least light stands in for it.
    low = low if low > 0 else luminance[luminance > 0].min()
    a, b, c, d, e = _ACES
    # Where the ACES curve is at 0.85.
    p, q = (b - 0.85 * d) / (a - 0.85 * c), -0.85 * e / (a - 0.85 * c)
    bright = -p / 2 + np.sqrt(p * p / 4 - q)
    start, stop = np.log2(bright / high), np.log2(bright / low)
    return np.linspace(start, stop, max(2, int(np.ceil(stop - start))))


def ldr_error_map(test: np.ndarray, reference: np.ndarray) -> np.ndarray:
    """LDR-FLIP of (h, w, 3) linear images in 0…1: (h, w) in 0…1."""
    opponent = [_opponent(i) for i in (test, reference)]
    lab = [_hunt(_lab(_seen(i))) for i in opponent]
    green, blue = (_hunt(_lab(np.array(c, np.float64))) for c in ((0, 1, 0), (0, 0, 1)))
    largest = _hyab(green, blue) ** _EXPONENT
    color, knee = _hyab(*lab) ** _EXPONENT, _KNEE * largest
    color = np.where(
        color < knee,
        _KNEE_VALUE / knee * color,
        _KNEE_VALUE + (color - knee) / (largest - knee) * (1 - _KNEE_VALUE),
    )
    edges, points = zip(*(_features((i[..., 0] + 16) / 116) for i in opponent))
    feature = np.maximum(np.abs(edges[0] - edges[1]), np.abs(points[0] - points[1]))
    return color ** (1 - (feature / np.sqrt(2)) ** _FEATURE_EXPONENT)


def _aces(x):
    a, b, c, d, e = _ACES
    return np.clip((x * (a * x + b)) / (x * (c * x + d) + e), 0, 1)


def _opponent(linear):
    """Linear RGB to the linearised CIELAB that the eye's filters work on, (…, 3): Y, red-green, blue-yellow."""
    x, y, z = np.moveaxis(linear @ _XYZ.T / _WHITE, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


def _seen(opponent):
    """What of a picture passes the eye's contrast sensitivity, as linear RGB in 0…1."""
    radius = int(np.ceil(3 * np.sqrt(0.04 / (2 * np.pi**2)) * PIXELS_PER_DEGREE))
    distance2 = (np.arange(-radius, radius + 1) / PIXELS_PER_DEGREE) ** 2
    filtered = np.empty_like(opponent)
    for channel, gaussians in enumerate(_SENSITIVITY):
        total, weight = 0.0, 0.0
        for share, width in gaussians:
            line = np.exp(-(np.pi**2) * distance2 / width)
            total = total + share * np.sqrt(np.pi / width) * _separable(opponent[..., channel], line, line)
            weight += share * np.sqrt(np.pi / width) * line.sum() ** 2
        filtered[..., channel] = total / weight
    y = (filtered[..., 0] + 16) / 116
    xyz = np.stack([y + filtered[..., 1] / 500, y, y - filtered[..., 2] / 200], -1) * _WHITE
    return np.clip(xyz @ np.linalg.inv(_XYZ).T, 0, 1)


def _lab(linear):
    ratio = linear @ _XYZ.T / _WHITE
    delta = 6 / 29
    f = np.where(ratio > delta**3, np.cbrt(ratio), ratio / (3 * delta**2) + 4 / 29)
    return np.stack([116 * f[..., 1] - 16, 500 * (f[..., 0] - f[..., 1]), 200 * (f[..., 1] - f[..., 2])], -1)


def _hunt(lab):
    """Colour counts less in the dark."""
    return np.concatenate([lab[..., :1], lab[..., 1:] * (0.01 * lab[..., :1])], -1)


def _hyab(one, other):
    difference = one - other
    return np.abs(difference[..., 0]) + np.hypot(difference[..., 1], difference[..., 2])


def _features(y):
    """How strong edges and points are, each (h, w)."""
    deviation = 0.5 * _FEATURE_WIDTH * PIXELS_PER_DEGREE
    radius = int(np.ceil(3 * deviation))
    x = np.arange(-radius, radius + 1)
    across = np.exp(-(x**2) / (2 * deviation**2))
    found = []
    for along in (-x * across, (x**2 / deviation**2 - 1) * across):
        # Positive and negative weights each have the sum 1.
        along = np.where(along > 0, along / along[along > 0].sum(), along / -along[along < 0].sum())
        found.append(np.hypot(_separable(y, along, across / across.sum()), _separable(y, across / across.sum(), along)))
    return found


def _separable(image, horizontal, vertical):
    """(h, w) filtered with borders repeated; the same shape."""
    radius = len(horizontal) // 2
    padded = np.pad(image, radius, mode="edge")
    rows = np.lib.stride_tricks.sliding_window_view(padded, len(vertical), axis=0) @ vertical[::-1]
    return np.lib.stride_tricks.sliding_window_view(rows, len(horizontal), axis=1) @ horizontal[::-1]
