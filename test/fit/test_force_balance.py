from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from cdp_ident.errors import IdentificationError
from cdp_ident.fit.balance_unknowns import DRY
from cdp_ident.fit.force_balance import balance_of_forces
from cdp_ident.model.effects.catalogue import CATALOGUE
from cdp_ident.model.parameters import physical_coefficients
from cdp_ident.model.simulation import simulate
from cdp_ident.model.time_grid import TimeGrid
from cdp_ident.trial.trial import Trial
from reference.own_units import Rig
from reference.pendulum import TABLE_5

SHARED = Path(__file__).parents[3] / "shared" / "data"
DROPS = SHARED / "dfki_drops"
SWING = SHARED / "multiarm_free_swing" / "free_swing_8s_56s_1kHz.csv.gz"
G = 9.81
PLAIN = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01)
STICKING = replace(PLAIN, dry1=0.02, dry2=0.03)
EFFECTS = {effect.key: effect for effect in CATALOGUE}
GEARED, INNER = EFFECTS["geared_rotor.outer"], EFFECTS["coulomb_friction.inner"]


@pytest.mark.parametrize("length", [0.05, 0.4, 2.0])
@pytest.mark.parametrize(
    ("samples_per_unit", "noise", "percent"), [(4.3, 1e-4, 1.0), (40.0, 1e-3, 1.0), (100.0, 1e-2, 3.0)]
)
def test_the_groups_of_a_rig_of_any_size_come_from_nothing(
    measured, true_groups, length, samples_per_unit, noise, percent
):
    rate = samples_per_unit / np.sqrt(length / G)
    found = balance_of_forces([measured(length=length, rate=rate, noise=noise)], length, G)
    truth, _ = true_groups(PLAIN, length)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=percent / 100)
    assert found.effects == () or noise > 1e-3
    assert np.all(found.unexplained < 2 * found.noise_share + 1e-3)


@pytest.mark.parametrize("noise", [1e-5, 1e-3, 5e-3])
def test_dry_friction_of_joints_that_stick_is_found_with_them(measured, true_groups, noise):
    found = balance_of_forces([measured(STICKING, noise=noise)], 0.4, G)
    truth, dry = true_groups(STICKING, 0.4)
    assert found.effects == DRY
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.02)
    assert [found.strengths(effect)[0] for effect in DRY] == pytest.approx(dry, rel=0.15)
    assert found.used[1] < 0.9, "the outer joint sticks for a part of the motion"


def test_a_joint_that_never_slips_is_told(measured):
    locked = replace(PLAIN, dry2=50.0)
    with pytest.raises(IdentificationError, match="the outer joint does not move"):
        balance_of_forces([measured(locked, start=np.array([2.0, 2.0, 0.0, 0.0]))], 0.4, G)


def test_a_joint_that_soon_comes_to_rest_leaves_a_pendulum(measured, true_groups):
    """Where it rests, inertias and weights that are all zero would explain the other joint's motion exactly."""
    soon_at_rest = replace(PLAIN, dry1=1.2)
    trials = [measured(soon_at_rest, start=np.array([2.0, start, 0.0, 0.0]), noise=3e-4) for start in (2.6, 0.5)]
    found = balance_of_forces(trials, 0.4, G, effects=[GEARED])
    truth, dry = true_groups(soon_at_rest, 0.4)
    assert found.effects == (GEARED, INNER)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.05)
    assert found.strengths(INNER)[0] == pytest.approx(dry[0], rel=0.15)


@pytest.mark.parametrize("start", [(2.0, 2.6, 0.0, 0.0), (2.4, 4.4, 0.0, 0.0)])
def test_inertias_are_not_zero_where_the_inner_joint_soon_sticks_and_its_encoder_s_disc_is_off_its_axle(
    measured, true_groups, start
):
    """The outer rod's balance, of which nothing is known beforehand, holds for unknowns that are all zero, too."""
    sticking = replace(PLAIN, dry1=0.3)
    trial = measured(sticking, start=np.array(start), noise=5e-4, units=90.0)
    error = 0.04 * np.sin(trial.theta[:, :1] + 0.5)
    found = balance_of_forces([replace(trial, theta=trial.theta + error)], 0.4, G)
    truth, dry = true_groups(sticking, 0.4)
    assert found.used[0] < 0.05
    assert found.effects == (INNER,)
    assert found.groups[:3] == pytest.approx(truth[:3], rel=0.05)
    assert found.strengths(INNER)[0] == pytest.approx(dry[0], rel=0.06)


def test_many_short_trials_are_one_balance(measured, true_groups):
    starts = [np.array([2.0 + 0.3 * k, 2.6 - 0.5 * k, 0.0, 0.0]) for k in range(6)]
    found = balance_of_forces([measured(units=6.0, start=start) for start in starts], 0.4, G)
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=0.02)


def test_what_is_left_tells_of_something_that_is_missing(measured):
    springy = replace(PLAIN, coupling=-0.06)
    without = balance_of_forces([measured(springy)], 0.4, G)
    found = balance_of_forces([measured(springy)], 0.4, G, effects=[GEARED])
    assert without.unexplained[1] > 5 * without.noise_share[1]
    assert np.all(found.unexplained < 1.5 * found.noise_share)
    assert found.strengths(GEARED)[0] == pytest.approx(-0.06, abs=3e-3)
    assert found.groups[:2] == pytest.approx([0.5, 0.4], rel=0.02)


