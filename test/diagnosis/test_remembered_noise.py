"""The process of the noise, found again behind what a fit leaves of it."""

import numpy as np
import pytest
from scipy.linalg import toeplitz
from scipy.signal import lfilter

from cdp_ident.diagnosis.remembered_noise import Followed, Process, autoregressive

WINDOWS, SAMPLES, STATES, UNKNOWNS = 12, 160, 4, 5
KEPT = np.exp(-0.1)


def noise(rng, poles):
    drawn = rng.normal(size=(SAMPLES + 400, 2))
    return lfilter([1.0], poles, drawn, axis=0)[400:]


def followed(rng):
    """Slow changes of each window by its initial state, and by common unknowns that are orthogonal to these."""
    time = np.linspace(-1.0, 1.0, SAMPLES)
    explained, by_unknowns = [], []
    for _ in range(WINDOWS):
        slow = time[:, None] ** np.arange(STATES + UNKNOWNS) @ rng.normal(size=(STATES + UNKNOWNS, 2 * 9))
        basis, _ = np.linalg.qr(slow.reshape(SAMPLES, 2, 9).reshape(2 * SAMPLES, 9))
        both = basis.reshape(SAMPLES, 2, 9)
        explained.append(both[..., :STATES])
        by_unknowns.append(both[..., STATES:] / np.sqrt(WINDOWS))
    return explained, by_unknowns


def left(noises, explained, by_unknowns):
    """What a linear fit leaves of noise."""
    change = sum(np.einsum("nru,nr->u", by, of) for by, of in zip(by_unknowns, noises, strict=True))
    return [
        of - by @ change - own @ np.einsum("nrs,nr->s", own, of)
        for of, own, by in zip(noises, explained, by_unknowns, strict=True)
    ]


def autocovariances(process, lags=80):
    return process.covariance_times(np.eye(lags + 1, 1))[:, 0]


def found(seed, poles):
    rng = np.random.default_rng(seed)
    changes = followed(rng)
    residuals = left([noise(rng, poles) for _ in range(WINDOWS)], *changes)
    sizes = [np.ones((SAMPLES, 1))] * WINDOWS
    as_left = nothing_followed(WINDOWS, SAMPLES)
    return [autoregressive(residuals, sizes, of) for of in (Followed(*changes, np.eye(UNKNOWNS)), as_left)]


def nothing_followed(windows, samples):
    nothing = [np.empty((samples, 2, 0))] * windows
    return Followed(nothing, nothing, np.eye(0))


def test_noise_that_a_fit_has_followed_is_found_to_be_as_slow_as_it_is():
    both = [found(seed, [1.0, -KEPT]) for seed in range(8)]
    corrected, as_left = (
        np.mean([p.variance / (1.0 - p.coefficients.sum()) ** 2 for p in processes])
        for processes in zip(*both, strict=True)
    )
    true = 1.0 / (1.0 - KEPT) ** 2
    assert corrected == pytest.approx(true, rel=0.15)
    assert as_left < 0.75 * true


def test_noise_that_oscillates_is_found_to_do_so():
    poles = np.array([1.0, -2.0 * 0.97 * np.cos(2.0 * np.pi / 40.0), 0.97**2])
    process, _ = found(0, poles)
    correlations, true = (autocovariances(p)[[0, 10, 20, 40]] for p in (process, Process(-poles[1:], 1.0)))
    assert correlations / correlations[0] == pytest.approx(true / true[0], abs=0.2)
    assert correlations[2] < 0.0 < correlations[3]


def test_white_noise_has_no_memory_and_lost_what_was_fitted():
    process, _ = found(0, [1.0])
    assert len(process.coefficients) == process.lead == 0
    share = 1.0 - (STATES * WINDOWS + UNKNOWNS) / (2.0 * SAMPLES * WINDOWS)
    assert process.loss == pytest.approx(share)
    assert process.variance == pytest.approx(1.0, rel=0.1)


def test_samples_that_count_together_count_once():
    rng = np.random.default_rng(0)
    weights = np.r_[np.ones(80), np.full(80, 1.0 / 80.0)][:, None]
    residuals = [np.sqrt(weights) * rng.normal(size=(160, 2))]
    process = autoregressive(residuals, [np.sqrt(weights)], nothing_followed(1, 160))
    assert process.variance == pytest.approx(1.0, rel=0.3)


def test_no_residuals_are_of_no_noise():
    assert autoregressive([np.zeros((20, 2))], [np.ones((20, 1))], nothing_followed(1, 20)).variance == 0.0


def test_a_covariance_is_that_of_its_autocovariances():
    process = Process(np.array([1.2, -0.5]), 0.3)
    matrix = toeplitz(autocovariances(process, 49))
    rows = np.random.default_rng(0).normal(size=(50, 3))
    assert process.covariance_times(rows) == pytest.approx(matrix @ rows, rel=1e-2, abs=1e-2)
    spread = process.spread_back(rows)
    assert process.variance * spread.T @ spread == pytest.approx(rows.T @ matrix @ rows, rel=1e-2, abs=1e-2)
    again = Process.of(matrix[:3, :3], 2)
    assert again.coefficients == pytest.approx(process.coefficients, abs=1e-2)
    assert again.variance == pytest.approx(process.variance, rel=1e-2)


def test_what_grows_is_made_to_fade():
    products = np.array([[4.0, 2.0], [2.0, 1.0]])
    process = Process.of(products + 1e-3 * np.eye(2), 1)
    assert 0.99 < process.coefficients[0] < 1.0
    assert process.variance > 0.0


def test_what_is_new_was_not_there_before():
    process = Process(np.array([0.9]), 1.0)
    new = np.random.default_rng(0).normal(size=(100, 2))
    assert process.new_in(lfilter([1.0], [1.0, -0.9], new, axis=0)) == pytest.approx(new[1:])


def test_what_no_process_left_is_still_of_some_variance():
    """Slow swings, of which what was fitted is said to have taken more than there is."""
    rng = np.random.default_rng(5)
    changes = followed(rng)
    time = 2.0 * np.pi * np.arange(SAMPLES)[:, None] / 1000.0
    swings = [np.sin(time + rng.uniform(0.0, 6.0)) + rng.normal(scale=1e-4, size=(SAMPLES, 2)) for _ in range(WINDOWS)]
    process = autoregressive(swings, [np.ones((SAMPLES, 1))] * WINDOWS, Followed(*changes, np.eye(UNKNOWNS)))
    assert process.variance > 0.0
    assert process.loss > 0.0
