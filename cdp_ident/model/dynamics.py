r"""The rate of change of a pendulum's state with any effects, and its derivatives (compiled).

The state is theta1, theta2, omega1, omega2 and what effects bring: where the base moves on a spring, its position x and
speed. A joint with dry friction *slips* one way (mode 1) or the other (mode -1), or *sticks* (mode 0). Slipping, the
friction is its size against the motion. Sticking, it is the torque that keeps the joint's speed constant (at zero),
which follows from the equations of motion M omega' = N + J^T friction with J omega' = 0 (Leine and Nijmeijer, Dynamics
and Bifurcations of Non-smooth Mechanical Systems, 2004, chapter 5); J is (1, 0) for the inner joint and (-1, 1) for the
outer one.

The base's equation closes that; U = u + x'' is its whole acceleration, and the rods' pull is over A22::

    pull = a1 (cos theta1 omega1' - sin theta1 omega1^2) + m2 l2 (cos theta2 omega2' - sin theta2 omega2^2)
    x'' + mobility (carried U + pull) + 2 damping_ratio frequency x' + frequency^2 x = 0
    mobility = compliance frequency^2

The mobility is one over what moves along, cart and rods, without the weights that a trial's rods carry. It may be zero:
then the base swings by itself, and what a little compliance would change is in the derivatives.
"""

import math

import numpy as np

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.effects.catalogue import curve_law, joint_law, memory_law, rods_law
from cdp_ident.model.effects.constants import CARRIED
from cdp_ident.model.effects.effect import MOST_OF_A_LAW, Form
from cdp_ident.model.equations import (
    RODS_STATES,
    acceleration_derivatives,
    accelerations,
    holding,
    inertia_between,
    response,
    sines_and_cosines,
    solved,
    torques_on_rods,
)
from cdp_ident.model.parameters import COEFFICIENTS

RODS, COUPLING, _BASE, MEMORY, CURVE = (
    int(form) for form in (Form.RODS, Form.COUPLING, Form.BASE, Form.MEMORY, Form.CURVE)
)
STICKS = 0
"""The mode of a joint that stands still."""
SIZES, HOLDS = 0, 2
"""Where in the sums the joints' dry friction begins, and the torques that hold sticking joints."""
COUNT_OF_SUMS = 4
_COEFFICIENTS = len(COEFFICIENTS)


@inlined
def joint_speed(state, joint):
    """Return the speed of a joint (0 inner, 1 outer) [rad/s]."""
    return state[2] if joint == 0 else state[3] - state[2]


@inlined
def onto_rods(joint):
    """Return what a torque between a joint's two bodies is on the rods; likewise the joint's speed is of theirs."""
    return (1.0, 0.0) if joint == 0 else (-1.0, 1.0)


@inlined
def times3(factor, of):
    """Return three numbers times a factor."""
    return factor * of[0], factor * of[1], factor * of[2]


@inlined
def between_bodies(to1, to2, size, x, to, by):
    """Return what a law of form RODS does, of a torque between a joint's two bodies.

    Args:
        to1: times it, it is a torque on theta1.
        to2: likewise on theta2.
        size: the torque.
        x: its derivatives by the state.
        to: those by the coefficients.
        by: those by the law's parameters.
    """
    return (
        to1 * size, to2 * size, _times4(to1, x), _times4(to2, x), _times7(to1, to), _times7(to2, to), times3(to1, by),
        times3(to2, by),
    )  # fmt: skip


@inlined
def _times4(factor, of):
    return factor * of[0], factor * of[1], factor * of[2], factor * of[3]


@inlined
def _times7(factor, of):
    return (*_times4(factor, of), factor * of[4], factor * of[5], factor * of[6])


