# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.force_balance import DRY, MOMENT, NOT_DRY, Pieces, balance_of_forces, balances_of
from cdp_ident.trial.trial import Trial
from reference import pendulum
from reference.own_units import Rig
from reference.pendulum import TABLE_5
from scenarios.weighted import INERTIA, plain_and_weighted

SHARED = Path(__file__).parents[3] / "shared" / "data"
DROPS = SHARED / "dfki_drops"
SWING = SHARED / "multiarm_free_swing" / "free_swing_8s_56s_1kHz.csv.gz"
G = 9.81
PLAIN = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01)
STICKING = replace(PLAIN, dry1=0.02, dry2=0.03)
LOOKED_FOR = {effect.key: effect for effect in (*DRY, *NOT_DRY)}
GEARED, INNER, SPRING = (
    LOOKED_FOR[key] for key in ("geared_rotor.outer", "coulomb_friction.inner", "joint_spring.inner")
)


def chosen(trials, length=0.4):
    return balances_of(Pieces.of(trials, length, G))[0]


def strength(found, effect):
    (values,) = [values for other, values in found.found if other == effect]
    return values[0]


@pytest.mark.parametrize("length", [0.05, 0.4, 2.0])
@pytest.mark.parametrize(
    ("samples_per_unit", "noise", "percent"), [(4.3, 1e-4, 1.0), (40.0, 1e-3, 1.0), (100.0, 1e-2, 3.0)]
)
def test_the_groups_of_a_rig_of_any_size_come_from_nothing(
    measured, true_groups, length, samples_per_unit, noise, percent
):
    rate = samples_per_unit / np.sqrt(length / G)
    found = chosen([measured(length=length, rate=rate, noise=noise)], length)
    truth, _ = true_groups(PLAIN, length)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=percent / 100)
    assert found.effects == ()
    assert np.all(found.unexplained < 2 * found.noise_share + 1e-3)


@pytest.mark.parametrize("noise", [1e-5, 1e-3])
def test_dry_friction_of_joints_that_stick_is_found_with_them(measured, true_groups, noise):
    found = chosen([measured(STICKING, noise=noise)])
    truth, dry = true_groups(STICKING, 0.4)
    assert found.effects == DRY
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.02)
    assert [strength(found, effect) for effect in DRY] == pytest.approx(dry, rel=0.15)


def test_while_a_joint_sticks_its_own_balance_does_not_count(measured):
    moving, sticking = (chosen([measured(rig)]) for rig in (PLAIN, STICKING))
    assert sticking.rows[1] < 0.6 * moving.rows[1], "the outer joint sticks for a part of the motion"
    assert sticking.rows[0] > 0.8 * moving.rows[0], "the inner one seldom does, and its balance holds meanwhile"


def test_where_noise_hides_dry_friction_in_one_joint_the_balance_with_both_is_given_too(measured, true_groups):
    first, second = balances_of(Pieces.of([measured(STICKING, noise=5e-3)], 0.4, G))
    truth, dry = true_groups(STICKING, 0.4)
    assert first.effects == (DRY[1],)
    assert second.effects == DRY
    assert second.groups[:3] == pytest.approx(truth[:3], rel=0.03)
    assert [strength(second, effect) for effect in DRY] == pytest.approx(dry, rel=0.35)


def test_a_joint_that_never_slips_is_told(measured):
    locked = replace(PLAIN, dry2=50.0)
    with pytest.raises(IdentificationError, match="too little motion of the outer joint"):
        chosen([measured(locked, start=np.array([2.0, 2.0, 0.0, 0.0]))])


def test_a_joint_that_soon_comes_to_rest_leaves_a_pendulum(measured, true_groups):
    """Where it rests, inertias and weights that are all zero would explain the other joint's motion exactly."""
    soon_at_rest = replace(PLAIN, dry1=1.0)
    starts = (2.6, 0.5, 1.0, 3.5)
    found = chosen([measured(soon_at_rest, start=np.array([2.0, start, 0.0, 0.0]), noise=3e-4) for start in starts])
    truth, dry = true_groups(soon_at_rest, 0.4)
    assert found.rows[0] < 0.05 * found.rows[1]
    assert found.effects == (INNER,)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.01)
    assert strength(found, INNER) == pytest.approx(dry[0], rel=0.05)