@pytest.mark.parametrize(
    ("rig", "key", "name", "value"),
    [
        (replace(PLAIN, tilt=0.02), "gravity_tilt.base", "gravity_tilt.base.tilt", 0.02),
        (replace(PLAIN, square2=0.02), "quadratic_friction.outer", "quadratic_friction.outer.coefficient", 0.02),
    ],
)
def test_other_effects_are_found_on_request(measured, rig, key, name, value):
    found = balance_of_forces([measured(rig, rate=400.0, noise=3e-4)], 0.4, G, effects=[EFFECTS[key]], optional=())
    assert found.value(name) == pytest.approx(value, rel=0.1)


def test_a_length_that_is_not_known_well_is_found(measured):
    trial = measured(length=0.4, noise=1e-4)
    found = balance_of_forces([trial], 0.42, G, length_free=True, optional=())
    assert found.length == pytest.approx(0.4, rel=2e-3)
    assert found.value("m2_l2_over_A22") == pytest.approx(0.5 / 0.4, rel=5e-3)


def test_the_cart_s_measured_motion_is_part_of_the_balance():
    coefficients = physical_coefficients(TABLE_5)
    time = np.arange(2400) * 0.005
    frequency, amplitude = 9.0, 0.03
    u = -amplitude * frequency**2 * np.sin(frequency * TimeGrid.over(time, 0.005).half_step_times())
    theta = simulate(coefficients, np.array([2.0, 2.6, 0.0, 0.0]), time, u)[:, :2]
    cart = amplitude * np.sin(frequency * time)
    found = balance_of_forces([Trial("driven", time, theta, cart)], TABLE_5["L"], G)
    assert found.groups[:3] == pytest.approx(coefficients[:3], rel=5e-3)


def test_lost_frames_are_no_obstacle(measured, true_groups):
    trial = measured(rate=300.0)
    kept = np.random.default_rng(3).uniform(size=len(trial.time)) > 0.1
    found = balance_of_forces([Trial("film", trial.time[kept], trial.theta[kept])], 0.4, G)
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=0.01)


def test_an_impulse_loses_its_weight(measured, true_groups):
    trial = measured(rate=300.0)
    theta = trial.theta.copy()
    theta[700:705] += 0.2
    found = balance_of_forces([replace(trial, theta=theta)], 0.4, G)
    assert found.groups[:3] == pytest.approx(true_groups(PLAIN, 0.4)[0][:3], rel=0.05)


def test_what_comes_out_is_a_mechanism_whatever_goes_in():
    rng = np.random.default_rng(1)
    time = np.arange(2000) / 200.0
    wandering = np.cumsum(np.cumsum(rng.normal(scale=1e-3, size=(2000, 2)), axis=0), axis=0)
    found = balance_of_forces([Trial("nonsense", time, wandering)], 0.4, G)
    A23, A33 = found.groups[:2]
    assert A33 > A23**2
    assert np.all(found.groups >= 0)
    assert np.max(found.unexplained) > 0.1


def test_too_little_motion_is_told_with_what_is_needed(measured):
    with pytest.raises(IdentificationError, match=r"some \d+\.\d s are needed"):
        balance_of_forces([measured(units=2.0)], 0.4, G)


def test_the_same_trials_give_the_same_result(measured):
    one, other = (balance_of_forces([measured()], 0.4, G) for _ in range(2))
    assert np.array_equal(one.values, other.values)


@pytest.mark.skipif(not DROPS.exists(), reason=f"the measured drops are not at {DROPS}")
def test_the_dry_friction_and_the_coupling_of_geared_drives_are_found():
    trials = []
    for number in (1, 2, 3):
        time, inner, outer = np.loadtxt(DROPS / f"drop{number}.csv.gz", delimiter=",", skiprows=1, usecols=(0, 1, 2)).T
        theta = np.column_stack([inner, inner + outer]) + np.pi
        trials.append(Trial(f"drop{number}", time[time > 5.0], theta[time > 5.0]))
    found = balance_of_forces(trials, 0.3, G, effects=[GEARED])
    inertia = 0.608 * 0.275**2 + 0.00875 + 0.63 * 0.3**2  # from the rig's drawings
    assert found.effects == (GEARED, *DRY)
    assert found.strengths(DRY[0])[0] * inertia == pytest.approx(0.07, abs=0.025)
    assert found.strengths(DRY[1])[0] * inertia == pytest.approx(0.09, abs=0.015)
    assert found.groups[:2] == pytest.approx([0.28, 0.24], abs=0.02)
    assert found.strengths(GEARED)[0] == pytest.approx(-0.045, abs=0.015)


@pytest.mark.skipif(not SWING.exists(), reason=f"the measured free swing is not at {SWING}")
def test_the_published_groups_of_a_measured_swing_are_found():
    time, theta1, theta2 = np.loadtxt(SWING, delimiter=",", skiprows=1, usecols=(0, 1, 2))[::5].T
    found = balance_of_forces([Trial("swing", time - time[0], np.column_stack([theta1, theta2]))], 0.17272, G)
    assert [*found.groups[:2], G * found.groups[2]] == pytest.approx([0.4914, 0.5563, 58.94], rel=5e-3)
