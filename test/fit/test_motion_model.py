# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What the encoders show, and its derivatives by all that a fit adjusts."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cdp_ident.fit.active_effect import ActiveEffect
from cdp_ident.fit.motion_model import MotionModel
from cdp_ident.fit.prior import Mechanism, Prior
from cdp_ident.fit.windows import cut_into_windows
from cdp_ident.likelihood.swing import Swing
from cdp_ident.model.parameters import GROUPS, SYMBOLS, coefficients_of, groups_of, inertia_about_cart
from cdp_ident.model.weights import Weight
from cdp_ident.trial.trial import Trial
from reference.pendulum import TABLE_3, TABLE_5
from reference.weights import with_weight
from scenarios.effects import EFFECTS
from scenarios.paper_rig import A22
from scenarios.paper_rig import GROUPS as TRUTH
from scenarios.twin import standard_twin

MODEL = MotionModel(Mechanism.of(Prior()))
WEIGHTS = (Weight("inner", 0.08, 0.25, 3e-5, 0.001, 0.002), Weight("outer", 0.05, 0.3, 2e-5, 0.0005, 0.001))
ABSOLUTE = replace(MODEL, inertia_free=True)
STEP = 1e-6
STEP_OF_GRID = 0.005
"""[s]"""


def first_window():
    (window, *_) = cut_into_windows([standard_twin(np.random.default_rng(0))])
    return replace(window, start=np.array(TABLE_3))


def with_effects(*keys):
    """Return a model with effects, and values of its unknowns."""
    model, values = MODEL, list(TRUTH)
    for key in keys:
        active = ActiveEffect(EFFECTS[key], 0 if EFFECTS[key].at_an_instant else None)
        model = model.with_effect(active)
        values += [0.7 if p.name == "time" else p.typical for p in active.fitted]
    return model, np.array(values)


def derivatives_of(model, values, start, window):
    """Return what encoders show in a window, and its derivatives by the state at its beginning and the unknowns."""
    (whole,) = Swing.of(Trial("", window.time, window.theta), 0, STEP_OF_GRID, window.duration)
    times = whole.times._replace(u=window.u, begin=np.array([window.begin]))
    whole = replace(whole, trial=window.trial, begin=window.begin, times=times, weights=window.weights)
    linear = whole.linearised(model, values, start[None])
    by = np.zeros((len(window.time), 2, model.states + len(values)))
    by[..., [*range(model.states), *(model.states + linear.columns)]] = linear.slopes
    return linear.residuals, by


def assert_derivatives_are_differences(model, values, window, kinks=0):
    """Compare derivatives by all directions; at as many samples as there are kinks, differences may be none."""
    states = model.states
    point = np.concatenate([model.initial_state(window.start), values])
    _, sensitivity = derivatives_of(model, values, point[:states], window)
    for direction in range(len(point)):
        sides, size = [], min(STEP, 1e-3 * abs(point[direction]) or STEP)
        for step in (size, -size):
            moved = point.copy()
            moved[direction] += step
            sides.append(derivatives_of(model, moved[states:], moved[:states], window)[0])
        expected = (sides[0] - sides[1]) / (2 * size)
        away = np.sort(np.abs(sensitivity[:, :, direction] - expected).max(axis=1))
        assert away[len(away) - 1 - kinks] <= 1e-4 * np.abs(expected).max() + 1e-12


def test_effects_of_both_encoders_a_late_one_and_a_torque_have_the_derivatives_of_differences():
    of_outer = ("joint_spring.outer", "time_offset.outer", "encoder_eccentricity.outer", "backlash.outer")
    keys = ("encoder_scale.inner", *of_outer)
    model, values = with_effects(*keys)
    assert_derivatives_are_differences(model, values, first_window(), kinks=1)


def test_derivatives_with_a_base_that_swings_and_a_late_encoder_are_those_of_differences():
    model, _ = with_effects("pivot_compliance.base.oscillating", "time_offset.outer")
    # Its own oscillation is slow enough for differences of a millionth.
    values = np.concatenate([TRUTH, [1e-3, 7.0, 0.1, 0.002]])
    assert model.states == 6
    assert_derivatives_are_differences(model, values, first_window())


def test_a_start_is_filled_up_to_what_the_model_s_effects_need():
    model, _ = with_effects("pivot_compliance.base.oscillating")
    start = np.array(TABLE_3)
    assert np.array_equal(model.initial_state(start), [*start, 0.0, 0.0])
    assert np.array_equal(MODEL.initial_state(np.array([*start, 0.1, 0.2])), start)


