# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The whole identification: the paper's model, and windows as long as the motion can be followed by what is found."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from cdp_ident.fit.initial_states import fit_initial_states
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.model.parameters import groups_of
from cdp_ident.pipeline import identify as module
from cdp_ident.pipeline.identify import identify, identify_and_trace
from reference.pendulum import TABLE_3
from scenarios.paper_rig import GROUPS as TRUTH
from scenarios.twin import twin

STARTS = {"first": TABLE_3, "second": (2.2, 2.0, 0.0, 0.0), "third": (2.4, 4.5, 0.0, 0.0)}
NOISE = 2e-3
OPTIONS = IdentifyOptions()


@cache
def trials():
    rng = np.random.default_rng(0)
    return tuple(twin(rng, start=start, noise=NOISE, name=name) for name, start in STARTS.items())


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
    assert found.search.completed


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


def by_chance(rng, size=6e-3):
    """Return a torque in the outer joint [N m] that goes up and down by chance, 0.3 to 4 times a second."""
    waves = 30
    frequency, phase = rng.uniform(0.3, 4.0, waves), rng.uniform(0.0, 2.0 * np.pi, waves)

    def torque(time, state):
        outer = size * np.sqrt(2.0 / waves) * np.sum(np.sin(2.0 * np.pi * frequency * time + phase))
        return -outer, outer

    return torque


@pytest.fixture(scope="module")
def driven_by_chance():
    def swing(k, *angles):
        rng, torque = np.random.default_rng(k), by_chance(np.random.default_rng(k))
        return twin(rng, start=(*angles, 0.0, 0.0), noise=5e-4, torque=torque, tolerance=1e-8, name=f"swing{k}")

    return [swing(0, 2.2, 2.6)], [swing(2, 1.9, 3.0)]


@pytest.mark.long
def test_a_motion_with_chance_in_it_is_judged_over_half_a_swing_and_its_values_are_right(driven_by_chance):
    said = []
    options = IdentifyOptions(named_effects_only=True)
    found, traced = identify_and_trace(*driven_by_chance, options, say=said.append)
    assert any("are too long for this motion" in line for line in said)
    assert traced.longer.duration > 1.5 * found.data.scales.half_swing >= 1.2 * found.data.window
    assert traced.errors["effects"].holdout.rmse < 0.6 * traced.longer.error
    assert not traced.effects  # chance is none of them
    assert traced.completed.fit.values[:3] == pytest.approx(TRUTH[:3], rel=1e-3)


@pytest.mark.campaign
def test_windows_whose_length_is_given_keep_it(driven_by_chance):
    options = IdentifyOptions(window=2.0, named_effects_only=True)
    found, traced = identify_and_trace(*driven_by_chance, options)
    assert traced.longer is None
    assert found.data.window == pytest.approx(2.0, rel=0.1)


def test_where_the_fit_itself_fails_shorter_windows_are_of_no_use(monkeypatch):
    failed = SimpleNamespace(failure="no motion", data=SimpleNamespace(window=4.0))
    monkeypatch.setattr(module, "identify", lambda *_: failed)
    monkeypatch.setattr(module, "trace", lambda *_: SimpleNamespace(failure="no motion"))
    found, _ = identify_and_trace([], [], IdentifyOptions())
    assert found is failed
