"""The curves agree with the numbers of the report, and with what is hidden in the example bags."""

from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.report.curves import NO_WINDOW, curves

HIDDEN_TORQUE = 0.002
"""Dry friction in the outer joint of the example bags' rig [N m]."""
SMALLEST_STEP = 2 * np.pi / 8000
"""Of the rig's encoders [rad]."""


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
    torques = shown_curves.torques
    size = content["effects"][0]["parameters"]["torque"]["value"]
    expected = -size * np.sign(torques.speed[:, 1])
    assert torques.effects.shape == (1, len(torques.time), 2)
    assert torques.effects[0][:, 1] == pytest.approx(
        expected, abs=2e-3 * size
    )  # as it was judged, before the final values
    assert torques.effects[0][:, 0] == pytest.approx(0.0, abs=1e-9)
    assert size == pytest.approx(HIDDEN_TORQUE, rel=0.2)


def test_the_missing_torque_follows_the_effect_before_and_vanishes_after(shown_curves):
    torques = shown_curves.torques
    slow = np.abs(torques.speed[:, 1]) < 4
    forwards = slow & (torques.speed[:, 1] > 0.5)
    backwards = slow & (torques.speed[:, 1] < -0.5)
    step_before = torques.before[backwards, 1].mean() - torques.before[forwards, 1].mean()
    step_after = torques.after[backwards, 1].mean() - torques.after[forwards, 1].mean()
    assert step_before > HIDDEN_TORQUE
    assert abs(step_after) < 0.2 * step_before
    without = torques.after + torques.effects[0]
    assert (without[backwards, 1].mean() - without[forwards, 1].mean()) / 2 == pytest.approx(HIDDEN_TORQUE, rel=0.2)


def test_an_encoder_s_error_is_taken_out_before_torques_are_looked_at(outcome, shown_curves):
    """An offset of the inner encoder, made up, moves the joints' angles by itself and brings no torque."""
    offset = 0.05
    effect = next(e for e in CATALOGUE if e.key == "encoder_offset.inner")
    after = outcome.trace.after
    model = after.model.with_effect(ActiveEffect(effect))
    values = np.append(after.fit.values, offset)
    fit, holdout = (replace(part, model=model, values=values) for part in (after.fit, after.holdout))
    off = replace(after, fit=fit, holdout=holdout)
    shifted = curves(replace(outcome, trace=replace(outcome.trace, after=off))).torques
    assert shifted.angle[:, 0] == pytest.approx(shown_curves.torques.angle[:, 0] - offset, abs=SMALLEST_STEP)
    assert shifted.effects.shape[0] == 2
    assert not shifted.effects[1].any()


def test_torques_before_and_after_are_of_the_same_samples_though_a_spike_lost_its_weight_in_between(outcome):
    after = outcome.trace.after
    window, *others = after.fit.windows
    weights = window.counts.copy()
    weights[len(weights) // 2] = 0.1
    fit = replace(after.fit, windows=(replace(window, sample_weights=weights), *others))
    shown = curves(replace(outcome, trace=replace(outcome.trace, after=replace(after, fit=fit)))).torques
    assert len(shown.time) == len(curves(outcome).torques.time) - 1
    assert len(shown.before) == len(shown.after) == len(shown.time)
