# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What is not a free double pendulum's motion is said, and free swings are taken whatever their motors measure."""

import contextlib
import tracemalloc
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import sympy
from scipy.integrate import solve_ivp

from cdp_ident.errors import OtherMotionError, TrialError
from cdp_ident.trial.find import CART, FREE, GAP, HAND, REST, Part, choose_parts, find_trial
from cdp_ident.trial.joints import Samples
from cdp_ident.trial.meaning import balance_of
from cdp_ident.trial.mechanisms import unexplained_beside
from cdp_ident.trial.options import UNITS, TrialOptions
from cdp_ident.trial.recorded_motion import recorded_motion
from reference.pendulum import TABLE_5, TIME, cart_position, motion
from reference.truths import truth

HANGING = TrialOptions(zero="hanging", outer_angle="absolute")
STEP = 0.01
TIMES = np.arange(0.0, 10.0, STEP)
A23, A33, G1, G2, INERTIA = 0.3, 0.25, 30.0, 10.0, 0.05


@cache
def pendulum(gravity=40.0, friction=0.2, start=2.0):
    """Return the angle of one pendulum (n,), from hanging."""
    found = solve_ivp(
        lambda _, y: [y[1], -gravity * np.sin(y[0]) - friction * y[1]], (0, 10), [start, 0], t_eval=TIMES, rtol=1e-9
    )
    return found.y[0]


def by_motors(time):
    return 0.6 * np.sin(3.1 * time), 0.3 * np.cos(4.3 * time)


@cache
def double_pendulum(torques=lambda _: (0.0, 0.0), start=(2.0, -1.0)):
    """Return the angles of both rods (n, 2), from hanging, with torques [N m] in the joints."""

    def rates(time, state):
        theta, omega = state[:2], state[2:]
        inner, outer = np.array(torques(time)) / INERTIA - 0.1 * np.array([omega[0], omega[1] - omega[0]])
        s, c = np.sin(theta[0] - theta[1]), np.cos(theta[0] - theta[1])
        mass = np.array([[1.0, A23 * c], [A23 * c, A33]])
        force = [-G1 * np.sin(theta[0]) - A23 * s * omega[1] ** 2 + inner - outer,
                 -G2 * np.sin(theta[1]) + A23 * s * omega[0] ** 2 + outer]  # fmt: skip
        return np.concatenate([omega, np.linalg.solve(mass, force)])

    return solve_ivp(rates, (0, 10), [*start, 0, 0], t_eval=TIMES, rtol=1e-8, atol=1e-8).y[:2].T


def samples(angles, torques=None, noise=1e-3):
    """Return samples of two columns (n, 2), with noise."""
    stamps = np.arange(len(TIMES)) * round(STEP * 1e9)
    return Samples(stamps, angles + noise * np.random.default_rng(1).normal(size=(len(TIMES), 2)), None, torques)


def cart_and_pole():
    """Return the position of a cart that is free and the angle of its pendulum (n, 2), from upright."""

    def rates(_, state):
        _, angle, speed, omega = state
        mass = [[1.3, 0.09 * np.cos(angle)], [0.09 * np.cos(angle), 0.0324]]
        force = [0.09 * omega**2 * np.sin(angle) - 0.1 * speed, 0.883 * np.sin(angle) - 0.002 * omega]
        return [speed, omega, *np.linalg.solve(mass, force)]

    return solve_ivp(rates, (0, 10), [0, 2.2, 0, 0], t_eval=TIMES, rtol=1e-9, atol=1e-9).y[:2].T


def furuta():
    """Return the angles of an arm about an upright axis and of its pendulum (n, 2), from upright."""

    def rates(_, state):
        _, angle, turning, omega = state
        s, c = np.sin(angle), np.cos(angle)
        mass = [[0.014 + 0.00225 * s * s, 0.003 * c], [0.003 * c, 0.0029]]
        force = [
            -0.0045 * s * c * turning * omega + 0.003 * s * omega**2 - 0.003 * turning,
            0.00225 * s * c * turning**2 + 0.147 * s - 0.0003 * omega,
        ]
        return [turning, omega, *np.linalg.solve(mass, force)]

    return solve_ivp(rates, (0, 10), [0, 2.2, 0, 0], t_eval=TIMES, rtol=1e-9, atol=1e-9).y[:2].T


