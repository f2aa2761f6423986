# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""The curves agree with the numbers of the report, and with what is hidden in the example bags."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.report.curves import NO_WINDOW, curves
from cdp_ident.tracing.missing_torque import MissingTorque

HIDDEN_TORQUE = 0.002
"""Dry friction in the outer joint of the example bags' rig [N m]."""


def rms(values):
    return float(np.sqrt(np.mean(np.square(values))))


def test_each_trial_is_there_as_it_was_measured(outcome, shown_curves):
    for trial, curve in zip(outcome.identification.data.trials, shown_curves.trials, strict=True):
        assert np.array_equal(curve.time, trial.time)
        assert np.array_equal(curve.measured, trial.theta)
        assert not curve.cart.any()


@pytest.mark.parametrize("model", ["before", "after"])
def test_what_is_left_over_windows_is_the_report_s_error(content, shown_curves, model):
    left = [curve.measured - getattr(curve, model) for curve in shown_curves.trials]
    for role, held_out in (("fit", False), ("holdout", True)):
        chosen = [r[c.held_out == held_out] for r, c in zip(left, shown_curves.trials, strict=True)]
        assert rms(np.concatenate(chosen)) == pytest.approx(content[model]["error"][role]["rmse_rad"], rel=1e-3)


@pytest.mark.parametrize("model", ["before", "after"])
def test_the_continuous_run_s_error_is_eq_10(content, shown_curves, model):
    held_out = shown_curves.trials[2]
    squared = np.sum((held_out.measured - getattr(held_out, f"run_{model}")) ** 2)
    assert squared == pytest.approx(content[model]["error"]["holdout"]["sse_free_run"], rel=1e-6)


def test_windows_are_numbered_and_the_held_out_ones_marked(shown_curves):
    for curve, kept_out in zip(shown_curves.trials, (False, False, True), strict=True):
        assert set(curve.window) == set(range(5))
        assert np.all(np.diff(curve.window) >= 0)
        assert np.all(curve.held_out == kept_out)
        assert NO_WINDOW not in curve.window


def test_the_effect_s_torque_is_that_of_its_formula(content, shown_curves):
    torques = shown_curves.after
    size = content["effects"][0]["parameters"]["torque"]["value"]
    assert torques.effects.shape == (1, len(torques.time), 2)
    moving = np.abs(torques.speed[:, 1]) > 0.01
    assert torques.effects[0][moving, 1] == pytest.approx(-size * np.sign(torques.speed[moving, 1]), rel=1e-6)
    assert torques.effects[0][:, 0] == pytest.approx(0.0, abs=1e-9)
    assert size == pytest.approx(HIDDEN_TORQUE, rel=0.2)


def test_the_paper_s_model_s_torque_has_a_band_and_is_of_what_was_fitted(outcome, shown_curves):
    before, after = shown_curves.before, shown_curves.after
    assert np.all(before.std[:, 1] > 0)
    assert set(before.trial) == {0, 1}
    assert set(after.trial) == {0, 1, 2}
    missing = MissingTorque.of(outcome.trace.selection.before)
    assert before.missing == pytest.approx(outcome.trace.completed.inertia.value * missing.torque)


def test_the_torque_of_an_effect_of_a_trial_with_a_weight_is_the_same_in_newton_metres(weighted_outcome):
    after = curves(weighted_outcome).after
    sizes = [np.abs(after.effects[0][after.trial == trial, 1]).max() for trial in (0, 1)]
    assert sizes[0] == pytest.approx(sizes[1], rel=1e-3)


def test_an_encoder_s_error_brings_no_torque(outcome):
    effect = next(e for e in CATALOGUE if e.key == "encoder_offset.inner")
    whole = outcome.trace.whole
    off = replace(whole, model=whole.model.with_effect(ActiveEffect(effect)), values=np.append(whole.values, 0.05))
    shown = curves(replace(outcome, trace=replace(outcome.trace, whole=off))).after
    assert shown.effects.shape[0] == 2
    assert shown.effects[0].any()
    assert not shown.effects[1].any()


def test_an_effect_s_own_states_are_left_out_without_it(outcome):
    effect = next(e for e in CATALOGUE if e.brings_states and e.moves and e.joint == "outer")
    whole = outcome.trace.whole
    active = ActiveEffect(effect)
    more = replace(
        whole,
        model=whole.model.with_effect(active),
        values=np.append(whole.values, [p.typical for p in active.fitted]),
        states=tuple(np.concatenate([of, np.zeros((len(of), effect.states))], axis=1) for of in whole.states),
    )
    shown = curves(replace(outcome, trace=replace(outcome.trace, whole=more))).after
    assert np.all(np.isfinite(shown.effects))
    assert shown.effects[0].any()


def test_without_final_values_those_that_were_chosen_show_the_torques(outcome):
    shown = curves(replace(outcome, trace=replace(outcome.trace, whole=None)))
    assert set(shown.after.trial) == {0, 1}


def test_where_effects_were_not_looked_for_there_are_no_torques(outcome):
    shown = curves(replace(outcome, trace=replace(outcome.trace, selection=None)))
    assert len(shown.before.time) == len(shown.after.time) == 0
    assert len(shown.trials) == 3
