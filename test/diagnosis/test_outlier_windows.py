"""Windows that fit far worse than the rest."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.outlier_windows import explains_an_outlier, outlier_windows
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
NOISE = np.full(2, FIT.rmse())


def with_errors(*factors: float) -> Fit:
    return replace(FIT, residuals=tuple(f * r for f, r in zip(factors, FIT.residuals, strict=True)))


def test_the_worst_comes_first_and_says_how_many_times_worse_it_is() -> None:
    found = outlier_windows([with_errors(1.0, 5.0, 1.0, 10.0)], 1.5)
    assert [outlier.window for outlier in found] == [FIT.windows[3], FIT.windows[1]]
    assert found[0].ratio == pytest.approx(10.0 / 3.0, rel=0.1)


def test_windows_that_were_fitted_and_kept_out_are_compared_with_each_other() -> None:
    (outlier,) = outlier_windows([FIT, with_errors(1.0, 4.0, 1.0, 1.0)], 3.0, NOISE)
    assert outlier.window is FIT.windows[1]
    assert outlier.error == pytest.approx(4.0, rel=0.1)


def test_what_is_not_above_the_noise_is_none() -> None:
    quiet = with_errors(0.1, 0.1, 0.8, 0.1)
    assert outlier_windows([quiet], 3.0)
    assert outlier_windows([quiet], 3.0, NOISE) == []


def test_of_two_windows_none_is_an_outlier() -> None:
    two = replace(FIT, windows=FIT.windows[:2], residuals=(FIT.residuals[0], 100 * FIT.residuals[1]))
    assert outlier_windows([two], 1.5) == []


def test_what_is_explained_is_an_outlier_only_where_the_window_stood_out_and_no_longer_does() -> None:
    assert explains_an_outlier(with_errors(1.0, 5.0, 1.0, 1.0), FIT, 6.0, 1.7)
    assert not explains_an_outlier(with_errors(1.0, 5.0, 1.0, 1.0), with_errors(1.0, 3.0, 1.0, 1.0), 6.0, 1.7)
    assert not explains_an_outlier(with_errors(1.01, 1.01, 1.01, 1.01), FIT, 6.0, 1.7)
