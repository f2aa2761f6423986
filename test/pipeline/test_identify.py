# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The whole identification of the paper's model."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.model.motions import simulate
from cdp_ident.model.parameters import SYMBOLS, groups_of, physical_coefficients
from cdp_ident.pipeline.identify import identify
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5
from scenarios.twin import TEN_SECONDS, as_measured

STARTS = {"first": TABLE_3, "second": (2.2, 2.0, 0.0, 0.0), "third": (2.4, 4.5, 0.0, 0.0)}
TRUTH = groups_of([TABLE_5[symbol] for symbol in SYMBOLS], TABLE_5["L"])
NOISE = 2e-3
OPTIONS = IdentifyOptions()


@cache
def trials():
    rng = np.random.default_rng(0)
    return tuple(
        Trial(
            name,
            TEN_SECONDS,
            as_measured(
                simulate(physical_coefficients(TABLE_5), np.array(start), TEN_SECONDS, step=0.001)[:, :2], rng, NOISE
            ),
        )
        for name, start in STARTS.items()
    )


@cache
def identified():
    return identify(trials()[:2], trials()[2:], OPTIONS)


EVERYTHING = slice(None)


def garbage(trial, samples=EVERYTHING, size=0.1):
    theta = trial.theta.copy()
    theta[samples] += np.random.default_rng(1).normal(0, size, theta[samples].shape)
    return replace(trial, theta=theta)


def assert_same_fit(first, second):
    assert np.array_equal(first.fit.values, second.fit.values)
    assert np.array_equal(first.covariance, second.covariance)
    assert first.search.history == second.search.history
    assert all(np.array_equal(a, b) for a, b in zip(first.fit.errors, second.fit.errors, strict=True))
    assert np.array_equal(first.physical.values, second.physical.values)


def held_out(found):
    """The fit's error over what is held out [rad]."""
    return fit_initial_states(found.fit.model, found.fit.values, found.data.holdout).rmse()


def test_two_trials_give_the_groups_and_a_third_confirms_them():
    found = identified()
    std = np.sqrt(np.diag(found.covariance))
    assert np.all(np.abs(found.fit.values - [*TRUTH, 0.4]) < 4 * std)
    assert np.all(std < 0.01 * found.fit.values)
    assert found.fit.rmse() == pytest.approx(NOISE, rel=0.05)
    assert held_out(found) == pytest.approx(NOISE, rel=0.05)
    assert found.repeatability.agree
    assert found.repeatability.trials == ("first", "second")
    assert found.data.noise == pytest.approx([NOISE, NOISE], rel=0.1)
    assert not found.interrupted


def test_the_physical_values_have_the_fitted_groups():
    found = identified()
    assert found.physical.possible
    *groups, length = found.fit.values
    assert groups_of(found.physical.values, length) == pytest.approx(groups, rel=1e-5)


def test_a_held_out_trial_is_never_touched_by_the_fit():
    other = identify(trials()[:2], [garbage(trials()[2])], OPTIONS)
    assert_same_fit(identified(), other)
    assert held_out(other) > 10 * held_out(identified())


def test_what_is_held_out_of_the_fitted_trials_is_never_touched():
    first, second = trials()[:2]
    plain = identify([first, second], [], OPTIONS)
    assert {window.trial for window in plain.data.holdout} == {0, 1}
    places = [
        np.concatenate([np.arange(w.first, w.first + len(w.theta)) for w in plain.data.holdout if w.trial == trial])
        for trial in (0, 1)
    ]
    other = identify([garbage(first, places[0]), garbage(second, places[1])], [], OPTIONS)
    assert_same_fit(plain, other)
    assert np.array_equal(plain.data.noise, other.data.noise)
    assert held_out(other) > 10 * held_out(plain)


def test_what_is_fitted_is_touched():
    other = identify([garbage(trials()[0], slice(300, 310)), trials()[1]], trials()[2:], OPTIONS)
    assert not np.array_equal(identified().fit.values, other.fit.values)


def test_another_seed_leads_to_the_same_basin():
    other = identify(trials()[:2], trials()[2:], replace(OPTIONS, seed=2))
    assert other.search.history != identified().search.history
    assert other.fit.values == pytest.approx(identified().fit.values, rel=1e-4)


def test_a_free_length_is_found_beside_the_groups():
    prior = Prior(nominal={"L": 0.39})
    found = identify(trials()[:2], trials()[2:], IdentifyOptions(prior=prior, length_std=np.inf))
    std = np.sqrt(found.covariance[-1, -1])
    assert abs(found.fit.values[-1] - 0.4) < 4 * std < 0.01