def test_with_derivatives_or_none_the_readings_are_the_same():
    model, values = with_effects("joint_spring.outer", "time_offset.outer", "encoder_scale.inner")
    model, values = model.with_zeros(values, [0])
    values[model.of_zeros] = [0.02, -0.03]
    window = first_window()
    found = model.motions_in(values, window.start[None], window, derive=True)
    same, by_start = found.readings, found.by
    np.testing.assert_allclose(model.predict(values, window.start, window), same, rtol=0, atol=1e-12)
    off, by_all = derivatives_of(model, values, window.start, window)
    np.testing.assert_allclose(by_start, np.cumsum(by_all[..., : model.states], axis=1), rtol=1e-9, atol=1e-9)
    np.testing.assert_allclose(same, window.theta + np.cumsum(off, axis=1), rtol=0, atol=1e-9)


def test_derivatives_by_length_and_gravity_are_those_of_differences():
    model = replace(MODEL, length_std=np.inf, gravity_std=np.inf)
    assert_derivatives_are_differences(model, model.initial_values(TRUTH), first_window())


def readings(key, *values, trial=0):
    model = MODEL.with_effect(ActiveEffect(EFFECTS[key], trial if EFFECTS[key].at_an_instant else None))
    window = first_window()
    plain = MODEL.predict(TRUTH, window.start, window)
    shown = model.predict(np.concatenate([TRUTH, values]), window.start, window)
    return window.time, plain, shown


@pytest.mark.parametrize(("joint", "seen_by_theta1"), [("inner", 0.02), ("outer", 0.0)])
def test_an_offset_of_the_inner_encoder_is_in_both_absolute_angles(joint, seen_by_theta1):
    _, plain, shown = readings(f"encoder_offset.{joint}", 0.02)
    assert np.allclose(shown - plain, [seen_by_theta1, 0.02], rtol=0, atol=1e-12)


@pytest.mark.parametrize("key", ["encoder_slip.outer", "impulse.inner"])
def test_what_happens_in_one_trial_is_not_in_another(key):
    _, plain, shown = readings(key, 0.1, 1.0, trial=1)
    assert np.array_equal(shown, plain)


def test_an_encoder_with_play_sets_out_from_where_it_is_in_the_gap_beside_its_other_effects():
    model, values = with_effects("backlash.outer", "encoder_scale.outer", "encoder_offset.outer")
    model, values = model.with_zeros(values, [0])
    values[model.of_zeros] = [0.02, -0.03]
    values[model.places(0)] = 0.1
    window = first_window()
    joint, scale, offset = window.start[1] - window.start[0], 0.01, 0.01 - 0.03
    shown = model.predict(values, np.append(window.start, -0.8), window)
    assert shown[0, 1] - shown[0, 0] == pytest.approx(joint * (1.0 + scale) + offset + 0.04, abs=1e-9)


def test_free_length_and_gravity_enter_the_coefficients():
    model = replace(MODEL, length_std=np.inf, gravity_std=np.inf)
    values = np.concatenate([TRUTH, [0.3, 9.7]])
    assert model.constants(values) == (0.3, 9.7)
    assert np.array_equal(model.coefficients(values), coefficients_of(TRUTH, 0.3, 9.7))
    assert np.array_equal(model.initial_values(TRUTH), np.concatenate([TRUTH, [0.4, 9.81]]))


def heavier_groups_and_inertia():
    """Return those of the rig whose rods are heavier by the weights."""
    values = TABLE_5
    for weight in WEIGHTS:
        values = with_weight(values, weight.rod, weight.mass, weight.place, weight.inertia)
    physical = np.array([values[symbol] for symbol in SYMBOLS])
    return groups_of(physical, values["L"]), float(inertia_about_cart(physical, values["L"]))


def test_a_rig_with_weights_moves_as_one_whose_rods_are_heavier():
    window = first_window()
    groups, _ = heavier_groups_and_inertia()
    expected = MODEL.predict(groups, window.start, window)
    weighted = replace(window, weights=WEIGHTS)
    assert ABSOLUTE.predict(ABSOLUTE.initial_values(TRUTH, A22), window.start, weighted) == pytest.approx(
        expected, abs=1e-9
    )
    known = replace(MODEL, mechanism=replace(MODEL.mechanism, inertia=A22))
    assert known.predict(TRUTH, window.start, weighted) == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(
    "key",
    [
        "coulomb_friction.inner",
        "load_friction.inner",
        "load_friction.outer",
        "pivot_compliance.base",
        "gravity_tilt.base",
        "geared_rotor.outer",
    ],
)
def test_an_effect_is_the_same_in_physical_units_with_weights_and_without(key):
    effect, window = EFFECTS[key], first_window()
    groups, inertia = heavier_groups_and_inertia()
    carried = 0.05 if key == "load_friction.outer" else 0.13
    of_rig = [p.typical * p.scale(A22) for p in effect.parameters]
    of_heavier = [value + carried * p.includes_weights for p, value in zip(effect.parameters, of_rig, strict=True)]
    plain, absolute = (model.with_effect(ActiveEffect(effect)) for model in (MODEL, ABSOLUTE))

    def seen(base, physical, over):
        return np.append(base, [value / p.scale(over) for p, value in zip(effect.parameters, physical, strict=True)])

    expected = plain.predict(seen(groups, of_heavier, inertia), window.start, window)
    found = absolute.predict(
        seen(ABSOLUTE.initial_values(TRUTH, A22), of_rig, A22), window.start, replace(window, weights=WEIGHTS)
    )
    assert np.abs(found - expected).max() < 1e-7


