# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
r"""The rate of change of a pendulum's state under any laws, and its derivatives (compiled).

The equations of motion are M alpha = N + p (U - u), divided by A22: U is the whole acceleration of the cart's joint, u
the given one, p what the rods feel of it. Laws add to the torques N and, where they are linear in the accelerations, to
M and p; a law of the cart says what U - u is, linear in alpha and U. A joint with dry friction *slips* one way (mode 1)
or the other (mode -1), or *sticks* (mode 0). Slipping, the friction is its size against the motion. Sticking, it is the
torque that keeps the joint's speed constant (at zero), which follows from the equations of motion with J alpha = 0
(Leine and Nijmeijer, Dynamics and Bifurcations of Non-smooth Mechanical Systems, 2004, chapter 5); J is (1, 0) for the
inner joint and (-1, 1) for the outer one.
"""

import math

import numpy as np

from cdp_ident.machine.compilation import call, further, inlined, part, place
from cdp_ident.model import layout as at
from cdp_ident.model.formulas.compiled import pushes, slopes_of_paper
from cdp_ident.model.formulas.language import CART, FRICTION, PARAMETERS, RATES, TORQUE1, TORQUE2, VALUE
from cdp_ident.model.layout import unfolded

STICKS = 0
"""The mode of a joint that stands still."""

_CART = 2 * PARAMETERS
_TURN_HIGH = 2.0 * math.pi
_TURN_LOW = 2.4492935982947064e-16
"""2 pi = _TURN_HIGH + _TURN_LOW to twice the precision of a double."""


@inlined
def copy(source, target):
    """Copy numbers; numba's assignment of slices would bring its formatting of error messages, seconds to compile."""
    for i in range(len(target)):
        target[i] = source[i]


@inlined
def sine_and_cosine(angle):
    """Return sine and cosine of an angle [rad], to 1e-14 within a turn, without a branch or a call.

    The angle is brought into one turn about zero, a quarter of it goes into the Taylor series, and two doublings
    bring it back.
    """
    turns = np.floor(angle * (1.0 / _TURN_HIGH) + 0.5)
    quarter = ((angle - turns * _TURN_HIGH) - turns * _TURN_LOW) * 0.25
    # Neighbouring terms first (Estrin's scheme): they need not wait for each other.
    q = quarter * quarter
    q2 = q * q
    q4 = q2 * q2
    sine = quarter * (
        ((1.0 - q * (1.0 / 6)) + q2 * (1.0 / 120 - q * (1.0 / 5040)))
        + q4 * ((1.0 / 362880 - q * (1.0 / 39916800)) + q2 * (1.0 / 6227020800.0 - q * (1.0 / 1307674368000.0)))
    )
    cosine = ((1.0 - q * (1.0 / 2)) + q2 * (1.0 / 24 - q * (1.0 / 720))) + q4 * (
        (1.0 / 40320 - q * (1.0 / 3628800)) + q2 * (1.0 / 479001600 - q * (1.0 / 87178291200.0))
    )
    half_sine, half_cosine = 2.0 * sine * cosine, 1.0 - 2.0 * sine * sine
    return 2.0 * half_sine * half_cosine, 1.0 - 2.0 * half_sine * half_sine


@inlined
def joint_speed(state, joint):
    """Return the speed of a joint (0 inner, 1 outer) [rad/s]."""
    return state[2] if joint == 0 else state[3] - state[2]


@inlined
def response(i11, i12, i21, i22, inner_sticks, outer_sticks):
    """Return the rods' accelerations by torques on them: omega1' by one on either rod, then omega2'.

    It is the inverse of the inertia matrix. Where a joint sticks, the torque in it lets no other motion be: with the
    inner joint the outer rod turns alone, with the outer one both rods turn as one.
    """
    inverse = 1.0 / (i11 * i22 - i12 * i21)
    as_one = 1.0 / (i11 + i12 + i21 + i22) if outer_sticks and not inner_sticks else 0.0
    alone = 1.0 / i22 if inner_sticks and not outer_sticks else as_one
    free = not (inner_sticks or outer_sticks)
    return (
        i22 * inverse if free else as_one,
        -i12 * inverse if free else as_one,
        -i21 * inverse if free else as_one,
        i11 * inverse if free else alone,
    )


