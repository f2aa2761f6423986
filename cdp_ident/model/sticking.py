# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""When joints stop, stick and break loose, and states reach a limit, and what that does to derivatives (compiled).

A step of the integrator is made in parts, each as long as its error allows. A part ends where a joint's speed passes
through zero, where the torque that holds a sticking joint reaches its friction, or where a state reaches its limit.
There the rate of change may jump: derivatives of the motion are carried across by the saltation matrix (Leine and
Nijmeijer, Dynamics and Bifurcations of Non-smooth Mechanical Systems, 2004, chapter 7; Hiskens and Pai, IEEE Trans.
Circuits and Systems I 47, 2000).
"""

import math

import numpy as np

from cdp_ident.machine.compilation import call, call_for_number, inlined, part, place
from cdp_ident.model import layout as at
from cdp_ident.model.layout import unfolded
from cdp_ident.model.rates import STICKS, copy, joint_speed
from cdp_ident.model.runge_kutta import fill_first_slopes, roughness

_AT_LIMIT = 1e-11
"""A state so close to its limit, as a share of that, has reached it."""
_TURNED_OVER, _RESOLVED = 4.0, 0.15
"""A law that changes within a small speed v is constant beyond so many times v; below, a step changes the joint's speed
by at most this share of v."""
_SMALLEST = 1.0 / 256.0
"""Smallest share of a step into which it is divided."""
_MOST_ITERATIONS = 50
_MOST_EVENTS = 32
"""Most events in one step; further ones are ignored."""
AT_ONCE = 1e-13
"""Resolution of instants, as a share of the step."""
_NEAREST = 1e-9
"""A joint that begins to move and stops again within this share of a step counts as not having moved."""
_CLOSE = 1e-15
"""An instant is located when a speed [rad/s] or a torque over A22 [rad/s^2] is so close to its limit."""


def settle(plan, motion, room, t, u, loose, crossed):
    """Decide which joints at rest stick and where others go, and which states are held; fill in the rates after that.

    Derivatives are carried across the instant, which is t [s] in the trial, when the cart's acceleration is u
    [m/s^2]. `loose` is the joint that has just broken loose, whose holding torque is among the numbers, and `crossed`
    that whose speed has just become zero, the rates before which are those of the trial; -1 for none.
    """
    laws, work = unfolded(plan, room)
    state, modes, derive = work.states[at.BEGIN], work.modes, int(plan[at.DIRECTIONS] > 0)
    for joint in range(2):
        if work.modes[at.IS_TURNED, joint]:
            speed = joint_speed(state, joint)
            modes[at.MODE, joint] = 1 if speed > 0.0 else (-1 if speed < 0.0 else STICKS)
    if loose >= 0:
        # It moves against the torque that held it.
        modes[at.MODE, loose] = -1 if work.numbers[at.HOLDS + loose] > 0.0 else 1
    for k in range(at.RODS_STATES, len(state)):
        modes[at.MODE, 2 + k] = 0
    _settle_joints(plan, motion, room, work, t, u, derive)
    held = False
    for law in range(len(laws.table)):
        for k in range(laws.table[law, at.OWN_AT], laws.table[law, at.OWN_AT] + laws.table[law, at.OWNS]):
            side = 1 if state[k] > 0.0 else -1
            outwards = side * work.states[at.RATES_AT, k]
            # At rest, its joint's mode tells which way it will go.
            goes = outwards > 0.0 or (
                outwards == 0.0
                and laws.table[law, at.JOINT] < 2
                and side * modes[at.MODE, laws.table[law, at.JOINT]] >= 0
            )
            if is_at_limit(laws, state, k) and goes:
                modes[at.MODE, 2 + k], held = side, True
                state[k] = side * laws.limits[k]
    if held:
        call(plan[at.FILL_RATES], (plan, motion, room, at.BEGIN, t, u, 0, derive))
    if derive:
        _carry_derivatives(work, crossed)


@part
def _carry_derivatives(work, crossed):
    if crossed >= 0:
        _carry_across(work, crossed, work.states[at.TRIAL])
    for joint in range(2):
        if work.modes[at.MODE, joint] == STICKS:
            _hold_derivatives(work, joint)
    for r in range(at.RODS_STATES, work.states.shape[1]):
        if work.modes[at.MODE, 2 + r] != 0:  # a number that is at its limit depends on nothing
            for d in range(np.uint64(work.directions)):
                work.slopes[r, at.OLD, d] = 0.0
    fill_first_slopes(work)


@part
def _settle_joints(plan, motion, room, work, t, u, derive):
    # The modes of two joints at rest depend on each other: all combinations are tried until one is consistent.
    modes, rates = work.modes, work.states[at.RATES_AT]
    given_inner, given_outer = modes[at.MODE, 0], modes[at.MODE, 1]
    best, best_inner, best_outer = 1e300, given_inner, given_outer
    for attempt in range(10):
        inner, outer = attempt // 3, attempt % 3
        if attempt == 9:
            modes[at.MODE, 0], modes[at.MODE, 1] = best_inner, best_outer
        elif (given_inner != STICKS and inner > 0) or (given_outer != STICKS and outer > 0):
            continue
        else:
            modes[at.MODE, 0] = (-1 if inner == 2 else inner) if given_inner == STICKS else given_inner
            modes[at.MODE, 1] = (-1 if outer == 2 else outer) if given_outer == STICKS else given_outer
        call(plan[at.FILL_RATES], (plan, motion, room, at.BEGIN, t, u, 0, derive))
        # Slipping, it must go the way that it is pushed.
        wrong = max(_joint_violation(work, rates, 0), 0.0) if given_inner == STICKS else 0.0
        wrong += max(_joint_violation(work, rates, 1), 0.0) if given_outer == STICKS else 0.0
        if wrong == 0.0:
            return
        if wrong < best:
            best, best_inner, best_outer = wrong, modes[at.MODE, 0], modes[at.MODE, 1]


@inlined
def _joint_violation(work, state, joint):
    if work.modes[at.MODE, joint] == STICKS:
        return abs(work.numbers[at.HOLDS + joint]) - max(work.numbers[at.SIZES + joint], 0.0)
    return -float(work.modes[at.MODE, joint]) * joint_speed(state, joint)


@inlined
def violation(laws, work, state, mode):
    """Return by how much the condition of a mode is violated in a state: above zero, the mode has ended.

    The first two modes are those of the joints, the others those of each number of the state.
    """
    if mode < 2:
        return _joint_violation(work, state, mode) if work.modes[at.IS_TURNED, mode] else -1.0
    limit = laws.limits[mode - 2]
    return abs(state[mode - 2]) - limit if work.modes[at.MODE, mode] == 0 and limit < math.inf else -1.0


@inlined
def is_at_limit(laws, state, k):
    """Return whether a number of the state has reached its limit."""
    return abs(state[k]) >= (1.0 - _AT_LIMIT) * laws.limits[k]


@inlined
def dip(work, joint):
    """Return where in a step a slipping joint is slowest, as a share, if it slows down and speeds up again; else 0."""
    first, last, mode = work.states[at.RATES_AT], work.states[at.RATES_AT + 4], float(work.modes[at.MODE, joint])
    first, last = joint_speed(first, joint), joint_speed(last, joint)
    return first / (first - last) if mode * first < 0.0 and mode * last > 0.0 else 0.0


def instant_of(plan, motion, room, begin, step, done, share, mode):
    """Return after which share of the grid's step, up to `share`, a mode ends; 2 where it does not.

    Its violation at the end of that share is in `work.end`; if that is not above zero, it is a joint whose speed has a
    minimum on the way. The rates at the beginning are there; the others are overwritten.
    """
    laws, work = unfolded(plan, room)
    low, high, low_value, high_value = 0.0, share, 0.0, work.numbers[at.VIOLATIONS + mode]
    state = work.states[at.BEGIN]
    dips, bracketed, reach = high_value <= 0.0, False, share
    if dips:
        reach = share * dip(work, mode)
    else:
        sticks = mode < 2 and work.modes[at.MODE, mode] == STICKS
        low_value = -high_value if sticks else violation(laws, work, state, mode)
        bracketed = low_value < 0.0
    side = 0
    for _ in range(_MOST_ITERATIONS):
        if bracketed:
            # Regula falsi, kept from creeping by halving the value of the end that stays (Illinois).
            reach = (low * high_value - high * low_value) / (high_value - low_value)
            if not low < reach < high or high - low < AT_ONCE:
                return min(max(reach, low), high)
        elif not dips:
            # A joint that has just begun to move has no speed yet: look for an instant at which it has.
            reach *= 0.25
            if reach < _NEAREST:
                return 2.0
        call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, reach, at.TRIAL, 0))
        value = violation(laws, work, work.states[at.TRIAL], mode)
        if dips:
            if value <= 0.0:
                return 2.0
            dips, high, high_value = False, reach, value
            low_value = violation(laws, work, state, mode)
            bracketed = low_value < 0.0
        elif not bracketed:
            if value < 0.0:
                low, low_value, bracketed = reach, value, True
        elif value > 0.0:
            high, high_value = reach, value
            if side == 1:
                low_value *= 0.5
            side = 1
        else:
            low, low_value = reach, value
            if side == -1:
                high_value *= 0.5
            side = -1
        if bracketed and abs(value) < _CLOSE:
            break
    return reach


@part
def resolving_share(laws, motion, work, step):
    """Return the largest share of a step that resolves every law that changes within a small speed or angle."""
    share, rates, state = 1.0, work.states[at.RATES_AT], work.states[at.BEGIN]
    for law in range(len(laws.table)):
        if laws.table[law, at.RESOLVES] < 0:
            continue
        scale = motion[at.VALUES + laws.table[law, at.VALUES_AT] + laws.table[law, at.RESOLVES]]
        joint = laws.table[law, at.JOINT]
        change = abs(joint_speed(rates, joint)) * step
        speed = abs(joint_speed(state, joint))
        if laws.table[law, at.KIND] & at.WITHIN_ANGLE:
            if laws.table[law, at.OWNS] > 0 and work.modes[at.MODE, 2 + laws.table[law, at.OWN_AT]] != 0:
                continue  # what it remembers stays as it is until the joint turns back
            # A step turns a joint by at most about that angle.
            share = min(share, scale / max(speed * step, math.sqrt(scale * change * step), 1e-300))
        else:
            beyond = speed - _TURNED_OVER * scale
            share = min(share, max(beyond, _RESOLVED * scale) / max(change, 1e-300))
    return max(share, _SMALLEST)


@part
def _carry_across(work, joint, before):
    """Carry derivatives across the instant at which a joint's speed is zero, given the rates of change before it.

    Those after it are in row 0.
    """
    towards = joint_speed(before, joint)
    if towards == 0.0:
        return
    slopes = work.slopes
    for d in range(np.uint64(work.directions)):
        one, two = slopes[2, at.OLD, d], slopes[3, at.OLD, d]
        late = -(one if joint == 0 else two - one) / towards
        for r in range(2, work.states.shape[1]):
            slopes[r, at.OLD, d] += (before[r] - work.states[at.RATES_AT, r]) * late


@part
def _hold_derivatives(work, joint):
    """Project derivatives on motions that a sticking joint allows, by an impulse in it that keeps its speed at zero."""
    slopes, sums = work.slopes, work.numbers
    i11, i12, i21, i22 = sums[at.INERTIAS], sums[at.INERTIAS + 1], sums[at.INERTIAS + 2], sums[at.INERTIAS + 3]
    for d in range(np.uint64(work.directions)):
        one, two = slopes[2, at.OLD, d], slopes[3, at.OLD, d]
        if joint == 0:
            slopes[2, at.OLD, d], slopes[3, at.OLD, d] = 0.0, two + i21 / i22 * one
        else:
            common = ((i11 + i21) * one + (i12 + i22) * two) / (i11 + i12 + i21 + i22)
            slopes[2, at.OLD, d], slopes[3, at.OLD, d] = common, common


def make_part(plan, motion, room, begin, step, done):
    """Make a part of a step, of which a share is done, and return which share of it that part is.

    The step begins at a time in the trial [s] and has a length [s]. Which mode ends with the part is left in the
    progress.
    """
    laws, work = unfolded(plan, room)
    derive, modes, numbers = int(plan[at.DIRECTIONS] > 0), work.modes, work.numbers
    longest = min(numbers[at.LONGEST], 1.0 - done)
    share = longest
    for law in range(len(laws.table)):
        if laws.table[law, at.RESOLVES] >= 0:
            share = min(share, resolving_share(laws, motion, work, step))
            break
    call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, share, at.END, derive))
    rough = roughness(work, share * step)
    while share > _SMALLEST and rough > 1.0:
        share *= 0.5
        longest = share
        call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, share, at.END, derive))
        rough = roughness(work, share * step)
    # A part twice as long would have 16 times the error.
    numbers[at.LONGEST] = min(1.0, 2.0 * longest) if 16.0 * rough < 1.0 else longest
    modes[at.PROGRESS, at.STOPPED] = at.NO_EVENT
    looks = False
    for mode in range(modes.shape[1] if modes[at.IS_TURNED, 0] + modes[at.IS_TURNED, 1] > 0 else 0):
        numbers[at.VIOLATIONS + mode] = violation(laws, work, work.states[at.END], mode)
        slips = mode < 2 and modes[at.IS_TURNED, mode] != 0 and modes[at.MODE, mode] != STICKS
        ends = numbers[at.VIOLATIONS + mode] > 0.0 or (slips and dip(work, mode) > 0.0)
        modes[at.IS_SOUGHT, mode] = 1 if ends else 0
        looks = looks or ends
    if looks and modes[at.PROGRESS, at.EVENTS] < _MOST_EVENTS:
        # The step is repeated, up to the instant or as before: the search overwrites its rates.
        whole = share
        copy(work.states[at.RATES_AT + 4], work.states[at.READ])
        for mode in range(modes.shape[1]):
            if modes[at.IS_SOUGHT, mode]:
                copy(work.states[at.READ], work.states[at.RATES_AT + 4])
                instant = call_for_number(plan[at.INSTANT_OF], (plan, motion, room, begin, step, done, whole, mode))
                if instant <= share:
                    share, modes[at.PROGRESS, at.STOPPED] = instant, mode
        modes[at.PROGRESS, at.EVENTS] += 1
        call(plan[at.STEP_ON], (plan, motion, room, begin, step, done, share, at.END, derive))
    if derive:
        call(plan[at.ADVANCE], (place(work.slopes, 0), share * step, plan[at.DIRECTIONS]))
    return share
