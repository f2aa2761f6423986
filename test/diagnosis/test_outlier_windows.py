"""Windows that fit far worse than the rest."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.outlier_windows import outlier_windows
from cdp_ident.fit.initial_states import Fit, fit_initial_states
from cdp_ident.fit.mechanism import Mechanism
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.model.parameters import SYMBOLS, groups_of
from reference.pendulum import TABLE_5
from scenarios.twin import standard_twin

TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
WINDOWS = cut_into_windows([standard_twin(np.random.default_rng(0))])
FIT = fit_initial_states(MotionModel(Mechanism.of(Prior())), TRUTH, WINDOWS)


def with_errors(*factors: float) -> Fit:
    return replace(FIT, residuals=tuple(f * r for f, r in zip(factors, FIT.residuals, strict=True)))


def test_the_worst_comes_first_and_says_how_many_times_worse_it_is() -> None:
    found = outlier_windows([with_errors(1.0, 5.0, 1.0, 10.0)], 1.5)
    assert [outlier.window for outlier in found] == [FIT.windows[3], FIT.windows[1]]
    assert found[0].ratio == pytest.approx(10.0 / 3.0, rel=0.1)


def test_windows_that_were_fitted_and_kept_out_are_compared_with_each_other() -> None:
    (outlier,) = outlier_windows([FIT, with_errors(1.0, 4.0, 1.0, 1.0)], 3.0)
    assert outlier.window is FIT.windows[1]
    assert outlier.error == pytest.approx(4.0 * FIT.rmse(), rel=0.1)


def test_of_two_windows_none_is_an_outlier() -> None:
    two = replace(FIT, windows=FIT.windows[:2], residuals=(FIT.residuals[0], 100 * FIT.residuals[1]))
    assert outlier_windows([two], 1.5) == []
