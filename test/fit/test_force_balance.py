# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import sympy

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.force_balance import Pieces, balance_of_forces
from cdp_ident.trial.trial import Trial
from reference import pendulum
from reference.own_units import Rig
from reference.pendulum import TABLE_5
from scenarios.paper_rig import GROUPS
from scenarios.twin import twin
from scenarios.weighted import INERTIA, plain_and_weighted

SHARED = Path(__file__).parents[3] / "shared" / "data"
SWING = SHARED / "multiarm_free_swing" / "free_swing_8s_56s_1kHz.csv.gz"
G = 9.81
PLAIN = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01)
STICKING = replace(PLAIN, dry1=0.02, dry2=0.03)


def balanced(trials, length=0.4, length_free=False):
    return balance_of_forces(Pieces.of(trials, length, G), length_free)


@pytest.mark.parametrize("length", [0.05, 0.4, 2.0])
@pytest.mark.parametrize(
    ("samples_per_unit", "noise", "percent"), [(4.3, 1e-4, 1.0), (40.0, 1e-3, 1.0), (100.0, 1e-2, 3.0)]
)
def test_the_groups_of_a_rig_of_any_size_come_from_nothing(
    measured, true_groups, length, samples_per_unit, noise, percent
):
    rate = samples_per_unit / np.sqrt(length / G)
    found = balanced([measured(length=length, rate=rate, noise=noise)], length)
    truth, _ = true_groups(PLAIN, length)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=percent / 100)


@pytest.mark.parametrize(("noise", "percent"), [(1e-5, 15), (1e-3, 15), (5e-3, 35)])
def test_dry_friction_of_joints_that_stick_is_found_with_them(measured, true_groups, noise, percent):
    found = balanced([measured(STICKING, noise=noise)])
    truth, dry = true_groups(STICKING, 0.4)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.03)
    assert found.dry_friction == pytest.approx(dry, rel=percent / 100)


def test_a_joint_that_never_slips_is_told(measured):
    locked = replace(PLAIN, dry2=50.0)
    with pytest.raises(IdentificationError, match="too little motion of the outer joint"):
        balanced([measured(locked, start=np.array([2.0, 2.0, 0.0, 0.0]))])


def test_a_joint_that_soon_comes_to_rest_leaves_a_pendulum(measured, true_groups):
    """Where it rests, inertias and weights that are all zero would explain the other joint's motion exactly."""
    soon_at_rest = replace(PLAIN, dry1=1.0)
    starts = (2.6, 0.5, 1.0, 3.5)
    found = balanced([measured(soon_at_rest, start=np.array([2.0, start, 0.0, 0.0]), noise=3e-4) for start in starts])
    truth, dry = true_groups(soon_at_rest, 0.4)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.01)
    assert found.dry_friction[0] == pytest.approx(dry[0], rel=0.05)


@pytest.mark.parametrize(("start", "error"), [((2.0, 2.6, 0.0, 0.0), 0.02), ((2.4, 4.4, 0.0, 0.0), 0.01)])
def test_inertias_are_not_zero_where_the_inner_joint_soon_sticks_and_its_encoder_s_disc_is_off_its_axle(
    measured, true_groups, start, error
):
    """The outer rod's balance, of which nothing is known beforehand, holds for unknowns that are all zero, too."""
    sticking = replace(PLAIN, dry1=0.3)
    trial = measured(sticking, start=np.array(start), noise=5e-4, units=90.0)
    error = error * np.sin(trial.theta[:, :1] + 0.5)
    found = balanced([replace(trial, theta=trial.theta + error)])
    truth, dry = true_groups(sticking, 0.4)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.1)
    assert found.dry_friction[0] == pytest.approx(dry[0], rel=0.1)


def short(measured):
    return [measured(units=6.0, start=np.array([2.0 + 0.3 * k, 2.6 - 0.5 * k, 0.0, 0.0])) for k in range(6)]


