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

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.effects.catalogue import joint_law, memory_law, rods_law
from cdp_ident.model.effects.constants import CARRIED
from cdp_ident.model.effects.effect import Form
from cdp_ident.model.equations import acceleration_derivatives, accelerations, sine_and_cosine

_RODS, _COUPLING, _BASE, MEMORY = (int(form) for form in (Form.RODS, Form.COUPLING, Form.BASE, Form.MEMORY))
STICKS = 0
"""The mode of a joint that stands still."""
SIZES, HOLDS = 2, 5
"""Where in the sums the joints' dry friction begins, and the torques that hold sticking joints."""
COUNT_OF_SUMS = 7
_COEFFICIENTS = 7
BEFORE_PARAMETERS = 11
"""Where in a rods law's slopes the parameters begin."""


@inlined
def joint_speed(state, joint):
    """Return the speed of a joint (0 inner, 1 outer) [rad/s]."""
    return state[2] if joint == 0 else state[3] - state[2]


@part
def _add_torques(
    state, time, modes, table, values, lanes_of, constants, slopes, torque_by_state, torque_by_lane, sums, by_state,
    direct, rates, row,
):  # fmt: skip
    """Sum up the effects, their torques' derivatives by state and, where there are lanes, by lane.

    What has a memory fills in its own state's rate and that rate's derivatives.
    """
    first = len(state) + _COEFFICIENTS
    with_parameters = torque_by_lane.shape[1] >= first
    # Loops, not slices: numba would compile its formatting of error messages along with these. The lanes of parameters
    # need no zeros, for what each has is assigned, and what has none is zero from the beginning on.
    for k in range(COUNT_OF_SUMS):
        sums[k] = 0.0
    for k in range(len(state)):
        torque_by_state[0, k], torque_by_state[1, k] = 0.0, 0.0
    if with_parameters:
        for k in range(len(state), first):
            torque_by_lane[0, k], torque_by_lane[1, k] = 0.0, 0.0
    for e in range(len(table)):
        kind, form, joint, dry = table[e, 0], table[e, 1], table[e, 2], table[e, 3]
        if form == _COUPLING:
            sums[4] += values[e, 0]
            continue
        if form == _BASE:
            continue
        if form == MEMORY:
            own = table[e, 5]
            torque, rates[row, own] = memory_law(kind, joint_speed(state, joint), state[own], values, e, slopes)
            onto1, onto2 = (1.0, 0.0) if joint == 0 else (-1.0, 1.0)
            sums[0] += onto1 * torque
            sums[1] += onto2 * torque
            # A joint's speed is of its rods' speeds what its torque is on them.
            torque_by_state[0, 2] += onto1 * onto1 * slopes[0, 0]
            torque_by_state[0, 3] += onto1 * onto2 * slopes[0, 0]
            torque_by_state[1, 2] += onto2 * onto1 * slopes[0, 0]
            torque_by_state[1, 3] += onto2 * onto2 * slopes[0, 0]
            torque_by_state[0, own] += onto1 * slopes[0, 1]
            torque_by_state[1, own] += onto2 * slopes[0, 1]
            for k in range(len(state)):
                by_state[own - 2, k] = 0.0
            by_state[own - 2, 2], by_state[own - 2, 3] = onto1 * slopes[1, 0], onto2 * slopes[1, 0]
            by_state[own - 2, own] = slopes[1, 1]
            if with_parameters:
                for p in range(lanes_of.shape[1]):
                    lane = lanes_of[e, p]
                    if lane >= 0:
                        torque_by_lane[0, first + lane] = onto1 * slopes[0, 2 + p]
                        torque_by_lane[1, first + lane] = onto2 * slopes[0, 2 + p]
                        direct[own - 2, first + lane] = slopes[1, 2 + p]
            continue
        # Friction enters against the motion; while the joint sticks, by another way.
        factor = 1.0
        if dry:
            factor = -float(modes[joint])
        if form == _RODS:
            for k in range(slopes.shape[1]):
                slopes[0, k], slopes[1, k] = 0.0, 0.0
            torque1, torque2 = rods_law(kind, state, time, values, e, constants, slopes)
            if dry:
                sums[SIZES + joint] += torque1
                # The size is of a torque between two bodies.
                for k in range(slopes.shape[1]):
                    size = factor * slopes[0, k]
                    slopes[0, k], slopes[1, k] = (size, 0.0) if joint == 0 else (-size, size)
                size = factor * torque1
                torque1, torque2 = (size, 0.0) if joint == 0 else (-size, size)
            sums[0] += torque1
            sums[1] += torque2
            for k in range(4):
                torque_by_state[0, k] += slopes[0, k]
                torque_by_state[1, k] += slopes[1, k]
            if with_parameters:
                for k in range(_COEFFICIENTS):
                    torque_by_lane[0, first - _COEFFICIENTS + k] += slopes[0, 4 + k]
                    torque_by_lane[1, first - _COEFFICIENTS + k] += slopes[1, 4 + k]
                for p in range(lanes_of.shape[1]):
                    lane = lanes_of[e, p]
                    if lane >= 0:
                        torque_by_lane[0, first + lane] = slopes[0, BEFORE_PARAMETERS + p]
                        torque_by_lane[1, first + lane] = slopes[1, BEFORE_PARAMETERS + p]
            continue
        if joint == 0:
            torque = joint_law(kind, state[0] - math.pi, state[2], values, e, slopes)
            sums[0] += factor * torque
            torque_by_state[0, 0] += factor * slopes[0, 0]
            torque_by_state[0, 2] += factor * slopes[0, 1]
        else:
            torque = joint_law(kind, state[1] - state[0], state[3] - state[2], values, e, slopes)
            sums[0] -= factor * torque
            sums[1] += factor * torque
            for k in range(2):
                slope = factor * slopes[0, k]
                torque_by_state[0, 2 * k] += slope
                torque_by_state[0, 2 * k + 1] -= slope
                torque_by_state[1, 2 * k] -= slope
                torque_by_state[1, 2 * k + 1] += slope
        if dry:
            sums[SIZES + joint] += torque
        if with_parameters:
            for p in range(lanes_of.shape[1]):
                lane = lanes_of[e, p]
                if lane >= 0:
                    slope = factor * slopes[0, 2 + p]
                    torque_by_lane[0, first + lane] = slope if joint == 0 else -slope
                    torque_by_lane[1, first + lane] = 0.0 if joint == 0 else slope