@inlined
def fill_inputs(motion, work, state, t):
    """Fill in the inputs of laws but for accelerations and own states."""
    z = work.z
    for k in range(at.RODS_STATES):
        z[k] = state[k]
    z[at.T] = t
    for joint in range(2):
        z[at.DIRECTION + joint] = float(work.modes[at.MODE, joint])
        z[at.SINES + 2 * joint], z[at.SINES + 2 * joint + 1] = sine_and_cosine(state[joint])
    for k in range(at.OUTER_LENGTH):
        z[at.COEFFICIENT + k] = motion[k]
    z[at.ROD_LENGTH], z[at.ROD_LENGTH + 1] = motion[at.OUTER_LENGTH], motion[at.CARRIED]
    per_step = work.numbers[at.PER_STEP]
    if per_step > 0.0:
        s = (t - work.numbers[at.STEP_BEGIN]) * per_step
        for joint in range(2):
            first = at.DRIVES + 3 * joint
            begin = work.numbers[first]
            middle, end = work.numbers[first + 1] - begin, work.numbers[first + 2] - begin
            z[at.DRIVES_NOW + joint] = begin + s * (4.0 * middle - end + 2.0 * s * (end - 2.0 * middle))
            z[at.DRIVES_NOW + 2 + joint] = (4.0 * middle - end + 4.0 * s * (end - 2.0 * middle)) * per_step
            z[at.DRIVES_NOW + 4 + joint] = 4.0 * (end - 2.0 * middle) * per_step * per_step


@inlined
def call_law(laws, motion, work, law, state):
    """Call a law's code, given its own states."""
    for k in range(laws.table[law, at.OWNS]):
        work.z[at.OWN + k] = state[laws.table[law, at.OWN_AT] + k]
    values = further(motion, at.VALUES + laws.table[law, at.VALUES_AT])
    rows = place(work.rows, laws.table[law, at.ROWS_AT])
    call(laws.table[law, at.CODE], (place(work.z, 0), values, place(work.sums, 0), rows))