def with_lost_frames(measured):
    trial = measured(rate=300.0)
    kept = np.random.default_rng(3).uniform(size=len(trial.time)) > 0.1
    return [Trial("film", trial.time[kept], trial.theta[kept])]


def with_an_impulse(measured):
    trial = measured(rate=300.0)
    trial.theta[700:705] += 0.2
    return [trial]


@pytest.mark.parametrize(("trials", "percent"), [(short, 2), (with_lost_frames, 1), (with_an_impulse, 5)])
def test_many_short_trials_lost_frames_and_an_impulse_are_no_obstacle(measured, true_groups, trials, percent):
    found = balanced(trials(measured))
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=percent / 100)


def test_no_inertia_moment_or_friction_is_negative_and_what_is_missing_is_left(measured):
    frictionless = replace(PLAIN, c1=0.0, c2=0.0, coupling=-0.06)
    for seed in range(4):
        found = balanced([measured(frictionless, noise=5e-3, seed=seed)])
        assert np.all(found.groups >= 0.0)
        assert np.all(found.dry_friction >= 0.0)
        assert np.max(found.unexplained) > 2.0 * np.max(balanced([measured(noise=5e-3, seed=seed)]).unexplained)


def test_a_length_that_is_not_known_well_is_found(measured):
    found = balanced([measured(length=0.4, noise=1e-4)], 0.42, length_free=True)
    assert found.length == pytest.approx(0.4, rel=2e-3)


def test_the_cart_s_measured_motion_is_part_of_the_balance():
    time = np.arange(1400) * 0.005
    cart = 0.03 * sympy.sin(9 * pendulum.TIME)
    exact = {"noise": 0.0, "counts_per_turn": None, "tolerance": 1e-8}
    found = balanced([twin(np.random.default_rng(0), TABLE_5, (2.0, 2.6, 0.0, 0.0), time, cart=cart, **exact)])
    assert found.groups[:3] == pytest.approx(GROUPS[:3], rel=5e-3)


def test_weights_show_the_inertia_about_the_cart_s_joint():
    plain, weighted = plain_and_weighted(np.random.default_rng(3))
    found = balanced([plain, weighted])
    assert found.inertia == pytest.approx(INERTIA, rel=0.06)
    own = balanced([replace(weighted, weights=())])
    assert own.inertia is None
    assert found.groups[0] < 0.9 * own.groups[0]


def test_what_comes_out_is_a_mechanism_whatever_goes_in():
    rng = np.random.default_rng(1)
    time = np.arange(2000) / 200.0
    wandering = np.cumsum(np.cumsum(rng.normal(scale=1e-3, size=(2000, 2)), axis=0), axis=0)
    found = balanced([Trial("nonsense", time, wandering)])
    A23, A33 = found.groups[:2]
    assert A33 > A23**2
    assert np.all(found.groups >= 0)
    assert np.max(found.unexplained) > 0.1


@pytest.mark.parametrize("units", [1.0, 2.0, 4.0])
def test_too_little_motion_is_told(measured, units):
    with pytest.raises(IdentificationError, match="too little motion of the inner joint"):
        balanced([measured(units=units)])


def test_the_same_trials_give_the_same_result(measured):
    one, other = (balanced([measured()]) for _ in range(2))
    assert np.array_equal(one.groups, other.groups)


@pytest.mark.skipif(not SWING.exists(), reason=f"the measured free swing is not at {SWING}")
def test_the_published_groups_of_a_measured_swing_are_found():
    time, theta1, theta2 = np.loadtxt(SWING, delimiter=",", skiprows=1, usecols=(0, 1, 2))[::5].T
    found = balanced([Trial("swing", time - time[0], np.column_stack([theta1, theta2]))], 0.17272)
    assert [*found.groups[:2], G * found.groups[2]] == pytest.approx([0.4914, 0.5563, 58.94], rel=5e-3)