@pytest.mark.parametrize(("start", "error"), [((2.0, 2.6, 0.0, 0.0), 0.02), ((2.4, 4.4, 0.0, 0.0), 0.01)])
def test_inertias_are_not_zero_where_the_inner_joint_soon_sticks_and_its_encoder_s_disc_is_off_its_axle(
    measured, true_groups, start, error
):
    """The outer rod's balance, of which nothing is known beforehand, holds for unknowns that are all zero, too."""
    sticking = replace(PLAIN, dry1=0.3)
    trial = measured(sticking, start=np.array(start), noise=5e-4, units=90.0)
    error = error * np.sin(trial.theta[:, :1] + 0.5)
    found = chosen([replace(trial, theta=trial.theta + error)])
    truth, dry = true_groups(sticking, 0.4)
    assert found.rows[0] < 0.1 * found.rows[1]
    assert INNER in found.effects
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.05)
    assert strength(found, INNER) == pytest.approx(dry[0], rel=0.06)


def test_many_short_trials_are_one_balance(measured, true_groups):
    starts = [np.array([2.0 + 0.3 * k, 2.6 - 0.5 * k, 0.0, 0.0]) for k in range(6)]
    found = chosen([measured(units=6.0, start=start) for start in starts])
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=0.02)


def test_what_is_left_tells_of_something_that_is_missing(measured):
    springy = replace(PLAIN, coupling=-0.06)
    pieces = Pieces.of([measured(springy)], 0.4, G)
    without = balance_of_forces(pieces)
    found = balances_of(pieces)[0]
    assert without.unexplained[1] > 5 * without.noise_share[1]
    assert found.effects == (GEARED,)
    assert np.all(found.unexplained < 1.5 * found.noise_share)
    assert strength(found, GEARED) == pytest.approx(-0.06, abs=3e-3)
    assert found.groups[:2] == pytest.approx([0.5, 0.4], rel=0.02)


def test_a_spring_across_a_joint_is_found_with_where_it_is_relaxed():
    A22, L = INERTIA, TABLE_5["L"]

    def torque(_, state):
        return A22 * (3.0 - 8.0 * (state[0] - np.pi)), 0.0

    time = np.arange(2000) * 0.005
    theta = pendulum.motion(TABLE_5, (2.0, 2.6, 0.0, 0.0), time, torque=torque, tolerance=1e-8)[:, :2]
    theta = theta + np.random.default_rng(0).normal(scale=3e-4, size=theta.shape)
    found = chosen([Trial("spring", time, theta)], L)
    assert found.effects == (SPRING,)
    assert found.names[-2:] == ("joint_spring.inner.stiffness", "joint_spring.inner.torque")
    assert found.values[-2:] == pytest.approx([8.0, 3.0], rel=0.05)


def test_unknowns_are_named_as_the_model_names_them(measured):
    effects = tuple(LOOKED_FOR[key] for key in ("geared_rotor.outer", "coulomb_friction.outer", "joint_spring.outer"))
    found = balance_of_forces(Pieces.of([measured()], 0.4, G), effects, length_free=True)
    assert found.names == (
        "A23_over_A22", "A33_over_A22", "a1_over_A22", "c1_over_A22", "c2_over_A22", MOMENT,
        "geared_rotor.outer.coupling",
        "coulomb_friction.outer.torque", "joint_spring.outer.stiffness", "joint_spring.outer.torque",
    )  # fmt: skip
    assert found.effects == effects
    assert np.array_equal(np.concatenate([values for _, values in found.found]), found.values[6:])


def test_only_what_may_be_negative_is_so(measured):
    frictionless = replace(PLAIN, c1=0.0, c2=0.0, coupling=-0.06)
    for seed in range(4):
        pieces = Pieces.of([measured(frictionless, noise=5e-3, seed=seed)], 0.4, G)
        found = balance_of_forces(pieces, (GEARED, *DRY))
        assert np.all(found.groups >= 0.0)
        assert all(strength(found, effect) >= 0.0 for effect in DRY)
        assert strength(found, GEARED) < -0.05


def test_a_length_that_is_not_known_well_is_found(measured):
    found = balance_of_forces(Pieces.of([measured(length=0.4, noise=1e-4)], 0.42, G), length_free=True)
    assert found.length == pytest.approx(0.4, rel=2e-3)
    assert found.values[found.names.index(MOMENT)] == pytest.approx(0.5 / 0.4, rel=5e-3)


def test_standard_deviations_are_those_of_the_errors_or_some_times_as_large(measured, true_groups):
    trials = [measured(noise=3e-3, units=30.0, seed=seed) for seed in range(12)]
    found = [balance_of_forces(Pieces.of([trial], 0.4, G)) for trial in trials]
    errors = np.array([one.groups for one in found]) - true_groups(PLAIN, 0.4)[0]
    claimed = np.sqrt(np.mean([np.diag(one.covariance) for one in found], axis=0))
    assert np.all(np.std(errors, axis=0) < claimed)
    assert np.all(np.std(errors, axis=0) > 0.08 * claimed)
    assert np.all(np.abs(errors) < 4.0 * claimed)