STEPS = np.floor(TIMES / 5.0)
CASES = {
    "a column that is still": (lambda: (0 * pendulum(), pendulum()), "the inner joint does not turn"),
    "a packet number": (lambda: (pendulum(), STEPS), "no double pendulum"),
    "a counter of rows": (lambda: (TIMES / STEP * 1e-3, pendulum()), "the inner joint does not turn"),
    "one angle twice": (lambda: (pendulum(), pendulum()), "follows the inner one|does not turn"),
    "measured and simulated": (lambda: (pendulum(), pendulum(42.0, 0.25)), "one pendulum .* beside something else"),
    "a cart and its pendulum": (lambda: (pendulum(), 0.1 * np.sin(1.3 * TIMES)), "no double pendulum"),
    "an angle and its speed": (
        lambda: (pendulum(), np.gradient(pendulum(), STEP)),
        r"one joint's angle \(the inner column\) and its speed",
    ),
    "coordinates": (
        lambda: (0.3 * np.sin(pendulum()), -0.3 * np.cos(pendulum())),
        "x and y of a point on a circle of 0.3",
    ),
    "a duty cycle": (lambda: (np.sign(np.sin(2 * TIMES)), pendulum()), "no|not that of a free"),
}
"""Columns, computed when they are asked for, and what is said of them."""


def recorded(case):
    return samples(np.column_stack(CASES[case][0]()))


@pytest.mark.parametrize("outer_angle", ["absolute", "relative"])
@pytest.mark.parametrize("case", CASES)
def test_what_is_no_double_pendulum_is_refused_whatever_the_angles_mean(case, outer_angle):
    with pytest.raises(TrialError, match=CASES[case][1]):
        find_trial(recorded(case), replace(HANGING, outer_angle=outer_angle))


def held(cart, angle, start=3.0, drag=0.0):
    """Return the position of a cart that goes as its drive asks (n,) and the angle of its pendulum, from upright."""

    def rates(time, state):
        friction = (0.08 + drag * abs(state[1])) * state[1]
        return [state[1], 24.5 * np.sin(state[0]) - 2.5 * np.cos(state[0]) * angle(time) - friction]

    swings = solve_ivp(rates, (0, 15), [start, 0], t_eval=TIMES, rtol=1e-9, atol=1e-9).y[0]
    return np.column_stack([cart(TIMES), swings])


def driven_cart():
    return held(
        lambda t: -0.2 * np.sin(3.0 * t) - 0.1 * np.cos(5.5 * t),
        lambda t: 1.8 * np.sin(3.0 * t) + 3.025 * np.cos(5.5 * t),
    )


@pytest.mark.parametrize("exchanged", [False, True])
@pytest.mark.parametrize(
    ("other", "pivot"),
    [(cart_and_pole, "on a cart"), (driven_cart, "on a cart"), (furuta, "on an? (cart .or an )?arm")],
)
def test_one_pendulum_is_told_by_how_its_pivot_moves_whoever_drives_that(other, pivot, exchanged):
    joint = "inner" if exchanged else "outer"
    with pytest.raises(OtherMotionError, match=rf"one pendulum \(the {joint} column\) {pivot}"):
        find_trial(samples(other()[:, ::-1] if exchanged else other()), TrialOptions())


@pytest.mark.parametrize("outer_angle", ["absolute", "relative"])
@pytest.mark.parametrize("drag", [0.2, 0.5])
def test_a_driven_cart_s_pendulum_with_drag_is_no_double_one_of_which_little_is_unexplained(drag, outer_angle):
    columns = held(
        lambda t: 0.25 * np.sin(2.1 * t) + 0.08 * np.sin(4.7 * t),
        lambda t: -1.1025 * np.sin(2.1 * t) - 1.7672 * np.sin(4.7 * t),
        start=1.0,
        drag=drag,
    )[:, ::-1]
    with pytest.raises(OtherMotionError, match=r"one pendulum \(the inner column\) on a"):
        find_trial(samples(columns), TrialOptions(outer_angle=outer_angle))