@part
def add_torques(
    state, turned, time, modes, table, values, lanes_of, constants, slopes, by_own, by_lane, sums, by_state, direct,
    rates, row,
):  # fmt: skip
    """Return the effects' generalised torques, what they add to the coupling, and the torques' derivatives.

    These are four numbers of each torque, by the rods' state; `by_own` takes those by states of effects, and where
    there are lanes `by_lane` those by them. What has a memory fills in its own state's rate and its derivatives.
    """
    n, first = len(state), len(state) + _COEFFICIENTS
    with_parameters = by_lane.shape[1] >= first
    # Sums of what each effect adds stay in registers. Loops, not slices: numba would compile its formatting of error
    # messages along with these. The lanes of parameters need no zeros, for what each has is assigned, and what has none
    # is zero from the beginning on.
    torque1, torque2, coupled = 0.0, 0.0, 0.0
    x1, x2, x3, x4, y1, y2, y3, y4 = 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    sums[SIZES], sums[SIZES + 1] = 0.0, 0.0
    for k in range(RODS_STATES, n):
        by_own[0, k], by_own[1, k] = 0.0, 0.0
    if with_parameters:
        for k in range(n, first):
            by_lane[0, k], by_lane[1, k] = 0.0, 0.0
    for e in range(len(table)):
        kind, form, joint, dry = table[e, 0], table[e, 1], table[e, 2], table[e, 3]
        if form == COUPLING:
            coupled += values[e, 0]
        elif form == _BASE:
            pass
        elif form == RODS:
            added1, added2, x, y, to1, to2, by1, by2 = rods_law(
                kind, (state[0], state[1], state[2], state[3]), turned, time,
                (values[e, 0], values[e, 1], values[e, 2]), constants,
            )  # fmt: skip
            if dry:
                # The size is of a torque between two bodies, against the motion; while the joint sticks, it is not it.
                sums[SIZES + joint] += added1
                onto1, onto2 = onto_rods(joint)
                against = -float(modes[joint])
                added1, added2, x, y, to1, to2, by1, by2 = between_bodies(
                    against * onto1, against * onto2, added1, x, to1, by1
                )
            torque1 += added1
            torque2 += added2
            x1, x2, x3, x4 = x1 + x[0], x2 + x[1], x3 + x[2], x4 + x[3]
            y1, y2, y3, y4 = y1 + y[0], y2 + y[1], y3 + y[2], y4 + y[3]
            if with_parameters:
                for k in range(_COEFFICIENTS):
                    by_lane[0, n + k] += to1[k]
                    by_lane[1, n + k] += to2[k]
                for p in range(MOST_OF_A_LAW):
                    lane = lanes_of[e, p]
                    if lane >= 0:
                        by_lane[0, first + lane], by_lane[1, first + lane] = by1[p], by2[p]
        else:
            # A torque between two bodies: a joint's angle and speed are of its rods' what the torque is on them.
            onto1, onto2 = onto_rods(joint)
            speed = onto1 * state[2] + onto2 * state[3]
            if form == MEMORY:
                own = table[e, 5]
                direction = float(modes[joint])
                torque, rates[row, own] = memory_law(kind, speed, direction, state[own], values, e, slopes)
                by_angle, by_speed = 0.0, slopes[0, 0]
                by_own[0, own] += onto1 * slopes[0, 1]
                by_own[1, own] += onto2 * slopes[0, 1]
                for k in range(n):
                    by_state[row, own - 2, k] = 0.0
                by_state[row, own - 2, 2] = onto1 * slopes[1, 0]
                by_state[row, own - 2, 3] = onto2 * slopes[1, 0]
                by_state[row, own - 2, own] = slopes[1, 1]
            else:
                angle = state[0] - math.pi if joint == 0 else state[1] - state[0]
                if form == CURVE:
                    torque = curve_law(kind, angle, speed, values, e, slopes)
                    by_angle, by_speed = slopes[0, 0], slopes[0, 1]
                else:
                    torque, by_angle, by_speed, by = joint_law(
                        kind, angle, speed, (values[e, 0], values[e, 1], values[e, 2])
                    )
                    slopes[0, 2], slopes[0, 3], slopes[0, 4] = by
                if dry:
                    sums[SIZES + joint] += torque
                    onto1, onto2 = -float(modes[joint]) * onto1, -float(modes[joint]) * onto2
            torque1 += onto1 * torque
            torque2 += onto2 * torque
            if joint == 0:
                x1 += onto1 * by_angle
                x3 += onto1 * by_speed
            else:
                x1 -= onto1 * by_angle
                x2 += onto1 * by_angle
                x3 -= onto1 * by_speed
                x4 += onto1 * by_speed
                y1 -= onto2 * by_angle
                y2 += onto2 * by_angle
                y3 -= onto2 * by_speed
                y4 += onto2 * by_speed
            if with_parameters:
                for p in range(lanes_of.shape[1]):
                    lane = lanes_of[e, p]
                    if lane >= 0:
                        by_lane[0, first + lane] = onto1 * slopes[0, 2 + p]
                        by_lane[1, first + lane] = onto2 * slopes[0, 2 + p]
                        if form == MEMORY:
                            direct[row, own - 2, first + lane] = slopes[1, 2 + p]
    return torque1, torque2, coupled, (x1, x2, x3, x4), (y1, y2, y3, y4)


