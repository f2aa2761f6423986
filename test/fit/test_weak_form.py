import numpy as np
import pytest
from scipy.ndimage import minimum_filter1d
from scipy.signal import lfilter

from cdp_ident.fit import weak_form
from cdp_ident.fit.smoothing import smooth
from cdp_ident.fit.weak_form import Kinematics, Term, Windows
from reference.own_units import Rig, motion

START = np.array([2.0, 2.6, 0.0, 0.0])
TIME = np.arange(1600) * 0.025
STICKING = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01, dry1=0.02, dry2=0.05)


def kinematics(rig, noise=0.0):
    samples = motion(rig, START, TIME)[:, :2]
    rng = np.random.default_rng(1)
    smoothed = smooth(TIME, samples + rng.normal(scale=noise, size=samples.shape), 0.025, 2, rng)
    return smoothed, Kinematics.of(smoothed)


def test_a_derivative_is_integrated_by_parts():
    windows = Windows.of(0.5, 0.01)
    time = np.arange(500) * 0.01
    (of_sine, of_cosine), shape = (np.sin(time)[None], np.cos(time)[None]), (1, 500)
    by_parts = windows.integrate([Term(momentum=(of_sine, 0.0))], shape)
    directly = windows.integrate([Term(torque=(of_cosine, 0.0))], shape)
    assert by_parts == pytest.approx(directly, abs=1e-5)


def test_the_balance_holds_along_a_motion_and_term_by_term_with_its_rig():
    rig = Rig(A23=0.5, A33=0.4, a1=1.4, c1=0.02, c2=0.01, coupling=0.05)
    smoothed, k = kinematics(rig)
    terms = [
        weak_form.coupling(k).plus(weak_form.moment_of_outer_rod(k, 1.0), 1.0),
        weak_form.inertia_of_outer_rod(k),
        weak_form.moment_of_inner_rod(k, 1.0),
        weak_form.joint_torques(k.joint_speeds[0], 0.0),
        weak_form.joint_torques(0.0, k.joint_speeds[1]),
        weak_form.constant_coupling(k),
    ]
    nowhere = np.zeros(len(smoothed.time), dtype=bool)
    rows = weak_form.rows(
        Windows.of(0.5, 0.025), smoothed.known, terms, weak_form.inertia_of_inner_rod(k), (nowhere, nowhere)
    )
    left = rows.columns[0] @ [0.5, 0.4, 1.4, 0.02, 0.01, 0.05] - rows.target[0]
    assert np.abs(left[rows.holds]).max() < 1e-3
    assert np.std(rows.target[0, :, 0]) > 0.1


def test_a_joint_that_sticks_is_seen_to_rest_and_no_other():
    smoothed, k = kinematics(STICKING, noise=1e-3)
    speeds = motion(STICKING, START, smoothed.time)[:, 2:] @ np.array([[1.0, -1.0], [0.0, 1.0]])
    for joint in range(2):
        stuck = minimum_filter1d(np.abs(speeds[:, joint]) < 1e-9, 41)  # for a time unit at least
        rests = weak_form.at_rest(k, joint, 40)
        assert np.all(rests[stuck])
        assert np.mean(rests[np.abs(speeds[:, joint]) > 0.1]) < 0.02


@pytest.mark.parametrize("rest", [0.0, 0.97])
def test_a_joint_that_rests_for_most_of_a_recording_does_so_though_its_noise_has_a_memory(rest):
    moving = 20.0
    count = round(moving / (1.0 - rest) / 0.025)
    time = 0.025 * np.arange(count)
    swing = np.where(time < moving, np.sin(3.0 * time) * np.cos(0.5 * np.pi * np.minimum(time / moving, 1.0)), 0.0)
    noise = 1e-4 * lfilter([1.0], [1.0, -0.8], np.random.default_rng(0).normal(size=(count, 2)), axis=0)
    smoothed = smooth(time, swing[:, None] + noise, 0.025, 2, np.random.default_rng(1))
    rests = weak_form.at_rest(Kinematics.of(smoothed), 0, 40)
    assert np.all(rests[smoothed.time > moving + 1.0])
    assert np.mean(rests[smoothed.time < moving - 1.0]) < 0.05


def test_the_direction_of_slip_is_sure_where_a_joint_is_fast():
    _, k = kinematics(STICKING, noise=1e-2)
    direction = weak_form.slip_direction(k, 0)[0]
    fast = np.abs(k.w1[0]) > 0.5
    assert np.allclose(direction[fast], np.sign(k.w1[0][fast]), atol=1e-3)
    assert np.abs(direction).min() < 0.3