def fill_rates(plan, motion, room, state_row, t, u, row, derive):
    """Fill in a row of the rates of a row of the states and, where asked to `derive`, of the jacobians.

    The time in the trial is t [s], and the cart's acceleration u [m/s^2]. The modes say where joints slip and stick,
    and which states are held.
    """
    laws, work = unfolded(plan, room)
    z, sums, states = work.z, work.sums[0], work.states
    state = states[state_row]
    fill_inputs(motion, work, state, t)
    turned = z[at.SINES], z[at.SINES + 1], z[at.SINES + 2], z[at.SINES + 3]
    A23, A33, a1, c1, c2, L, g = motion[0], motion[1], motion[2], motion[3], motion[4], motion[5], motion[6]
    n1, n2, m = pushes(u, turned, (state[2], state[3]), (A23, A33, a1, c1, c2, L, g))
    i11, i12, i21, i22 = 1.0, m, m, A33
    p1, p2 = -a1 * turned[1], -A23 / L * turned[3]
    kinds, cart, cart1, cart2, cart_u = 0, 0.0, 0.0, 0.0, 0.0
    if len(laws.table) > 0:
        z[at.ALPHA1], z[at.ALPHA1 + 1], z[at.U] = 0.0, 0.0, 0.0
        kinds = _call_laws(laws, motion, work, state)
        by_u1, by_u2 = sums[at.BY_U], sums[PARAMETERS + at.BY_U]
        i11, i12 = i11 - sums[at.BY_ALPHA1], i12 - sums[at.BY_ALPHA2]
        i21, i22 = i21 - sums[PARAMETERS + at.BY_ALPHA1], i22 - sums[PARAMETERS + at.BY_ALPHA2]
        p1, p2 = p1 + by_u1, p2 + by_u2
        n1, n2 = n1 + sums[VALUE] + by_u1 * u, n2 + sums[PARAMETERS + VALUE] + by_u2 * u
    inner_sticks, outer_sticks = work.modes[at.MODE, 0] == STICKS, work.modes[at.MODE, 1] == STICKS
    r11, r12, r21, r22 = response(i11, i12, i21, i22, inner_sticks, outer_sticks)
    alpha1, alpha2, whole, per_reduced = r11 * n1 + r12 * n2, r21 * n1 + r22 * n2, u, 1.0
    push1, push2 = r11 * p1 + r12 * p2, r21 * p1 + r22 * p2
    if kinds & at.CART_KIND:
        cart, cart_u = sums[_CART + VALUE], sums[_CART + at.BY_U]
        cart1, cart2 = sums[_CART + at.BY_ALPHA1], sums[_CART + at.BY_ALPHA2]
        per_reduced = 1.0 / (1.0 - cart1 * push1 - cart2 * push2 - cart_u)
        ahead = (cart + cart1 * alpha1 + cart2 * alpha2 + cart_u * u) * per_reduced
        alpha1, alpha2, whole = alpha1 + push1 * ahead, alpha2 + push2 * ahead, u + ahead
    if inner_sticks or outer_sticks:
        # What holds a joint is what the equations lack; none but for rounding where it slips.
        lacks2 = i21 * alpha1 + i22 * alpha2 - n2 - p2 * (whole - u)
        lacks1 = i11 * alpha1 + i12 * alpha2 - n1 - p1 * (whole - u)
        work.numbers[at.HOLDS], work.numbers[at.HOLDS + 1] = lacks1 + lacks2, lacks2
        work.numbers[at.INERTIAS], work.numbers[at.INERTIAS + 1] = i11, i12
        work.numbers[at.INERTIAS + 2], work.numbers[at.INERTIAS + 3] = i21, i22
        # What sticks is held exactly, not but for rounding.
        alpha1 = 0.0 if inner_sticks else alpha1
        alpha2 = alpha1 if outer_sticks else alpha2
    states[at.RATES_AT + row, 0], states[at.RATES_AT + row, 1] = state[2], state[3]
    states[at.RATES_AT + row, 2], states[at.RATES_AT + row, 3] = alpha1, alpha2
    z[at.ALPHA1], z[at.ALPHA1 + 1], z[at.U] = alpha1, alpha2, whole
    if kinds & at.ACCELERATED:
        copy(work.sums[1], sums)
        _call_accelerated(laws, motion, work, state)
    n = len(state)
    if n > at.RODS_STATES:
        for law in range(len(laws.table)):
            first = laws.table[law, at.OWN_AT]
            for own in range(first, first + laws.table[law, at.OWNS]):
                rate = work.rows[laws.table[law, at.ROWS_AT] + (RATES + own - first) * laws.table[law, at.WIDTH]]
                states[at.RATES_AT + row, own] = rate if work.modes[at.MODE, 2 + own] == 0 else 0.0
    if derive:
        if len(laws.table) == 0:
            _clear(sums)
        slopes_of_paper(z, z, sums, work.rows)
        _fill_derivatives(laws, work, row, (r11, r12, r21, r22), (push1, push2), (cart1, cart2, per_reduced))
        for law in range(len(laws.table) if n > at.RODS_STATES else 0):
            width, first = laws.table[law, at.WIDTH], laws.table[law, at.OWN_AT]
            for own in range(first, first + laws.table[law, at.OWNS]):
                of = laws.table[law, at.ROWS_AT] + (RATES + own - first) * width
                fill_slopes(laws, work, law, of, row, own, 1.0 if work.modes[at.MODE, 2 + own] == 0 else 0.0)


@inlined
def _clear(sums):
    for k in range(3 * PARAMETERS):
        sums[k] = 0.0