@inlined
def rates_of(
    state, time, u, modes, coefficients, table, values, lanes_of, constants, base, slopes, by_own, by_lane, sums,
    by_state, direct, rates, row,
):  # fmt: skip
    """Fill in the state's rate of change and, where there are lanes, the accelerations' derivatives.

    Args:
        state: (n,) the state.
        time: time in the trial [s].
        u: the cart's acceleration [m/s^2].
        modes: (2,) of the inner and the outer joint.
        coefficients: (7,) `COEFFICIENTS`.
        table: the effects, as `Torques` has them, like the next three.
        values: their parameters.
        lanes_of: the lanes of these.
        constants: of the mechanism.
        base: row of the effect of form BASE, -1 without one.
        slopes: (2, 2 + parameters) scratch for laws.
        by_own: (2, n) scratch for the derivatives of the effects' torques by states of their own.
        by_lane: (2, lanes) scratch for those by the lanes.
        sums: (4,) takes the size of the joints' dry friction (2) and the torques that hold the sticking joints (2), all
            over A22.
        by_state: (…, n - 2, n) takes in its part `row` the derivatives by the state of the rates of all but the angles:
            of the rods' speeds, then of the states that effects bring.
        direct: (…, n - 2, lanes) takes likewise those by the lanes: the state's n (zero), the seven coefficients, then
            parameters. Without lanes no derivatives are computed, with too few for coefficients those by the state
            alone.
        rates: (…, n) takes the rate of change in its row `row`.
        row: that row and that part.
    """
    n, lanes = len(state), direct.shape[2]
    omega1, omega2 = state[2], state[3]
    turned = sines_and_cosines(state[0], state[1])
    sin1, cos1, sin2, cos2 = turned
    A23, A33, a1, c1, c2, m2_l2, g = (
        coefficients[0], coefficients[1], coefficients[2], coefficients[3], coefficients[4], coefficients[5],
        coefficients[6],
    )  # fmt: skip
    torque1, torque2, coupled = 0.0, 0.0, 0.0
    of_torque1, of_torque2 = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if len(table) > 0:
        torque1, torque2, coupled, of_torque1, of_torque2 = add_torques(
            state, turned, time, modes, table, values, lanes_of, constants, slopes, by_own, by_lane, sums, by_state,
            direct, rates, row,
        )  # fmt: skip
    inner_sticks, outer_sticks = modes[0] == STICKS, modes[1] == STICKS
    acceleration, reduced = u, 1.0
    push1, push2, give1, give2 = 0.0, 0.0, 0.0, 0.0
    if inner_sticks or outer_sticks or base >= 0:
        m = inertia_between(turned, A23, coupled)
        push1, push2 = a1 * cos1, m2_l2 * cos2
        n1, n2 = torques_on_rods(turned, omega1, omega2, u, A23, a1, c1, c2, m2_l2, g, torque1, torque2)
        if base >= 0:
            compliance, frequency, damping_ratio = values[base, 0], values[base, 1], values[base, 2]
            squared, carried = frequency * frequency, constants[CARRIED]
            mobility, damping = compliance * squared, 2.0 * damping_ratio * frequency
            by_torques = response(A33, m, inner_sticks, outer_sticks)
            (free1, free2), (give1, give2) = solved(by_torques, n1, n2), solved(by_torques, push1, push2)
            outwards = a1 * sin1 * omega1 * omega1 + m2_l2 * sin2 * omega2 * omega2
            given = push1 * give1 + push2 * give2
            reduced = 1.0 + mobility * (carried - given)
            pulled = mobility * (outwards - push1 * free1 - push2 * free2 - carried * u)
            position = table[base, 5]
            acceleration = u + (pulled - damping * state[position + 1] - squared * state[position]) / reduced
            n1 -= push1 * (acceleration - u)
            n2 -= push2 * (acceleration - u)
        sums[HOLDS], sums[HOLDS + 1] = holding(n1, n2, A33, m, inner_sticks, outer_sticks)
        torque1 += sums[HOLDS] - sums[HOLDS + 1]
        torque2 += sums[HOLDS + 1]
    rates[row, 0], rates[row, 1] = omega1, omega2
    if lanes == 0:
        alpha1, alpha2 = accelerations(
            turned, omega1, omega2, acceleration, A23, A33, a1, c1, c2, m2_l2, g, torque1, torque2, coupled
        )
    else:
        with_parameters = lanes >= n + _COEFFICIENTS
        alpha1, alpha2, by_torques, by_rods, by_coefficient = acceleration_derivatives(
            turned, omega1, omega2, acceleration, A23, A33, a1, c1, c2, m2_l2, g, torque1, torque2, coupled,
            inner_sticks, outer_sticks,
        )  # fmt: skip
        for k in range(RODS_STATES):
            (d1, d2), (e1, e2) = by_rods[k], solved(by_torques, of_torque1[k], of_torque2[k])
            by_state[row, 0, k], by_state[row, 1, k] = d1 + e1, d2 + e2
        for k in range(RODS_STATES, n):
            by_state[row, 0, k], by_state[row, 1, k] = solved(by_torques, by_own[0, k], by_own[1, k])
        if with_parameters:
            if len(table) > 0:
                for e in range(len(table)):
                    if table[e, 1] == COUPLING and lanes_of[e, 0] >= 0:
                        by_lane[0, n + _COEFFICIENTS + lanes_of[e, 0]] = -alpha2
                        by_lane[1, n + _COEFFICIENTS + lanes_of[e, 0]] = -alpha1
                # Vectorised with unsigned indices only: negative ones would count from the end. It comes first and only
                # assigns: vectors of what was just written number by number are slow to read.
                for k in range(np.uint64(lanes)):
                    direct[row, 0, k], direct[row, 1, k] = solved(by_torques, by_lane[0, k], by_lane[1, k])
                for k in range(_COEFFICIENTS):
                    direct[row, 0, n + k] += by_coefficient[k][0]
                    direct[row, 1, n + k] += by_coefficient[k][1]
            else:
                for k in range(_COEFFICIENTS):
                    direct[row, 0, n + k], direct[row, 1, n + k] = by_coefficient[k]
        if base >= 0:
            # The base's equation, differentiated; then the rods follow the base.
            along1, along2 = cos1 * alpha1 - sin1 * omega1 * omega1, cos2 * alpha2 - sin2 * omega2 * omega2
            pull = a1 * along1 + m2_l2 * along2 + carried * acceleration
            x, v = position - 2, position - 1
            for k in range(n):
                by_state[row, x, k], by_state[row, v, k] = 0.0, 0.0
            by_state[row, x, position + 1] = 1.0
            by_state[row, v, 0] = mobility * a1 * (-sin1 * alpha1 - cos1 * omega1 * omega1)
            by_state[row, v, 1] = mobility * m2_l2 * (-sin2 * alpha2 - cos2 * omega2 * omega2)
            by_state[row, v, 2] = -2.0 * mobility * a1 * sin1 * omega1
            by_state[row, v, 3] = -2.0 * mobility * m2_l2 * sin2 * omega2
            by_state[row, v, position], by_state[row, v, position + 1] = squared, damping
            for k in range(np.uint64(n), np.uint64(lanes)):
                direct[row, v, k] = 0.0
            if with_parameters:
                direct[row, v, n + 2], direct[row, v, n + 5] = mobility * along1, mobility * along2
                by_parameter = (
                    squared * pull,
                    2.0 * frequency * (compliance * pull + state[position]) + 2.0 * damping_ratio * state[position + 1],
                    2.0 * frequency * state[position + 1],
                )
                for p in range(3):
                    if lanes_of[base, p] >= 0:
                        direct[row, v, n + _COEFFICIENTS + lanes_of[base, p]] = by_parameter[p]
            share = -1.0 / reduced
            for k in range(n):
                change = share * (
                    by_state[row, v, k] + mobility * (push1 * by_state[row, 0, k] + push2 * by_state[row, 1, k])
                )
                by_state[row, v, k] = change
                by_state[row, 0, k] -= give1 * change
                by_state[row, 1, k] -= give2 * change
            for k in range(np.uint64(n), np.uint64(lanes)):
                change = share * (
                    direct[row, v, k] + mobility * (push1 * direct[row, 0, k] + push2 * direct[row, 1, k])
                )
                direct[row, v, k] = change
                direct[row, 0, k] -= give1 * change
                direct[row, 1, k] -= give2 * change
    # What sticks is held exactly, not but for rounding.
    if inner_sticks:
        alpha1 = 0.0
    if outer_sticks:
        alpha2 = alpha1
    rates[row, 2], rates[row, 3] = alpha1, alpha2
    if base >= 0:
        rates[row, position], rates[row, position + 1] = state[position + 1], acceleration - u


@part
def rates_at(
    state, time, u, modes, coefficients, table, values, lanes_of, constants, base, slopes, by_own, by_lane, sums,
    by_state, direct, rates, row,
):  # fmt: skip
    """Do what `rates_of` does, as a call: for what is not done in every step."""
    rates_of(
        state, time, u, modes, coefficients, table, values, lanes_of, constants, base, slopes, by_own, by_lane, sums,
        by_state, direct, rates, row,
    )  # fmt: skip