@pytest.mark.parametrize("exchanged", [False, True])
@pytest.mark.parametrize("other", [cart_and_pole, driven_cart])
@pytest.mark.parametrize(("length", "angle"), [(1e3, "radians"), (2e4, "radians"), (1.0, "degrees"), (1e3, "degrees")])
def test_a_cart_s_pendulum_is_told_in_any_unit_of_the_angle_and_of_the_way(other, exchanged, length, angle):
    columns = samples(other(), noise=1e-4).angles * [length, 1.0 / UNITS[angle]]
    joint = "inner" if exchanged else "outer"
    with pytest.raises(OtherMotionError, match=rf"one pendulum \(the {joint} column\) on a cart.*\({angle}\)"):
        find_trial(samples(columns[:, ::-1] if exchanged else columns, noise=0.0), TrialOptions())


@pytest.mark.parametrize(("torques", "joint"), [((0.8, 0.0), "inner"), ((0.0, 0.4), "outer")])
def test_whichever_joint_a_motor_without_a_record_drives_the_other_equation_holds(torques, joint):
    angles = double_pendulum(lambda time: np.array(torques) * np.sin(3.1 * time + 0.4))
    balance = balance_of(recorded_motion(samples(angles), HANGING), HANGING)
    left = {of: unexplained_beside(balance.trusted, of) for of in ("inner", "outer")}
    assert left.pop(joint) < 0.003
    assert balance.lumped.unexplained > 0.02
    assert min(left.values()) > 0.01


def test_it_is_taken_all_the_same_where_the_user_insists():
    with pytest.raises(OtherMotionError, match="conventions: warn takes"):
        find_trial(recorded("measured and simulated"), HANGING)
    found = find_trial(recorded("measured and simulated"), replace(HANGING, conventions="warn"))
    assert "no double pendulum" in found.warnings[0]


@pytest.mark.parametrize("wobble", [0.0, 1e-4, 3e-3])
def test_a_still_joint_is_refused_at_once_even_where_the_user_insists(wobble):
    still = 0.1 + wobble * np.sin(3.0 * TIMES)
    with pytest.raises(OtherMotionError, match="the inner joint does not turn while the other does"):
        find_trial(samples(np.column_stack([still, pendulum()])), replace(HANGING, conventions="warn"))


def test_a_free_swing_is_taken_whatever_efforts_its_motors_measure():
    angles = double_pendulum()
    noise = np.random.default_rng(2).normal(size=angles.shape)
    plain = find_trial(samples(angles), HANGING)
    for torques in (noise, 1e3 * noise, np.gradient(angles, axis=0)):
        found = find_trial(samples(angles, torques), HANGING)
        assert found.trial.duration == plain.trial.duration
        assert found.balance.lumped.values[0] == pytest.approx(A23, abs=0.01)


@pytest.mark.parametrize("unit", [1.0, -20.0])
def test_driven_joints_are_told_by_their_torques_in_any_unit(unit):
    angles, torques = double_pendulum(by_motors), np.column_stack(by_motors(TIMES))
    with pytest.raises(TrialError, match="motors drive the joints"):
        find_trial(samples(angles, unit * torques), replace(HANGING, input="none"))


def test_of_driven_joints_without_torques_is_said_that_a_hand_or_motors_may_move_them():
    with pytest.raises(TrialError, match="the rods gain .* as by motors or a hand"):
        find_trial(samples(double_pendulum(by_motors)), HANGING)


PUMPED = {
    "the inner joint": (lambda time: (0.8 * np.sin(3.1 * time), 0.0), "it acts in the inner joint"),
    "the outer joint": (lambda time: (0.0, 0.06 * np.sin(5.5 * time)), "it acts in the outer joint"),
    "both joints": (lambda time: (0.12 * np.sin(5.0 * time), 0.036 * np.cos(8.5 * time)), "in either joint or both"),
}
"""Torques [N m] without a record under which the balance of a free motion nearly holds, and where they are said."""


@pytest.mark.parametrize("case", PUMPED)
def test_rods_that_gain_their_energy_are_not_free(case):
    torques, where = PUMPED[case]
    angles = double_pendulum(torques, start=(0.1, -0.1))
    with pytest.raises(OtherMotionError, match=rf"not free: from \d.* the rods gain \d+% of their energy.*{where}"):
        find_trial(samples(angles), HANGING)
    taken = find_trial(samples(angles), replace(HANGING, conventions="warn"))
    assert "gain" in " ".join(taken.warnings)


