"""Where a step is divided: where a joint stops or breaks loose, and where a torque changes fast with speed or angle."""

import math

from cdp_ident.model.compilation import part
from cdp_ident.model.dynamics import MEMORY, STICKS, joint_speed
from cdp_ident.model.runge_kutta import step_on
from cdp_ident.model.sticking import dip, violation

_TURNED_OVER, _RESOLVED = 4.0, 0.15
"""A torque that changes within a small speed v is constant beyond so many times v; below, a step changes the joint's
speed by at most this share of v."""
_TURN = 1.0
"""A step turns a joint by at most about so many times the angle within which a torque changes."""
SMALLEST = 1.0 / 256.0
"""Smallest share of a step into which it is divided."""
_MOST_ITERATIONS = 50
AT_ONCE = 1e-13
"""Resolution of instants, as a share of the step."""
_NEAREST = 1e-9
"""A joint that begins to move and stops again within this share of a step counts as not having moved."""
_CLOSE = 1e-15
"""An instant is located when a speed [rad/s] or a torque over A22 [rad/s^2] is so close to its limit."""


@part
def share_by_speed(state, rates, table, values, step):
    """Return the largest share of a step that resolves every torque that changes within a small speed or angle."""
    share = 1.0
    for e in range(len(table)):
        if table[e, 4] >= 0:
            joint, scale = table[e, 2], values[e, table[e, 4]]
            change = abs(rates[0, 2] if joint == 0 else rates[0, 3] - rates[0, 2]) * step
            speed = abs(joint_speed(state, joint))
            if table[e, 1] == MEMORY:
                if speed > 0.0 and rates[0, table[e, 5]] == 0.0:
                    continue  # what it remembers stays as it is until the joint turns back
                longest = max(speed * step, math.sqrt(_TURN * scale * change * step), 1e-300)
                share = min(share, _TURN * scale / longest)
            else:
                beyond = speed - _TURNED_OVER * scale
                share = min(share, max(beyond, _RESOLVED * scale) / max(change, 1e-300))
    return max(share, SMALLEST)


@part
def instant_of(
    joint, given, state, done, share, step, time, inputs, modes, coefficients, table, values, lanes_of, constants,
    base, slopes, by_own, by_lane, sums, by_state, direct, at, rates, end,
):  # fmt: skip
    """Return after which share of the grid's step, up to `share`, a joint's mode ends; 2 where it does not.

    `given` is the violation of the mode at the end of that share; if it is not above zero, the joint's speed has a
    minimum on the way. The rates in row 0 are those at the beginning; the others, and `end`, are overwritten.
    """
    low, high, low_value, high_value = 0.0, share, 0.0, given
    sticks = modes[joint] == STICKS
    dips, bracketed = given <= 0.0, False
    if dips:
        reach = share * dip(joint, modes, rates)
    else:
        reach = share
        low_value = -given if sticks else -float(modes[joint]) * joint_speed(state, joint)
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
        step_on(
            state, done, reach, step, time, inputs, modes, coefficients, table, values, lanes_of, constants, base,
            slopes, by_own, by_lane, sums, by_state, direct, at, rates, end,
        )  # fmt: skip
        value = violation(end, joint, modes, sums)
        if dips:
            if value <= 0.0:
                return 2.0
            dips, high, high_value = False, reach, value
            low_value = -float(modes[joint]) * joint_speed(state, joint)
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
