# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""A new trial before it is fitted: does what was identified still hold?"""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.diagnosis.new_trial import check_new_trial
from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.model.weights import Weight
from cdp_ident.pipeline.identify import identify
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import twin
from scenarios.weighted import plain_and_weighted

NOISE = 5e-4


def trial(name, start=TABLE_3, seed=1, **changed):
    return twin(np.random.default_rng(seed), {**TABLE_5, **changed}, start, noise=NOISE, tolerance=1e-8, name=name)


@pytest.fixture(scope="module")
def found():
    return identify([trial("first"), trial("second", (4.0, 2.5, 0.0, 0.0), 2)], [], IdentifyOptions())


def checked(found, new):
    expected = fit_initial_states(found.fit.model, found.fit.values, found.data.holdout).rmse()
    return check_new_trial(found.fit, found.covariance, expected, new, found.data)


def test_a_trial_of_the_same_pendulum_fits_to_the_noise(found):
    check = checked(found, trial("third", (2.2, 4.1, 0.0, 0.0), 3))
    assert check.fits
    assert check.rmse == pytest.approx(check.expected_rmse, rel=0.2)
    assert check.changed == ()
    assert check.warning() is None


def test_more_friction_in_a_joint_is_told_with_the_numbers(found):
    check = checked(found, trial("third", (2.2, 4.1, 0.0, 0.0), 3, c2=2 * TABLE_5["c2"]))
    assert not check.fits
    assert check.rmse > 2 * check.expected_rmse
    worst = check.changed[0]
    assert worst.name == "c2_over_A22"
    assert worst.alone == pytest.approx(2 * worst.before, rel=0.05)
    warning = check.warning()
    assert warning.name == "no_longer_fits"
    assert warning.about == ("third",)
    assert "third no longer fits" in warning.message
    assert "c2_over_A22" in warning.message


def test_a_short_trial_is_one_window(found):
    short = twin(
        np.random.default_rng(3), TABLE_5, (2.2, 4.1, 0.0, 0.0), np.arange(200) / 200, noise=NOISE, tolerance=1e-8
    )
    assert checked(found, short).fits


def test_where_each_trial_has_zeros_of_its_own_a_new_one_may_have_others(found):
    model, values = found.fit.model.with_zeros(found.fit.values, [0, 1])
    known = ~model.of_zeros
    spread = np.zeros((len(values), len(values)))
    spread[np.ix_(known, known)] = found.covariance
    new = trial("third", (2.2, 4.1, 0.0, 0.0), 3)
    off = replace(new, theta=new.theta + np.cumsum([0.03, -0.05]))
    expected = fit_initial_states(found.fit.model, found.fit.values, found.data.holdout).rmse()
    check = check_new_trial(replace(found.fit, model=model, values=values), spread, expected, off, found.data)
    assert check.fits
    assert check.changed == ()
    assert not checked(found, off).fits


@pytest.fixture(scope="module")
def absolute():
    return identify(plain_and_weighted(np.random.default_rng(0), noise=NOISE), [], IdentifyOptions())


def test_a_trial_with_another_weight_fits_once_A22_is_known(absolute):  # noqa: N802 - a symbol
    _, other = plain_and_weighted(np.random.default_rng(1), Weight("inner", 0.1, 0.2), noise=NOISE)
    check = checked(absolute, other)
    assert check.fits
    assert check.changed == ()


def test_of_a_trial_with_a_weight_that_is_not_told_is_said_what_it_changes(absolute):
    _, other = plain_and_weighted(np.random.default_rng(1), noise=NOISE)
    check = checked(absolute, replace(other, weights=()))
    assert not check.fits
    assert "one_over_A22" not in [changed.name for changed in check.changed]
