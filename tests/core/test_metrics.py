# SPDX-FileCopyrightText: 2026 GI Bake authors
# SPDX-License-Identifier: GPL-3.0-or-later
"""Each measure against a closed form or a second, independent way to work it out."""

import math

import numpy as np
import pytest
from gi_bake.gi_core import display, flip, metrics

rng = np.random.default_rng(0)
REFERENCE = rng.random((24, 20, 3)).astype(np.float32)
NOISY = np.maximum(REFERENCE + 0.1 * rng.normal(size=REFERENCE.shape), 0).astype(np.float32)


def gray(value, size=16):
    return np.full((size, size, 3), value, np.float32)


def test_constant_images():
    """x = 0.6 against r = 0.5: every number can be worked out by hand."""
    m = metrics.measure(gray(0.6), gray(0.5))
    assert m["relmse"] == pytest.approx(0.1**2 / (0.5**2 + 0.01), rel=1e-5)
    assert m["rmse"] == pytest.approx(0.1, rel=1e-5)
    assert m["bias"] == pytest.approx(0.2, rel=1e-5)
    # The exposure takes the reference to white, where the brighter image is clipped too.
    assert m["psnr"] == math.inf
    m = metrics.measure(gray(0.25), gray(0.5))
    shown = 1.055 * 0.5 ** (1 / 2.4) - 0.055
    assert m["psnr"] == pytest.approx(20 * math.log10(1 / (1 - shown)), rel=1e-5)
    # Without structure what is left of SSIM is its term of means.
    assert m["ssim"] == pytest.approx((2 * shown + 1e-4) / (1 + shown**2 + 1e-4), rel=1e-4)
    assert m["bias"] == pytest.approx(-0.5)


def test_equal_images():
    m = metrics.measure(REFERENCE, REFERENCE.copy())
    assert (m["relmse"], m["rmse"], m["bias"], m["psnr"]) == (0, 0, 0, math.inf)
    assert m["ssim"] == pytest.approx(1, abs=1e-9)
    assert m["flip"] == 0


def test_relmse_weighs_dark_and_bright_errors_by_their_reference():
    r = np.array([0.0, 1.0, 10.0])
    assert metrics.relmse(r + 0.1, r) == pytest.approx((0.01 / 0.01 + 0.01 / 1.01 + 0.01 / 100.01) / 3)


def test_two_references_leave_no_noise_of_theirs_in_relmse():
    random = np.random.default_rng(2)
    x, truth = np.full(200_000, 0.01), np.zeros(200_000)
    a, b = (truth + random.normal(0, 0.01, truth.shape) for _ in (0, 1))
    assert metrics.relmse(x, a) > 1.8 * metrics.relmse(x, truth)
    assert metrics.relmse(x, a, b) == pytest.approx(metrics.relmse(x, truth), rel=0.03)


def test_bias_against_black():
    assert metrics.bias(np.zeros(3), np.zeros(3)) == 0
    assert metrics.bias(np.ones(3), np.zeros(3)) == math.inf


def ssim_by_definition(x, r, mask):
    """Wang et al. 2004, equations 13 to 16, window by window, weights normalised over the mask."""
    offset = np.arange(-5, 6)
    weights = np.exp(-(offset[:, None] ** 2 + offset[None] ** 2) / (2 * 1.5**2))
    found = []
    for row in range(5, x.shape[0] - 5):
        for column in range(5, x.shape[1] - 5):
            if not mask[row, column]:
                continue
            window = (slice(row - 5, row + 6), slice(column - 5, column + 6))
            w = weights * mask[window]
            w = w / w.sum()
            a, b = x[window], r[window]
            ma, mb = (w * a).sum(), (w * b).sum()
            va, vb, cov = (w * (a - ma) ** 2).sum(), (w * (b - mb) ** 2).sum(), (w * (a - ma) * (b - mb)).sum()
            means = (2 * ma * mb + 0.01**2) / (ma**2 + mb**2 + 0.01**2)
            structure = (2 * cov + 0.03**2) / (va + vb + 0.03**2)
            found.append(means * structure)
    return np.mean(found)


@pytest.mark.parametrize("masked", [False, True])
def test_ssim_is_its_definition(masked):
    x, r = rng.random((2, 19, 23))
    mask = rng.random(x.shape) < 0.6 if masked else np.ones(x.shape, bool)
    assert metrics.ssim(x, r, mask if masked else None) == pytest.approx(ssim_by_definition(x, r, mask), rel=1e-9)


def test_ssim_of_an_image_smaller_than_a_window():
    assert math.isnan(metrics.ssim(np.zeros((8, 32)), np.zeros((8, 32))))


@pytest.mark.parametrize("masked", [False, True])
def test_ssim_is_what_scikit_image_gives(masked):
    similarity = pytest.importorskip("skimage.metrics").structural_similarity
    x, r = rng.random((2, 31, 40))
    settings = {"gaussian_weights": True, "sigma": 1.5, "use_sample_covariance": False, "data_range": 1}
    assert metrics.ssim(x, r) == pytest.approx(similarity(x, r, **settings), rel=1e-9)


