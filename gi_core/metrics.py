# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""How far an image is from a reference.

Images are (h, w, 3) scene-linear; `mask` is (h, w) bool, the pixels that count, None meaning all. relMSE, RMSE, bias
and FLIP are taken of the light itself; PSNR and SSIM of the picture that people look at, sRGB at the exposure that
suits the reference.
"""

import numpy as np

from . import display
from . import flip as flip_error


def measure(test: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> dict[str, float]:
    """All measures: relmse, rmse, bias, psnr, ssim, flip.

    Raises ValueError for images of different shapes, non-finite values among the pixels that count, and an empty mask.
    """
    if test.shape != reference.shape or test.ndim != 3 or test.shape[2] != 3:
        raise ValueError(f"cannot compare images of shapes {test.shape} and {reference.shape}")
    mask = np.ones(test.shape[:2], bool) if mask is None else mask
    if not mask.any():
        raise ValueError("cannot compare images without a pixel that counts: the mask is empty")
    for what, image in (("test image", test), ("reference", reference)):
        if bad := np.count_nonzero(~np.isfinite(image[mask]).all(axis=-1)):
            raise ValueError(f"the {what} has {bad} pixels that are not finite numbers")
    # float64: sums over millions of pixels.
    x, r = test[mask].astype(np.float64), reference[mask].astype(np.float64)
    exposure = display.exposure_of(reference, mask)
    shown = [display.srgb(np.where(mask[..., None], i, 0) * np.float64(exposure)) for i in (test, reference)]
    return {
        "relmse": relmse(x, r),
        "rmse": float(np.sqrt(np.mean((x - r) ** 2))),
        "bias": bias(x, r),
        "psnr": psnr(shown[0][mask], shown[1][mask]),
        "ssim": ssim(shown[0] @ display.LUMINANCE, shown[1] @ display.LUMINANCE, mask),
        "flip": flip(test, reference, mask),
    }


def relmse(x: np.ndarray, r: np.ndarray, other: np.ndarray | None = None) -> float:
    """Relative mean square error, mean((x − r)² / (r² + 0.01)), over arrays of one shape.

    other: a second reference with noise of its own. The product of both differences has the noise of neither in its
    mean, and r² is that of their mean.
    """
    other = r if other is None else other
    return float(np.mean((x - r) * (x - other) / (((r + other) / 2) ** 2 + 0.01)))


def bias(x: np.ndarray, r: np.ndarray) -> float:
    """mean(x − r) / mean(r): +0.02 is 2 % too bright. Against black, 0 where x is black too and ±inf where not."""
    error, light = float(np.mean(x - r)), float(np.mean(r))
    if light == 0:
        return 0.0 if error == 0 else float(np.copysign(np.inf, error))
    return error / light


def psnr(x: np.ndarray, r: np.ndarray) -> float:
    """Peak signal-to-noise ratio [dB] of values in 0…1; inf for equal ones."""
    error = float(np.mean((x - r) ** 2))
    return float(-10 * np.log10(error)) if error > 0 else float("inf")


def ssim(x: np.ndarray, r: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Mean structural similarity (Wang et al. 2004): Gaussian window 11×11 of σ 1.5, K = 0.01 and 0.03.

    x, r: (h, w) in 0…1. As in the paper only windows that lie inside the image count. Where there is a mask, windows
    are centred on its pixels and see nothing else: their weights are normalised over the pixels in the mask. NaN where
    no window fits.
    """
    if min(x.shape) < 11:
        return float("nan")
    mask = np.ones(x.shape, bool) if mask is None else mask
    counted = mask[5:-5, 5:-5]
    weight = _window(mask.astype(np.float64))[counted]
    if weight.size == 0:
        return float("nan")
    mean_x, mean_r, xx, rr, xr = (_window(np.where(mask, i, 0))[counted] / weight for i in (x, r, x * x, r * r, x * r))
    c1, c2 = 0.01**2, 0.03**2
    structure = (2 * (xr - mean_x * mean_r) + c2) / (xx - mean_x**2 + rr - mean_r**2 + c2)
    return float(np.mean((2 * mean_x * mean_r + c1) / (mean_x**2 + mean_r**2 + c1) * structure))


def flip(test: np.ndarray, reference: np.ndarray, mask: np.ndarray | None = None) -> float:
    """Mean HDR-FLIP error, 0…1; NaN against black."""
    mask = np.ones(test.shape[:2], bool) if mask is None else mask
    return float(np.mean(flip_map(test, reference, mask)[mask]))


def flip_map(test: np.ndarray, reference: np.ndarray, mask: np.ndarray) -> np.ndarray:
    """HDR-FLIP error of each pixel, (h, w) in 0…1; NaN against black."""
    if not (reference[mask] > 0).any():
        return np.full(mask.shape, np.nan)
    # Equal pixels of a middling value outside the mask add no error and hardly move FLIP's choice of exposures.
    filler = np.median(reference[mask], axis=0)
    return flip_error.error_map(*(np.where(mask[..., None], i, filler) for i in (test, reference)))


def leak(test: np.ndarray, reference: np.ndarray, dark: np.ndarray, lit: np.ndarray) -> float:
    """Light where it should be dark over the reference's light elsewhere, by their means; NaN where there is neither.

    dark, lit: (h, w) bool.
    """
    light = float(np.mean(reference[lit])) if lit.any() else 0.0
    return float(np.mean(test[dark])) / light if light > 0 and dark.any() else float("nan")


def _window(image: np.ndarray) -> np.ndarray:
    """(h, w) to (h − 10, w − 10): the mean under the Gaussian window, separably."""
    kernel = np.exp(-(np.arange(-5, 6) ** 2) / (2 * 1.5**2))
    kernel /= kernel.sum()
    rows = np.lib.stride_tricks.sliding_window_view(image, 11, axis=0) @ kernel
    return np.lib.stride_tricks.sliding_window_view(rows, 11, axis=1) @ kernel
