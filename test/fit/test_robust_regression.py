import numpy as np
import pytest

from cdp_ident.fit.robust_regression import regress

TRUTH = np.array([2.0, 0.5])


def problem(noise=0.0, rows=4000, outliers=0, copies=4):
    """Two unknowns, the second of which has a noisy column, in both components."""
    rng = np.random.default_rng(4)
    clean = rng.normal(size=(rows, 2, 2))
    target = clean @ TRUTH + rng.normal(scale=0.05, size=(rows, 2))
    target[:outliers] += 30.0
    own = clean.copy()
    own[..., 1] += rng.normal(scale=noise, size=(rows, 2))
    columns = np.stack([own] + [own] * copies)
    columns[1:, ..., 1] += rng.normal(scale=noise, size=(copies, rows, 2))
    return columns, np.stack([target] * (copies + 1)), np.ones((rows, 2), dtype=bool)


def fit(columns, target, holds, lower=(-np.inf, -np.inf)):
    return regress(columns, target, holds, np.array(lower), np.full(2, np.inf), 1)


def test_noise_in_the_regressors_does_not_draw_values_to_zero():
    columns, target, holds = problem(noise=0.6)
    assert fit(columns, target, holds).values == pytest.approx(TRUTH, rel=0.03)
    uncorrected = fit(columns[:1].repeat(2, axis=0), target[:2], holds).values
    assert uncorrected[1] < 0.8 * TRUTH[1]


def test_wild_rows_lose_their_weight():
    result = fit(*problem(outliers=200))
    assert result.values == pytest.approx(TRUTH, rel=0.02)
    assert result.weights[:200].max() < 0.1
    assert np.median(result.weights[200:]) == 1.0


def test_components_that_do_not_hold_say_nothing():
    columns, target, holds = problem()
    target[:, ::2, 1] = 1e3
    holds[::2, 1] = False
    assert fit(columns, target, holds).values == pytest.approx(TRUTH, rel=0.01)


def test_limits_are_kept_and_leave_no_variance():
    result = fit(*problem(), lower=(-np.inf, 0.8))
    assert result.values[1] == pytest.approx(0.8)
    assert result.covariance[1, 1] == 0.0


def test_what_no_row_speaks_of_has_no_finite_variance():
    columns, target, holds = problem()
    columns[..., 1] = 0.0
    assert np.isinf(fit(columns, target, holds).covariance[1, 1])


def test_the_covariance_is_that_of_the_errors():
    columns, target, holds = problem(rows=200)
    rng = np.random.default_rng(5)
    values = []
    for _ in range(60):
        noisy = target + rng.normal(scale=0.2, size=target.shape[1:])
        result = fit(columns, noisy, holds)
        values.append(result.values)
    assert np.std(values, axis=0) == pytest.approx(np.sqrt(np.diag(result.covariance)), rel=0.35)