@part
def _call_laws(laws, motion, work, state):
    """Let all laws add to the sums, cleared before, and to the joints' friction; return their kinds together."""
    _clear(work.sums[0])
    work.numbers[at.SIZES], work.numbers[at.SIZES + 1] = 0.0, 0.0
    kinds = 0
    for law in range(len(laws.table)):
        if laws.table[law, at.KIND] & at.MOVES:
            kinds |= laws.table[law, at.KIND]
            if laws.table[law, at.KIND] & at.ACCELERATED:
                continue
            call_law(laws, motion, work, law, state)
            if laws.table[law, at.KIND] & at.FRICTION_KIND:
                size = work.rows[laws.table[law, at.ROWS_AT] + FRICTION * laws.table[law, at.WIDTH]]
                work.numbers[at.SIZES + laws.table[law, at.JOINT]] += size
    if kinds & at.ACCELERATED:
        copy(work.sums[0], work.sums[1])
        _call_accelerated(laws, motion, work, state)
    return kinds


@part
def _call_accelerated(laws, motion, work, state):
    """Let those laws add to the sums that depend on the accelerations."""
    for law in range(len(laws.table)):
        if laws.table[law, at.KIND] & at.MOVES and laws.table[law, at.KIND] & at.ACCELERATED:
            call_law(laws, motion, work, law, state)


@part
def _fill_derivatives(laws, work, row, inverse, pushed, of_cart):
    """Fill in the derivatives of the accelerations, given the responses: of rods to torques and cart, of it to them.

    Those by a coefficient or by the rods' state are of all laws, those by a parameter or an own state of one.
    """
    sums, rows, slopes, by_row = work.sums[0], work.rows, work.slopes, at.RATES_BY + row
    for column in range(1, PARAMETERS):
        lane = laws.lanes[column]
        if lane >= 0:
            by = sums[column], sums[PARAMETERS + column], sums[_CART + column]
            one, two, ahead = _solved(inverse, pushed, of_cart, by)
            slopes[2, by_row, lane], slopes[3, by_row, lane], slopes[at.CART_BY, by_row, lane] = one, two, ahead
    for law in range(len(laws.table)):
        if not laws.table[law, at.KIND] & at.MOVES:
            continue
        begin, width = laws.table[law, at.ROWS_AT], laws.table[law, at.WIDTH]
        row1, row2, row3 = begin + TORQUE1 * width, begin + TORQUE2 * width, begin + CART * width
        for column in range(at.BY_OWN, width):
            lane = laws.lanes[laws.table[law, at.LANES_AT] + column]
            if lane >= 0 and not at.BY_COEFFICIENT <= column < PARAMETERS:
                by = rows[row1 + column], rows[row2 + column], rows[row3 + column]
                one, two, ahead = _solved(inverse, pushed, of_cart, by)
                slopes[2, by_row, lane], slopes[3, by_row, lane], slopes[at.CART_BY, by_row, lane] = one, two, ahead


@inlined
def _solved(inverse, pushed, of_cart, by):
    """Return the derivatives of both accelerations and of the cart's, from those of what is left of their equations."""
    (r11, r12, r21, r22), (push1, push2), (cart1, cart2, per_reduced) = inverse, pushed, of_cart
    one, two = r11 * by[0] + r12 * by[1], r21 * by[0] + r22 * by[1]
    ahead = (by[2] + cart1 * one + cart2 * two) * per_reduced
    return one + push1 * ahead, two + push2 * ahead, ahead


@part
def fill_slopes(laws, work, law, of, row, number, factor):
    """Fill in the derivatives of a number of which a law has a row, times a factor, given those of the accelerations.

    The law's row begins at `of`; `row` is that of the rates, and `number` says of which number of the state they are.
    """
    slopes, rows, by_row = work.slopes, work.rows, at.RATES_BY + row
    by1, by2, by_u = factor * rows[of + at.BY_ALPHA1], factor * rows[of + at.BY_ALPHA2], factor * rows[of + at.BY_U]
    for lane in range(np.uint64(work.states.shape[1] + work.directions)):
        slopes[number, by_row, lane] = (
            by1 * slopes[2, by_row, lane] + by2 * slopes[3, by_row, lane] + by_u * slopes[at.CART_BY, by_row, lane]
        )
    for column in range(1, laws.table[law, at.WIDTH]):
        lane = laws.lanes[laws.table[law, at.LANES_AT] + column]
        if lane >= 0:
            slopes[number, by_row, lane] += factor * rows[of + column]
