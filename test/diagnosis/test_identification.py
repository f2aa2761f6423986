# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Whether trials agree, and what is said of a fit whatever part of it cannot be computed."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cdp_ident.diagnosis.identification import Identification, repeatability
from reference.pendulum import TABLE_5
from scenarios.swings import TRUE as TRUTH
from scenarios.swings import fitted, recorded, with_effect
from scenarios.twin import twin

NAMES = ("first", "second")
BOTH = {0, 1}


@cache
def two_trials(friction=1.0, seed=0):
    rng = np.random.default_rng(seed)
    other = TABLE_5 | {"c1": friction * TABLE_5["c1"]}
    first, second = twin(rng), twin(rng, other, (2.2, 2.0, 0.0, 0.0))
    return fitted(recorded([first, second]))


def test_trials_of_one_pendulum_agree():
    results = [repeatability(two_trials(seed=seed), BOTH, NAMES) for seed in range(4)]
    assert sum(result.agree for result in results) >= 3
    assert np.mean([result.p_value for result in results]) > 0.2


def test_each_trial_s_own_estimate_stands_beside_the_joint_one():
    fit = two_trials()
    result = repeatability(fit, BOTH, NAMES)
    assert result.trials == NAMES
    assert np.abs((result.values - TRUTH) / result.std).max() < 4
    assert np.all(fit.values >= result.values.min(axis=0) - result.std.max(axis=0))
    assert np.all(fit.values <= result.values.max(axis=0) + result.std.max(axis=0))


@pytest.mark.parametrize("friction", [0.9, 1.1])
def test_trials_with_different_friction_do_not_agree(friction):
    result = repeatability(two_trials(friction), BOTH, NAMES)
    assert not result.agree
    apart = np.abs(np.diff(result.values, axis=0)[0]) / np.linalg.norm(result.std, axis=0)
    assert np.argmax(apart) == 3  # c1 / A22


def test_one_trial_has_nothing_to_agree_with():
    assert repeatability(two_trials(), {1}, NAMES) is None


def test_what_only_one_trial_shows_is_not_compared():
    fit = two_trials()
    result = repeatability(with_effect(fit, "impulse.inner", 0.0, 1.0, trial=0), BOTH, NAMES)
    assert result.p_value == pytest.approx(repeatability(fit, BOTH, NAMES).p_value, abs=0.25)


def test_a_trial_that_cannot_be_fitted_alone_costs_that_comparison_and_nothing_else(outcome):
    found = outcome.trace.completed
    # The outer rod's inertia is less than what couples it to the inner one: such rods there are none.
    impossible = replace(found.whole, values=np.array([1.0, 0.1, *found.whole.values[2:]]))
    diagnosed = Identification.of(found.options, found.data, found.search, impossible, found.fit, found.covariance)
    assert diagnosed.repeatability is None
    assert np.all(np.isfinite(diagnosed.covariance))
    (failure,) = diagnosed.failures
    assert failure.startswith("each trial alone: ")
