# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""Curves agree with the numbers of the report and are read as written; what identify did not write is refused."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from cdp_ident.errors import ReportError
from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.report.curves import NO_WINDOW, Curves, TorqueCurves, TrialCurves, curves, curves_npz, read_curves
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


def some_curves(samples=7, effects=2, trials=2):
    def angles():
        return np.arange(2.0 * samples).reshape(samples, 2)

    time, index, flags = np.arange(samples) / 200, np.arange(samples), np.arange(samples) % 2 == 0
    trial = TrialCurves(time, time, index, flags, *(angles() for _ in range(5)))
    before, after = (
        TorqueCurves(index, time, *(angles() for _ in range(4)), np.zeros((count, samples, 2)))
        for count in (0, effects)
    )
    return Curves((trial,) * trials, before, after)


@pytest.fixture
def path(tmp_path):
    path = tmp_path / "curves.npz"
    path.write_bytes(curves_npz(some_curves()))
    return path


def arrays_of(path):
    with np.load(path, allow_pickle=False) as content:
        return dict(content)


def test_curves_are_read_as_they_were_written(shown_curves, tmp_path):
    (tmp_path / "curves.npz").write_bytes(curves_npz(shown_curves))
    read = read_curves(tmp_path / "curves.npz", 3, 1)
    for part, written in zip(
        (*read.trials, read.before, read.after),
        (*shown_curves.trials, shown_curves.before, shown_curves.after),
        strict=True,
    ):
        for field in fields(part):
            assert np.array_equal(getattr(part, field.name), getattr(written, field.name), equal_nan=True)


def test_torques_may_be_of_no_sample_where_effects_were_not_looked_for(tmp_path):
    none = np.zeros((0, 2))
    torques = TorqueCurves(np.zeros(0, dtype=np.int64), np.zeros(0), none, none, none, none, np.zeros((0, 0, 2)))
    (tmp_path / "curves.npz").write_bytes(curves_npz(replace(some_curves(), before=torques, after=torques)))
    assert len(read_curves(tmp_path / "curves.npz", 2, 0).after.time) == 0


def test_the_same_curves_give_the_same_bytes():
    assert curves_npz(some_curves()) == curves_npz(some_curves())


@pytest.mark.parametrize(("trials", "effects"), [(3, 2), (2, 1), (2, 3)])
def test_curves_of_another_report_are_refused(path, trials, effects):
    with pytest.raises(ReportError, match=r"does not fit its report\.json"):
        read_curves(path, trials, effects)


@pytest.mark.parametrize(
    ("name", "array", "words"),
    [
        ("format", np.array("cdp_ident/curves/9"), "not of the format"),
        ("format", None, "not of the format"),
        ("trial0.measured", np.zeros((7, 3)), r"not float64 of shape \(7, 2\)"),
        ("trial0.before", np.full((7, 2), "x"), "trial0.before"),
        ("trial1.window", np.zeros(7), "not int64"),
        ("torques_after.effects", np.zeros((2, 6, 2)), "torques_after.effects"),
        ("trial0.time", np.full(7, np.nan), "has no time in it"),
        ("trial1.time", np.full(7, 1e308), "has no time in it"),
        ("trial0.time", np.zeros(0), "trial0.time"),
        ("trial1.run_after", None, "trial1.run_after is missing"),
        ("trial0.cart", np.array([print] * 7, dtype=object), "cannot be read"),  # a pickle, which is not opened
    ],
)
def test_arrays_that_are_not_what_they_should_be_are_refused(path, name, array, words):
    arrays = arrays_of(path) | {name: array}
    np.savez(path, **{key: value for key, value in arrays.items() if value is not None})
    with pytest.raises(ReportError, match=words):
        read_curves(path, 2, 2)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ReportError, match=r"there is no .*curves\.npz"):
        read_curves(tmp_path / "curves.npz", 1, 0)


def test_a_file_that_unfolds_to_too_much_is_not_unfolded(path, monkeypatch):
    monkeypatch.setattr("cdp_ident.report.curves._LARGEST", 10_000)
    np.savez_compressed(path, zeros=np.zeros(10_000))
    with pytest.raises(ReportError, match="would unfold to"):
        read_curves(path, 2, 2)


@given(st.integers(0, 10_000), st.integers(0, 255))
def test_damage_anywhere_is_refused_or_does_no_harm(tmp_path_factory, place, value):
    data = bytearray(curves_npz(some_curves()))
    data[place % len(data)] = value
    path = tmp_path_factory.mktemp("damaged") / "curves.npz"
    path.write_bytes(data)
    try:
        read = read_curves(path, 2, 2)
    except ReportError:
        return
    assert len(read.trials) == 2


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, 1e308])
def test_what_is_larger_than_anything_measured_is_not_a_number(path, value):
    arrays = arrays_of(path)
    arrays["trial0.measured"] = np.array(arrays["trial0.measured"])
    arrays["trial0.measured"][3, 1] = value
    np.savez(path, **arrays)
    measured = read_curves(path, 2, 2).trials[0].measured
    assert np.flatnonzero(np.isnan(measured)).tolist() == [7]
