# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Every reason for doubt is named."""

import tempfile
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from scipy.signal import lfilter

from cdp_ident.diagnosis.warnings import find_warnings, outlier_warnings
from cdp_ident.fit.options import IdentifyOptions
from cdp_ident.fit.prior import Prior
from cdp_ident.pipeline.identify import _balance, identify
from cdp_ident.trial.trial import Trial
from reference.truths import truth
from scenarios.clean_bags import clean_trials


@cache
def trials():
    """Those of the clean bags, every other sample."""
    with tempfile.TemporaryDirectory() as folder:
        of_bags = clean_trials(Path(folder), swing=8.0)
    return tuple(replace(trial, time=trial.time[::2], theta=trial.theta[::2]) for trial in of_bags)


@cache
def clean():
    return identify(trials(), [], IdentifyOptions())


def names(found):
    return [warning.name for warning in find_warnings(found)]


def of_name(found, name):
    (warning,) = [warning for warning in find_warnings(found) if warning.name == name]
    return warning


def test_a_good_identification_gives_no_reason_for_doubt():
    assert names(clean()) == []


def test_noise_that_is_remembered_from_sample_to_sample_is_none_either():
    memory, rng = 0.85, np.random.default_rng(1)
    noisy = []
    for trial in trials():
        fresh = rng.normal(scale=5e-3 * np.sqrt(1.0 - memory**2), size=trial.theta.shape)
        noisy.append(replace(trial, theta=trial.theta + lfilter([1.0], [1.0, -memory], fresh, axis=0)))
    assert names(identify(noisy, [], IdentifyOptions())) == []


def test_an_interrupted_search_is_named_first():
    found = identify(trials(), [], IdentifyOptions(method="iga"), lambda progress: "interrupted")
    assert names(found)[0] == "interrupted"
    assert "(interrupted)" in find_warnings(found)[0].message


def test_a_wrong_length_shows_as_error_above_the_noise():
    found = identify(trials(), [], IdentifyOptions(prior=Prior(nominal={"L": 0.42}), length_std=0.0))
    assert {"constant_off", "error_above_noise"} <= set(names(found))
    assert of_name(found, "constant_off").message.startswith("by the motion L is 0.4")


@pytest.mark.parametrize("given", [0.24, 0.64])
def test_a_length_that_forces_contradict_is_not_believed(given):
    found = identify(trials(), [], IdentifyOptions(prior=Prior(nominal={"L": given})))
    assert found.fit.values[5] == pytest.approx(0.4, rel=1e-3)
    assert of_name(found, "constant_off").message.endswith(f"from the {given:g} m that were given: measure it again")


def test_where_no_length_balances_forces_the_given_one_is_believed():
    # 57 mrad of play between the inner joint of a small rig and its encoder.
    made = truth("backlash.inner+coulomb_friction.inner", 9791)
    two = [Trial(measured.name, measured.time, measured.theta) for measured in made.trials[:2]]
    balanced = _balance(two, Prior(nominal=made.setting.nominal))
    assert np.any(balanced.unexplained > 0.3)
    assert balanced.length == made.setting.nominal["L"]


def test_a_length_or_gravity_that_motion_contradicts_is_told_with_the_right_one():
    found = identify(trials(), [], IdentifyOptions(prior=Prior(nominal={"L": 0.42})))
    warning = of_name(found, "constant_off")
    assert warning.about == ("L",)
    assert warning.message.startswith("by the motion L is 0.4")
    assert found.fit.values[-1] == pytest.approx(0.4, rel=1e-3)
    options = IdentifyOptions(prior=Prior(nominal={"g": 9.3}), length_std=0.0, gravity_std=0.002)
    assert of_name(identify(trials(), [], options), "constant_off").about == ("g",)


def test_a_disturbance_is_found_in_its_window():
    wide, folded = trials()
    window = next(w for w in clean().fit.windows if w.trial == 0 and w.begin > 5.0)
    first, last = window.begin + 0.3 * window.duration, window.begin + 0.5 * window.duration
    theta = wide.theta.copy()
    theta[(wide.time > first) & (wide.time < last)] += [0.05, 0.0]
    warning = of_name(identify([replace(wide, theta=theta), folded], [], IdentifyOptions()), "window_fits_worse")
    (where,) = warning.about
    begin, end = (float(word) for word in where.removeprefix("swing_wide from ").removesuffix(" s").split(" to "))
    assert begin < wide.start + first < wide.start + last < end
    assert end - begin == pytest.approx(window.duration, abs=0.02)


def test_outliers_of_the_fit_are_counted():
    wide, folded = trials()
    theta = folded.theta.copy()
    theta[[150, 450, 750]] += 0.3
    warning = of_name(identify([wide, replace(folded, theta=theta)], [], IdentifyOptions()), "outliers_of_the_fit")
    assert warning.about == ("swing_folded",)
    assert warning.message.startswith("3 of ") or warning.message.startswith("2 of ")  # one may be in a window held out


def test_trials_that_disagree_are_told_with_the_parameter(monkeypatch):
    found = clean()
    values = found.repeatability.values.copy()
    values[0, 3] *= 1.2
    disagreeing = replace(found.repeatability, values=values, p_value=1e-9)
    monkeypatch.setattr(type(found), "repeatability", disagreeing)
    warning = of_name(found, "trials_disagree")
    assert warning.about == ("c1_over_A22", "swing_wide", "swing_folded")


def test_an_impossible_mechanism_is_told_and_then_no_limit():
    found = clean()
    found = replace(found, physical=replace(found.physical, possible=False, values=np.full(9, 1e6)))
    assert names(found) == ["no_possible_mechanism"]


@pytest.mark.parametrize(
    ("share", "name"),
    [(0.0, "at_limit"), (1.0, "at_limit"), (0.5, None), (-0.2, "beyond_limit"), (1.2, "beyond_limit")],
)
def test_a_value_at_or_beyond_its_limits_is_named(share, name):
    found = clean()
    lower, upper = found.options.prior.box
    values = 0.5 * (lower + upper)
    values[4] = lower[4] + share * (upper[4] - lower[4])
    found = replace(found, physical=replace(found.physical, values=values))
    assert [(w.name, w.about) for w in find_warnings(found)] == ([(name, ("l2",))] if name else [])


def test_a_friction_of_zero_is_named_once():
    found = clean()
    fit = replace(found.fit, values=found.fit.values * [1, 1, 1, 1, 0, 1])
    values = found.physical.values.copy()
    values[-1] = 0.0
    found = replace(found, fit=fit, physical=replace(found.physical, values=values))
    assert [(w.name, w.about) for w in find_warnings(found)] == [("friction_at_zero", ("c2",))]


def test_a_fit_that_has_not_arrived_is_named():
    found = clean()
    found = replace(found, whole=replace(found.whole, converged=False))
    assert names(found) == ["not_converged"]


def test_outliers_are_told_and_many_are_damage():
    first, second = trials()
    assert outlier_warnings([first, second]) == []
    few, many = replace(first, outliers=(2.5, 3.0)), replace(second, outliers=tuple(np.arange(2.0, 4.0, 0.02)))
    told, damaged = outlier_warnings([few, many])
    assert (told.name, told.about) == ("outliers", (first.name,))
    assert told.message.endswith("are left out, the first at 2.500 s")
    assert f"{second.name}: 100 outliers (" in damaged.message
    assert "damaged" in damaged.message