def test_the_cart_s_measured_motion_is_part_of_the_balance():
    m1, m2, m0, l1, l2, J1, J2, _, _, L, _ = TABLE_5.values()
    A22 = m1 * l1**2 + J1 + (m2 + m0) * L**2
    time = np.arange(1400) * 0.005
    cart = 0.03 * sympy.sin(9 * pendulum.TIME)
    theta = pendulum.motion(TABLE_5, (2.0, 2.6, 0.0, 0.0), time, cart, tolerance=1e-8)[:, :2]
    found = chosen([Trial("driven", time, theta, pendulum.cart_position(cart, time))], L)
    truth = np.array([m2 * L * l2, m2 * l2**2 + J2, m1 * l1 + (m2 + m0) * L]) / A22
    assert found.groups[:3] == pytest.approx(truth, rel=5e-3)


def test_weights_show_the_inertia_about_the_cart_s_joint():
    plain, weighted = plain_and_weighted(np.random.default_rng(3))
    found = chosen([plain, weighted], TABLE_5["L"])
    assert found.inertia == pytest.approx(INERTIA, rel=0.06)
    own = chosen([replace(weighted, weights=())], TABLE_5["L"])
    assert own.inertia is None
    assert found.groups[0] < 0.9 * own.groups[0]


def test_lost_frames_are_no_obstacle(measured, true_groups):
    trial = measured(rate=300.0)
    kept = np.random.default_rng(3).uniform(size=len(trial.time)) > 0.1
    found = chosen([Trial("film", trial.time[kept], trial.theta[kept])])
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=0.01)


def test_an_impulse_loses_its_weight(measured, true_groups):
    trial = measured(rate=300.0)
    theta = trial.theta.copy()
    theta[700:705] += 0.2
    found = chosen([replace(trial, theta=theta)])
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=0.05)


def test_what_comes_out_is_a_mechanism_whatever_goes_in():
    rng = np.random.default_rng(1)
    time = np.arange(2000) / 200.0
    wandering = np.cumsum(np.cumsum(rng.normal(scale=1e-3, size=(2000, 2)), axis=0), axis=0)
    found = chosen([Trial("nonsense", time, wandering)])
    A23, A33 = found.groups[:2]
    assert A33 > A23**2
    assert np.all(found.groups >= 0)
    assert np.max(found.unexplained) > 0.1


@pytest.mark.parametrize("units", [1.0, 2.0, 4.0])
def test_too_little_motion_is_told(measured, units):
    with pytest.raises(IdentificationError, match="too little motion of the inner joint"):
        chosen([measured(units=units)])


def test_the_same_trials_give_the_same_result(measured):
    one, other = (chosen([measured()]) for _ in range(2))
    assert np.array_equal(one.values, other.values)


@pytest.mark.skipif(not DROPS.exists(), reason=f"the measured drops are not at {DROPS}")
def test_the_dry_friction_and_the_coupling_of_geared_drives_are_found():
    trials = []
    for number in (1, 2, 3):
        time, inner, outer = np.loadtxt(DROPS / f"drop{number}.csv.gz", delimiter=",", skiprows=1, usecols=(0, 1, 2)).T
        theta = np.column_stack([inner, inner + outer]) + np.pi
        trials.append(Trial(f"drop{number}", time[time > 5.0], theta[time > 5.0]))
    first, second = balances_of(Pieces.of(trials, 0.3, G))
    inertia = 0.608 * 0.275**2 + 0.00875 + 0.63 * 0.3**2  # from the rig's drawings
    assert first.effects == (GEARED, DRY[1])
    assert second.effects == (GEARED, *DRY)
    assert strength(second, DRY[0]) * inertia == pytest.approx(0.07, abs=0.05)
    for found in (first, second):
        assert strength(found, DRY[1]) * inertia == pytest.approx(0.09, abs=0.015)
        assert found.groups[:2] == pytest.approx([0.28, 0.24], abs=0.02)
        assert strength(found, GEARED) == pytest.approx(-0.045, abs=0.015)


@pytest.mark.skipif(not SWING.exists(), reason=f"the measured free swing is not at {SWING}")
def test_the_published_groups_of_a_measured_swing_are_found():
    time, theta1, theta2 = np.loadtxt(SWING, delimiter=",", skiprows=1, usecols=(0, 1, 2))[::5].T
    found = chosen([Trial("swing", time - time[0], np.column_stack([theta1, theta2]))], 0.17272)
    assert [*found.groups[:2], G * found.groups[2]] == pytest.approx([0.4914, 0.5563, 58.94], rel=5e-3)
