"""Correlation of the residuals in time."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.autocorrelation import autocovariance
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.refinement import Fit, refine
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin

TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
FIT = refine(MotionModel(Mechanism.of(Prior())), TRUTH, cut_into_windows([standard_twin(np.random.default_rng(0))]))


def with_residuals(correlation: float) -> Fit:
    rng = np.random.default_rng(0)
    noise = rng.normal(size=(20000, 2))
    for k in range(1, len(noise)):
        noise[k] = correlation * noise[k - 1] + np.sqrt(1 - correlation**2) * noise[k]
    return replace(FIT, residuals=tuple(np.split(noise, 4)))


def test_white_residuals_are_not_correlated() -> None:
    assert FIT.autocorrelation.length <= 3
    assert FIT.autocorrelation.integrated_time < 1.5
    assert with_residuals(0.0).autocorrelation.integrated_time == pytest.approx(1.0, abs=0.1)


def test_the_integrated_time_of_a_first_order_process_is_the_known_one() -> None:
    fit = with_residuals(0.8)
    assert fit.autocorrelation.integrated_time == pytest.approx(1.8 / 0.2, rel=0.25)
    assert fit.autocorrelation.length > 10


def test_the_autocovariance_is_the_sum_of_products() -> None:
    found = autocovariance(FIT.residuals)
    for lag in (0, 3):
        expected = sum(np.sum(r[lag:] * r[: len(r) - lag], axis=0) for r in FIT.residuals)
        np.testing.assert_allclose(found[lag], expected, rtol=1e-9)