def test_a_base_that_swings_carries_the_weights_too():
    effect, window = EFFECTS["pivot_compliance.base.oscillating"], first_window()
    groups, inertia = heavier_groups_and_inertia()
    compliance, frequency, damping_ratio = 2e-3, 9.0, 0.1
    mass = 1.0 / (compliance * frequency**2)
    share = math.sqrt(mass / (mass + 0.13))
    plain, absolute = (model.with_effect(ActiveEffect(effect)) for model in (MODEL, ABSOLUTE))
    heavier = np.append(groups, [compliance * inertia, share * frequency, share * damping_ratio])
    expected = plain.predict(heavier, window.start, window)
    of_rig = np.append(ABSOLUTE.initial_values(TRUTH, A22), [compliance * A22, frequency, damping_ratio])
    found = absolute.predict(of_rig, window.start, replace(window, weights=WEIGHTS))
    assert np.abs(found - expected).max() < 1e-7


@pytest.mark.parametrize(
    "keys", [(), ("coulomb_friction.outer", "encoder_scale.inner"), ("load_friction.inner", "joint_spring.outer")]
)
def test_derivatives_with_weights_are_those_of_differences(keys):
    model, values = with_effects(*keys)
    errors = tuple(error for weight in WEIGHTS for error in weight.errors)
    free = replace(model, inertia_free=True, length_std=np.inf, weight_errors=errors)
    values = np.concatenate([TRUTH, [0.4, 1.0 / A22], [0.2, 0.3, -0.4, 0.1], values[5:]])
    assert_derivatives_are_differences(free, values, replace(first_window(), weights=WEIGHTS))


def test_an_error_of_a_weight_is_the_motion_of_another_weight_and_costs_as_much_as_it_is_unlikely():
    window, errors = replace(first_window(), weights=WEIGHTS), tuple(e for weight in WEIGHTS for e in weight.errors)
    model = replace(ABSOLUTE, weight_errors=errors)
    assert model.names[6:] == (
        "weight_error.mass.80 g", "weight_error.inner.250 mm", "weight_error.mass.50 g", "weight_error.outer.300 mm"
    )  # fmt: skip
    sizes = np.array([1.5, -0.5, 2.0, 0.7])
    values = model.initial_values(TRUTH, A22)
    assert not np.any(values[model.of_weights])
    values[model.of_weights] = sizes
    off = tuple(
        replace(weight, mass=weight.mass + mass * weight.mass_std, place=weight.place + place * weight.place_std)
        for weight, mass, place in zip(WEIGHTS, sizes[::2], sizes[1::2], strict=True)
    )
    expected = ABSOLUTE.predict(values[:6], window.start, replace(window, weights=off))
    assert model.predict(values, window.start, window) == pytest.approx(expected, abs=1e-9)
    off_by, precision = values - model.known[0], model.known[1]
    assert precision @ off_by**2 == pytest.approx(np.sum(sizes**2))
    assert np.all(model.limits[0][model.of_weights] < -5.0)
    assert not np.any(model.of_rig & model.of_weights)


def test_where_the_inertia_is_taken_as_known_the_motion_stays_the_same():
    window = replace(first_window(), weights=WEIGHTS)
    values = ABSOLUTE.initial_values(TRUTH, A22)
    known, remain = ABSOLUTE.with_inertia_known(values)
    assert known.names == MODEL.names
    assert known.mechanism.inertia == pytest.approx(A22)
    assert np.array_equal(
        known.predict(values[remain], window.start, window), ABSOLUTE.predict(values, window.start, window)
    )


def test_motions_in_pieces_are_those_in_the_window():
    model, values = with_effects("encoder_offset.inner", "time_offset.outer")
    model, values = replace(model, inertia_free=True).with_zeros(np.insert(values, len(GROUPS), 1.0 / A22), [0])
    trial = standard_twin(np.random.default_rng(0))
    (window,) = cut_into_windows([replace(trial, cart=0.1 * np.sin(3 * trial.time))], np.inf)
    window = replace(window, weights=WEIGHTS)
    pieces, starts = window.in_pieces(150), np.tile(window.start, (14, 1))
    for k in range(1, len(starts)):
        starts[k] = model.motions_in(values, starts, window, pieces).ends[k - 1]
    found = model.motions_in(values, starts, window, pieces)
    np.testing.assert_allclose(found.readings, model.predict(values, window.start, window), rtol=0.0, atol=1e-5)