@pytest.mark.parametrize("kind", ["cogging_torque.inner", "oblique_view.base", "pivot_compliance.base"])
def test_what_effects_of_the_rig_give_back_is_no_gain(kind):
    swing = truth(kind, 1, visible=40.0).trials[0]
    stamps = np.round(1e9 * swing.time).astype(np.int64)
    found = find_trial(Samples(stamps, swing.theta, None), TrialOptions(outer_angle="absolute"))
    assert "is explained neither by gravity" in " ".join(found.warnings)
    assert found.trial.duration > 10.0


def test_joints_that_are_driven_most_of_the_time_are_taken_with_their_torques():
    angles, torques = double_pendulum(by_motors), np.column_stack(by_motors(TIMES))
    found = find_trial(samples(angles, torques), HANGING)
    assert found.trial.duration == pytest.approx(10.0, abs=0.02)
    assert found.trial.torques == pytest.approx(torques)
    assert found.balance.lumped.values[[0, 1, 4, 5]] == pytest.approx([A23, A33, G1, G2], rel=0.02)
    mirrored = find_trial(samples(-angles, -torques), replace(HANGING, inner_sign=-1, outer_sign=-1))
    assert mirrored.trial.torques == pytest.approx(torques)
    with pytest.raises(TrialError, match="contradict zero: upright"):
        find_trial(samples(angles, torques), replace(HANGING, zero="upright"))
    with pytest.raises(TrialError, match="outer joint count against its angle"):
        find_trial(samples(angles, torques * [1.0, -1.0]), HANGING)
    with pytest.raises(TrialError, match="neither joint has an effort"):
        find_trial(samples(double_pendulum()), replace(HANGING, input="joints"))


def test_torques_of_a_joint_whose_motor_does_little_do_not_count_against_its_angle():
    # As motors that are geared to joints: what the passive one's current shows is its own drag.
    angles = double_pendulum(lambda time: (0.0, 0.3 * np.cos(4.3 * time)))
    drag = -0.003 * np.gradient(angles[:, 0], STEP)
    torques = np.column_stack([drag, 0.3 * np.cos(4.3 * TIMES)])
    assert find_trial(samples(angles, torques), HANGING).trial.torques == pytest.approx(torques)


def test_driven_motion_is_taken_though_wrong_torques_leave_much_unexplained():
    def other(time):
        return 0.5 * np.sin(9.0 * time), 0.35 * np.sin(7.0 * time)

    known = np.column_stack([0.6 * np.sin(3.1 * TIMES), 0.3 * np.cos(4.3 * TIMES)])
    angles = double_pendulum(
        lambda time: np.add(other(time), (0.6 * np.sin(3.1 * time), 0.3 * np.cos(4.3 * time))), start=(0.1, 0.0)
    )
    found = find_trial(samples(angles, known), HANGING)
    assert found.trial.torques == pytest.approx(known)
    assert found.balance.lumped.unexplained > 0.1
    assert "is explained neither by gravity" in " ".join(found.warnings)


def test_a_cart_that_is_driven_most_of_the_time_is_an_input():
    cart = 0.06 * sympy.sin(2.3 * TIME)
    theta = motion(TABLE_5, (3.6, 2.9, 0.0, 0.0), TIMES, cart)[:, :2]
    noise = np.random.default_rng(1)
    angles = theta + 2e-4 * noise.normal(size=theta.shape)
    measured = cart_position(cart, TIMES) + 5e-5 * noise.normal(size=len(TIMES))
    stamps = np.arange(len(TIMES)) * round(STEP * 1e9)
    recorded = Samples(stamps, angles, measured)
    found = find_trial(recorded, TrialOptions(outer_angle="absolute"))
    assert found.trial.duration == pytest.approx(10.0, abs=0.02)
    assert found.trial.cart_acceleration is not None
    with pytest.raises(TrialError, match="the cart is driven"):
        find_trial(recorded, TrialOptions(outer_angle="absolute", input="none"))