@inlined
def _held(d1, d2, i11, i12, i22, inner_sticks, outer_sticks):
    """Return accelerations as the sticking joints let them be."""
    if inner_sticks and outer_sticks:
        return 0.0, 0.0
    if inner_sticks:
        return 0.0, d2 - d1 * i12 / i11
    if outer_sticks:
        share = (d2 - d1) / (i11 - 2.0 * i12 + i22)
        common = d1 - share * (i12 - i11)
        return common, common
    return d1, d2


@inlined
def rates_of(
    state, time, u, modes, coefficients, table, values, lanes_of, constants, base, slopes, torque_by_state,
    torque_by_lane, sums, by_state, direct, rates, row,
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
        slopes: (2, 11 + parameters) scratch for laws.
        torque_by_state: (2, n) takes the derivatives of the effects' torques by the state.
        torque_by_lane: (2, lanes) takes those by the lanes.
        sums: (7,) takes the effects' generalised torques (2), the size of the joints' dry friction (2), the coupling,
            and the torques that hold the sticking joints (2), all over A22.
        by_state: (n - 2, n) takes the derivatives by the state of the rates of all but the angles: of the rods' speeds,
            then of the states that effects bring.
        direct: (n - 2, lanes) takes those by the lanes: the state's n (zero), the seven coefficients, then parameters.
            Without lanes no derivatives are computed, with too few for coefficients those by the state alone.
        rates: (..., n) takes the rate of change in its row `row`.
        row: that row.
    """
    n = len(state)
    theta1, theta2, omega1, omega2 = state[0], state[1], state[2], state[3]
    A23, A33, a1, c1, c2, m2_l2, g = (
        coefficients[0], coefficients[1], coefficients[2], coefficients[3], coefficients[4], coefficients[5],
        coefficients[6],
    )  # fmt: skip
    torque1, torque2, coupled = 0.0, 0.0, 0.0
    if len(table) > 0:
        _add_torques(
            state, time, modes, table, values, lanes_of, constants, slopes, torque_by_state, torque_by_lane, sums,
            by_state, direct, rates, row,
        )  # fmt: skip
        torque1, torque2, coupled = sums[0], sums[1], sums[4]
    inner_sticks, outer_sticks = modes[0] == STICKS, modes[1] == STICKS
    acceleration, reduced = u, 1.0
    push1, push2, give1, give2 = 0.0, 0.0, 0.0, 0.0
    if inner_sticks or outer_sticks or base >= 0:
        sin1, cos1 = sine_and_cosine(theta1)
        sin2, cos2 = sine_and_cosine(theta2)
        s, m = sin1 * cos2 - cos1 * sin2, A23 * (cos1 * cos2 + sin1 * sin2) + coupled
        inverse_determinant = 1.0 / (A33 - m * m)
        j11, j12, j22 = A33 * inverse_determinant, -m * inverse_determinant, inverse_determinant
        push1, push2 = a1 * cos1, m2_l2 * cos2
        joint_friction = c2 * (omega1 - omega2)
        n1 = a1 * g * sin1 - push1 * u - A23 * s * omega2 * omega2 - c1 * omega1 - joint_friction + torque1
        n2 = m2_l2 * g * sin2 - push2 * u + A23 * s * omega1 * omega1 + joint_friction + torque2
        if base >= 0:
            compliance, frequency, damping_ratio = values[base, 0], values[base, 1], values[base, 2]
            squared, carried = frequency * frequency, constants[CARRIED]
            mobility, damping = compliance * squared, 2.0 * damping_ratio * frequency
            free1, free2 = _held(j11 * n1 + j12 * n2, j12 * n1 + j22 * n2, j11, j12, j22, inner_sticks, outer_sticks)
            give1, give2 = _held(
                j11 * push1 + j12 * push2, j12 * push1 + j22 * push2, j11, j12, j22, inner_sticks, outer_sticks
            )
            outwards = a1 * sin1 * omega1 * omega1 + m2_l2 * sin2 * omega2 * omega2
            given = push1 * give1 + push2 * give2
            reduced = 1.0 + mobility * (carried - given)
            pulled = mobility * (outwards - push1 * free1 - push2 * free2 - carried * u)
            position = table[base, 5]
            acceleration = u + (pulled - damping * state[position + 1] - squared * state[position]) / reduced
            n1 -= push1 * (acceleration - u)
            n2 -= push2 * (acceleration - u)
        if inner_sticks and outer_sticks:
            sums[HOLDS], sums[HOLDS + 1] = -n1 - n2, -n2
        elif inner_sticks:
            sums[HOLDS] = -(j11 * n1 + j12 * n2) / j11
        elif outer_sticks:
            sums[HOLDS + 1] = -((j12 - j11) * n1 + (j22 - j12) * n2) / (j11 - 2.0 * j12 + j22)
        if inner_sticks:
            torque1 += sums[HOLDS]
        if outer_sticks:
            torque1 -= sums[HOLDS + 1]
            torque2 += sums[HOLDS + 1]
    rates[row, 0], rates[row, 1] = omega1, omega2
    if direct.shape[1] == 0:
        alpha1, alpha2 = accelerations(
            theta1, theta2, omega1, omega2, acceleration, A23, A33, a1, c1, c2, m2_l2, g, torque1, torque2, coupled
        )
    else:
        with_parameters = direct.shape[1] >= n + _COEFFICIENTS
        alpha1, alpha2, i11, i12, i22 = acceleration_derivatives(
            theta1, theta2, omega1, omega2, acceleration, A23, A33, a1, c1, c2, m2_l2, g, torque1, torque2,
            by_state, direct, n, with_parameters, coupled,
        )  # fmt: skip
        if len(table) > 0:
            for k in range(4):
                d1, d2 = torque_by_state[0, k], torque_by_state[1, k]
                by_state[0, k] += i11 * d1 + i12 * d2
                by_state[1, k] += i12 * d1 + i22 * d2
            for k in range(4, n):
                d1, d2 = torque_by_state[0, k], torque_by_state[1, k]
                by_state[0, k] = i11 * d1 + i12 * d2
                by_state[1, k] = i12 * d1 + i22 * d2
            if with_parameters:
                for e in range(len(table)):
                    if table[e, 1] == _COUPLING and lanes_of[e, 0] >= 0:
                        torque_by_lane[0, n + _COEFFICIENTS + lanes_of[e, 0]] = -alpha2
                        torque_by_lane[1, n + _COEFFICIENTS + lanes_of[e, 0]] = -alpha1
                for k in range(n, n + _COEFFICIENTS):
                    d1, d2 = torque_by_lane[0, k], torque_by_lane[1, k]
                    direct[0, k] += i11 * d1 + i12 * d2
                    direct[1, k] += i12 * d1 + i22 * d2
                for k in range(n + _COEFFICIENTS, direct.shape[1]):
                    d1, d2 = torque_by_lane[0, k], torque_by_lane[1, k]
                    direct[0, k] = i11 * d1 + i12 * d2
                    direct[1, k] = i12 * d1 + i22 * d2
        if inner_sticks or outer_sticks:
            for k in range(n):
                by_state[0, k], by_state[1, k] = _held(
                    by_state[0, k], by_state[1, k], i11, i12, i22, inner_sticks, outer_sticks
                )
            for k in range(n, direct.shape[1]):
                direct[0, k], direct[1, k] = _held(
                    direct[0, k], direct[1, k], i11, i12, i22, inner_sticks, outer_sticks
                )
        if base >= 0:
            # The base's equation, differentiated; then the rods follow the base.
            sin1, cos1 = sine_and_cosine(theta1)
            sin2, cos2 = sine_and_cosine(theta2)
            along1, along2 = cos1 * alpha1 - sin1 * omega1 * omega1, cos2 * alpha2 - sin2 * omega2 * omega2
            pull = a1 * along1 + m2_l2 * along2 + carried * acceleration
            x, v = position - 2, position - 1
            for k in range(n):
                by_state[x, k], by_state[v, k] = 0.0, 0.0
            by_state[x, position + 1] = 1.0
            by_state[v, 0] = mobility * a1 * (-sin1 * alpha1 - cos1 * omega1 * omega1)
            by_state[v, 1] = mobility * m2_l2 * (-sin2 * alpha2 - cos2 * omega2 * omega2)
            by_state[v, 2] = -2.0 * mobility * a1 * sin1 * omega1
            by_state[v, 3] = -2.0 * mobility * m2_l2 * sin2 * omega2
            by_state[v, position], by_state[v, position + 1] = squared, damping
            for k in range(n, direct.shape[1]):
                direct[v, k] = 0.0
            if with_parameters:
                direct[v, n + 2], direct[v, n + 5] = mobility * along1, mobility * along2
                by_parameter = (
                    squared * pull,
                    2.0 * frequency * (compliance * pull + state[position]) + 2.0 * damping_ratio * state[position + 1],
                    2.0 * frequency * state[position + 1],
                )
                for p in range(3):
                    if lanes_of[base, p] >= 0:
                        direct[v, n + _COEFFICIENTS + lanes_of[base, p]] = by_parameter[p]
            for k in range(n):
                change = -(by_state[v, k] + mobility * (push1 * by_state[0, k] + push2 * by_state[1, k])) / reduced
                by_state[v, k] = change
                by_state[0, k] -= give1 * change
                by_state[1, k] -= give2 * change
            for k in range(n, direct.shape[1]):
                change = -(direct[v, k] + mobility * (push1 * direct[0, k] + push2 * direct[1, k])) / reduced
                direct[v, k] = change
                direct[0, k] -= give1 * change
                direct[1, k] -= give2 * change
    # What sticks is held exactly, not but for rounding.
    if inner_sticks:
        alpha1 = 0.0
    if outer_sticks:
        alpha2 = alpha1
    rates[row, 2], rates[row, 3] = alpha1, alpha2
    if base >= 0:
        rates[row, position], rates[row, position + 1] = state[position + 1], acceleration - u
