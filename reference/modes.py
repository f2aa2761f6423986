# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""What joints with dry friction do, and when they stop doing so.

A joint is stuck, or slips forward or backward. It is stuck as long as the torque that keeps it so is no larger than
the static one; it slips until its rate is zero. Karnopp's (1985) modes without his band of zero speed; see Acary and
Brogliato, Numerical Methods for Nonsmooth Dynamical Systems, 2008.
"""

import numpy as np
import numpy.typing as npt

from reference.compilation import compiled
from reference.mechanics import BACKWARD, FORWARD, STUCK
from reference.stepping import STAGES, STATES, System, find_rates, joint_rate, step

Array = npt.NDArray[np.float64]

_NEAR = 2.0
"""How far beyond the accelerations at both ends of a step those within it may be."""


@compiled
def first_modes(system: System, time: float, state: Array, modes: Array) -> None:
    """Set what the joints do (2,) from a start on. One without dry friction `slips` forward at any rate."""
    dry = system[3]
    for joint in range(2):
        rate = joint_rate(state, joint)
        modes[joint] = (FORWARD if rate > 0.0 else BACKWARD if rate < 0.0 else STUCK) if dry[joint] else FORWARD
    _choose(system, time, state, modes, -1)


@compiled
def change_mode(system: System, time: float, state: Array, modes: Array, joint: int) -> None:
    """Set what the joints do (2,) from the moment on at which one of them ends what it did."""
    if modes[joint] == STUCK:
        rates, held = np.empty(STATES), np.empty((2, 2))
        find_rates(system, modes, time, state, rates, held)
        modes[joint] = BACKWARD if held[joint, 0] > 0.0 else FORWARD
        _choose(system, time, state, modes, joint)
        return
    if joint == 0:
        state[2] = 0.0
        if modes[1] == STUCK:
            state[3] = 0.0
    else:
        state[3] = state[2]
    _choose(system, time, state, modes, -1)


@compiled
def _choose(system: System, time: float, state: Array, modes: Array, loose: int) -> None:
    """Set modes that agree with the accelerations that they lead to; a joint that has just come loose keeps its own."""
    dry = system[3]
    rates, held = np.empty(STATES), np.empty((2, 2))
    given = modes.copy()
    best, best1, best2 = np.inf, given[0], given[1]
    for mode1 in (STUCK, FORWARD, BACKWARD):
        if not _possible(dry[0], loose == 0, joint_rate(state, 0), given[0], mode1):
            continue
        for mode2 in (STUCK, FORWARD, BACKWARD):
            if not _possible(dry[1], loose == 1, joint_rate(state, 1), given[1], mode2):
                continue
            modes[0], modes[1] = mode1, mode2
            find_rates(system, modes, time, state, rates, held)
            wrong = 0.0
            for joint in range(2):
                if not dry[joint] or joint == loose or joint_rate(state, joint) != 0.0:
                    continue
                if modes[joint] == STUCK:
                    needed, allowed = abs(held[joint, 0]), held[joint, 1]
                    wrong += max(0.0, needed / allowed - 1.0) if allowed > 0.0 else np.inf
                else:
                    wrong += max(0.0, -modes[joint] * joint_rate(rates, joint))
            if wrong < best:
                best, best1, best2 = wrong, mode1, mode2
    modes[0], modes[1] = best1, best2


@compiled
def _possible(dry: bool, loose: bool, rate: float, given: int, mode: int) -> bool:
    """Return whether a joint of that rate can be in a mode."""
    if loose or not dry:
        return mode == given
    return rate == 0.0 or mode * rate > 0.0


@compiled
def margin(system: System, modes: Array, joint: int, time: float, state: Array) -> float:
    """Return what falls below zero where a joint's mode ends: its rate, or what is left of the static torque."""
    if modes[joint] != STUCK:
        return modes[joint] * joint_rate(state, joint)
    rates, held = np.empty(STATES), np.empty((2, 2))
    find_rates(system, modes, time, state, rates, held)
    return held[joint, 1] - abs(held[joint, 0])


@compiled
def end_of_mode(
    system: System, modes: Array, joint: int, time: float, state: Array, h: float, end: Array, stages: Array,
    tolerance: float,
) -> float:  # fmt: skip
    """Return how long after the beginning of a step a joint's mode ends [s]; infinity where it does not within it.

    Args:
        system: what moves.
        modes: (2,) what the joints do.
        joint: 0 for the inner, 1 for the outer one.
        time: at the beginning of the step [s].
        state: (8,) at its beginning.
        h: the step [s].
        end: (8,) state at its end.
        stages: (12, 8) rates within it.
        tolerance: of the steps.
    """
    if not system[3][joint]:
        return np.inf
    there, scratch = np.empty(STATES), np.empty((STAGES, STATES))
    before = margin(system, modes, joint, time, state)
    after = margin(system, modes, joint, time + h, end)
    low, high = 0.0, h
    if after >= 0.0:
        if modes[joint] != STUCK:
            fastest = max(abs(joint_rate(stages[0], joint)), abs(joint_rate(stages[STAGES - 1], joint)))
            if min(before, after) > _NEAR * fastest * h:
                return np.inf
        # It may be below zero in between, at the bottom of a parabola.
        high = 0.5 * h
        step(system, modes, time, state, high, there, scratch, tolerance)
        half_way = margin(system, modes, joint, time + high, there)
        if half_way >= 0.0:
            slope = 4.0 * half_way - 3.0 * before - after
            bend = 2.0 * (before + after - 2.0 * half_way)
            if slope >= 0.0 or -slope >= 2.0 * bend:
                return np.inf
            high = -0.5 * slope / bend * h
            step(system, modes, time, state, high, there, scratch, tolerance)
            if margin(system, modes, joint, time + high, there) >= 0.0:
                return np.inf
    # What has just begun with nothing to spare ends after it has got some.
    while before <= 0.0 and low == 0.0 and time + high > time:
        step(system, modes, time, state, 0.5 * high, there, scratch, tolerance)
        if margin(system, modes, joint, time + 0.5 * high, there) > 0.0:
            low = 0.5 * high
        else:
            high = 0.5 * high
    while True:
        half = 0.5 * (low + high)
        if not low < half < high or time + high == time + low:
            return high
        step(system, modes, time, state, half, there, scratch, tolerance)
        if margin(system, modes, joint, time + half, there) < 0.0:
            high = half
        else:
            low = half