def test_what_is_free_after_motors_let_go_is_taken():
    def torques(time):
        return 0.8 * np.sin(3.1 * time) * (time < 3.0), 0.4 * np.cos(4.3 * time) * (time < 3.0)

    angles = double_pendulum(torques)
    found = find_trial(samples(angles, np.column_stack(torques(TIMES))), HANGING)
    assert 2.5 < found.trial.start < 3.5
    assert found.trial.start + found.trial.duration > 9.9
    assert "motors drive the joints" in "; ".join(found.trial.notes)
    assert found.balance.lumped.values[[0, 1, 4, 5]] == pytest.approx([A23, A33, G1, G2], rel=0.02)


def test_a_long_recording_takes_little_memory():
    angles = np.tile(double_pendulum(), (60, 1))
    angles = angles + 1e-3 * np.random.default_rng(1).normal(size=angles.shape)
    recorded = Samples(np.arange(len(angles)) * round(STEP * 1e9), angles, None)
    tracemalloc.start()
    with contextlib.suppress(TrialError):
        find_trial(recorded, HANGING)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 60e6 + 400 * len(angles)


def test_the_longest_free_part_is_taken_and_everything_else_told():
    parts = [Part(0, HAND, 0, 2), Part(0, FREE, 2, 7), Part(0, CART, 7, 8), Part(1, FREE, 9, 20), Part(1, REST, 20, 30)]
    taken, notes = choose_parts(parts, 2.0)
    assert taken == [parts[3]]
    assert notes == [
        "cut 0.00 to 2.00 s (a hand is at the rods)",
        "cut 7.00 to 8.00 s (the cart is driven)",
        "cut 20.00 to 30.00 s (the rods are still)",
        "another zero-input part from 2.00 to 7.00 s is not used: another is longer",
    ]


def test_too_short_a_part_is_an_error_that_says_what_fills_the_rest():
    with pytest.raises(TrialError, match=r"the longest has 1\.00 s \(1\.00 to 9\.00 s \(the rods are still\)\)"):
        choose_parts([Part(0, FREE, 0, 1), Part(0, REST, 1, 9)], 2.0)


def test_free_parts_with_nothing_but_a_gap_between_them_are_one_motion():
    parts = [Part(0, FREE, 0, 3), Part(1, FREE, 3.1, 5), Part(1, REST, 5, 6), Part(2, FREE, 6.1, 10)]
    taken, notes = choose_parts(parts, 1.0)
    assert taken == parts[:2]
    assert notes[-1] == "another zero-input part from 6.10 to 10.00 s is not used: another is longer"


def test_what_may_be_free_where_samples_are_missing_is_so_between_free_parts_alone():
    parts = [Part(0, GAP, 0, 1), Part(0, FREE, 1, 4), Part(0, GAP, 4, 4.5), Part(0, FREE, 4.5, 6), Part(1, GAP, 6.1, 7)]
    taken, notes = choose_parts(parts, 1.0)
    assert taken == [Part(0, FREE, 1, 6)]
    assert notes == [f"cut {parts[0]}", f"cut {parts[4]}"]


HELD = 0.7


def held_up(time, start=(2.0, -1.0)):
    """Return the torques [N m] by which a hand holds both rods until it lets go."""
    inner, outer = INERTIA * np.array([G1, G2]) * np.sin(start)
    return (inner + outer, outer) if time < HELD else (0.0, 0.0)


@pytest.mark.parametrize(
    "gaps",
    [
        [0.3],
        [0.25, 0.5],
        np.arange(0.05, HELD, 0.12),
        np.arange(0.25, 9.8, 0.3),
    ],
)
def test_a_hand_holds_the_rods_behind_gaps_of_samples_as_before_them(gaps):
    missing = np.any([np.abs(TIMES - gap) < 0.025 for gap in gaps], axis=0)
    found = find_trial(samples(double_pendulum(held_up))[~missing], HANGING).trial
    assert HELD - 0.05 < found.start < HELD + 0.5
    assert found.start + found.duration > 9.9
    assert not any("for an instant" in note for note in found.notes)


@pytest.mark.parametrize("begin", [2.5, 5.5])
def test_a_clock_set_back_or_a_gap_of_a_swing_parts_them(begin):
    parts = [Part(0, FREE, 0, 3), Part(1, FREE, begin, begin + 5)]
    assert choose_parts(parts, 1.0)[0] == parts[1:]