def test_psnr_and_rmse_are_what_scikit_image_gives():
    theirs = pytest.importorskip("skimage.metrics")
    x, r = rng.random((2, 31, 40, 3))
    assert metrics.psnr(x, r) == pytest.approx(theirs.peak_signal_noise_ratio(r, x, data_range=1), rel=1e-9)
    error = np.sqrt(theirs.mean_squared_error(r, x))
    assert metrics.measure(x, r)["rmse"] == pytest.approx(error, rel=1e-9)


@pytest.mark.parametrize("scale", [0.01, 1, 300])
def test_flip_is_what_its_authors_give(scale):
    """Pixel by pixel, at the exposures that they choose, of smooth light with noise and of bright points."""
    flip_evaluator = pytest.importorskip("flip_evaluator")
    across, up = np.meshgrid(np.linspace(0, 1, 61), np.linspace(0, 1, 47))
    reference = np.dstack([across, up, 0.3 + 0 * up]) ** 3
    reference[20, 30] = 9
    test = np.maximum(reference * 1.1 + 0.05 * rng.normal(size=reference.shape), 0)
    test[30:40, 10:20, 0] += 0.3
    reference, test = (scale * reference).astype(np.float32), (scale * test).astype(np.float32)
    theirs, mean, about = flip_evaluator.evaluate(reference, test, "HDR", applyMagma=False)
    exposures = flip.exposures(reference)
    assert len(exposures) == about["numExposures"] > 2
    assert exposures[[0, -1]] == pytest.approx([about["startExposure"], about["stopExposure"]], abs=1e-3)
    assert flip.error_map(test, reference) == pytest.approx(np.squeeze(theirs), abs=5e-4)
    assert metrics.measure(test, reference)["flip"] == pytest.approx(mean, rel=1e-3)


def test_flip_of_white_on_black_is_nearly_the_largest_there_is():
    """0.95 is where the paper's curve ends that most colour differences fall under; black to white is beyond it."""
    found = flip.ldr_error_map(gray(1, 40), gray(0, 40))
    assert 0.95 < found.mean() <= 1 and found.std() < 1e-9
    assert flip.ldr_error_map(gray(0.3), gray(0.3)).max() == 0


def test_flip_survives_a_black_reference():
    """flip_evaluator itself ends the process there."""
    assert math.isnan(metrics.measure(gray(0.5), gray(0))["flip"])
    with pytest.raises(ValueError, match="light"):
        flip.error_map(gray(0.5), gray(0))


def test_leak_is_light_in_the_dark_over_light_elsewhere():
    reference = np.zeros((8, 8, 3))
    reference[:, :4] = 2
    dark = reference[..., 0] == 0
    assert metrics.leak(reference, reference, dark, ~dark) == 0
    assert metrics.leak(reference * 3 + 0.5, reference, dark, ~dark) == pytest.approx(0.25)
    assert math.isnan(metrics.leak(reference, 0 * reference, dark, ~dark))


def test_what_the_mask_hides_does_not_count():
    mask = rng.random(REFERENCE.shape[:2]) < 0.7
    hidden = NOISY.copy()
    hidden[~mask] = np.nan
    wild = np.where(mask[..., None], REFERENCE, 1e6).astype(np.float32)
    measured = metrics.measure(hidden, wild, mask)
    assert measured == metrics.measure(NOISY, REFERENCE, mask)
    x, r = NOISY[mask].astype(float), REFERENCE[mask].astype(float)
    assert measured["bias"] == pytest.approx((x.sum() - r.sum()) / r.sum())
    assert measured["rmse"] == pytest.approx(np.sqrt(((x - r) ** 2).mean()))


def test_picture_measures_do_not_depend_on_the_unit_of_light():
    one, thousand = metrics.measure(NOISY, REFERENCE), metrics.measure(NOISY * 1000, REFERENCE * 1000)
    for name in ("psnr", "ssim", "bias"):
        assert thousand[name] == pytest.approx(one[name], rel=1e-4)


def test_wrong_input_says_what_is_wrong():
    with pytest.raises(ValueError, match="shapes"):
        metrics.measure(gray(1, 4), gray(1, 5))
    with pytest.raises(ValueError, match="mask is empty"):
        metrics.measure(gray(1), gray(1), np.zeros((16, 16), bool))
    bad = gray(1)
    bad[2, 3, 1] = np.inf
    with pytest.raises(ValueError, match="test image has 1 pixels that are not finite"):
        metrics.measure(bad, gray(1))


def test_exposure_takes_the_99th_percentile_to_white():
    pixels = np.zeros((10, 100, 3), np.float32)
    pixels[..., :] = np.linspace(0, 5, 1000).reshape(10, 100, 1)
    assert display.exposure_of(pixels) == pytest.approx(1 / (0.99 * 5), rel=1e-3)
    assert display.exposure_of(np.zeros((4, 4, 3))) == 1
    spark = np.zeros((100, 100, 3))
    spark[3, 3] = 2
    assert display.exposure_of(spark) == pytest.approx(0.5, rel=1e-5)
