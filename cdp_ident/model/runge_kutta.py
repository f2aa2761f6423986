# Copyright 2026 cdp_ident maintainers
# SPDX-License-Identifier: Apache-2.0
"""One step of the integrator, and the derivatives of the state carried along (compiled).

The derivatives, by the state at the beginning, by coefficients and by parameters, go through the same steps as the
state (the tangent linear model of the integrator), all directions side by side.
"""

import numpy as np
from numba import float64, int64, void

from cdp_ident.machine.calls import INDICES, NUMBERS, call
from cdp_ident.machine.compilation import inlined, part
from cdp_ident.model import layout as at
from cdp_ident.model.layout import unfolded
from cdp_ident.model.rates import STICKS

_ROUGH = 3e-6
"""Largest error estimate of a step: see `roughness`."""


@inlined
def input_at(work, share):
    """Return the cart's acceleration at a share of the step, from those at its beginning, middle and end."""
    first, middle, last = (
        work.numbers[at.CART_INPUTS], work.numbers[at.CART_INPUTS + 1], work.numbers[at.CART_INPUTS + 2]
    )  # fmt: skip
    return first * (1.0 - share) * (1.0 - 2.0 * share) + share * (
        4.0 * middle * (1.0 - share) + last * (2.0 * share - 1.0)
    )


@part
def stop(state, joint):
    """Set a joint's speed to exactly zero."""
    if joint == 0:
        state[2] = 0.0
    else:
        state[3] = state[2]


def step_on(plan, motion, room, begin, step, done, share, end, derive):
    """Make one Runge-Kutta step of a share of the grid's, from the share `done` on.

    The rates at its beginning are in row 0 already; the last row is at its end.

    Args:
        plan: memory with the laws.
        motion: what gives the motion.
        room: memory to work in.
        begin: time in the trial at the beginning of the grid's step [s].
        step: its length [s].
        done: share of it that is done.
        share: that is to be done.
        end: the row of the states that takes the state at its end.
        derive: whether the jacobians of derivatives are wanted.
    """
    _, work = unfolded(plan, room)
    states = work.states
    h, n = share * step, states.shape[1]
    for stage in range(1, at.STAGES):
        there = done + (0.5 * share if stage < 3 else share)
        row = at.HERE
        if stage < 4:
            offset = h if stage == 3 else 0.5 * h
            for r in range(n):
                states[at.HERE, r] = states[at.BEGIN, r] + offset * states[at.RATES_AT + stage - 1, r]
        else:
            # The rates at the end are the next step's first, and give the measurements in this one their slopes.
            row = end
            for r in range(n):
                states[end, r] = states[at.BEGIN, r] + h / 6.0 * (
                    states[at.RATES_AT, r]
                    + states[at.RATES_AT + 3, r]
                    + 2.0 * (states[at.RATES_AT + 1, r] + states[at.RATES_AT + 2, r])
                )
            for joint in range(2):
                if work.modes[at.MODE, joint] == STICKS:
                    stop(states[end], joint)
        t, u = begin + there * step, input_at(work, there)
        call(plan[at.FILL_RATES], (plan, motion, room, row, t, u, stage, derive))


@inlined
def roughness(work, h):
    """Return the error of a step over the largest allowed: the rates at its last stage and its end differ by it."""
    largest = 0.0
    for r in range(work.states.shape[1]):
        largest = max(largest, abs(work.states[at.RATES_AT + 4, r] - work.states[at.RATES_AT + 3, r]))
    return h * largest / (6.0 * _ROUGH)


@inlined
def hermite(s, h):
    """Return the weights of both ends' values, and of both ends' slopes, at a share of a step of a length [s]."""
    square = (1.0 - s) * (1.0 - s)
    return (1.0 + 2.0 * s) * square, s * s * (3.0 - 2.0 * s), h * s * square, h * s * s * (s - 1.0)


@part
def fill_first_slopes(work):
    """Fill in the slopes of the derivatives at a step's beginning."""
    slopes, matrices, n = work.slopes, work.matrices, work.states.shape[1]
    for d in range(work.directions):
        slopes[0, at.OLD_SLOPE, d], slopes[1, at.OLD_SLOPE, d] = slopes[2, at.OLD, d], slopes[3, at.OLD, d]
        for r in range(2, n):
            total = slopes[r, at.DIRECT, d]
            for k in range(n):
                total += matrices[0, r, k] * slopes[k, at.OLD, d]
            slopes[r, at.OLD_SLOPE, d] = total


@part
def accept(work):
    """Let a step's end be the next one's beginning."""
    for r in range(work.states.shape[1]):
        work.states[at.BEGIN, r] = work.states[at.END, r]
        for d in range(np.uint64(work.directions)):
            work.slopes[r, at.OLD, d] = work.slopes[r, at.NEW, d]
            work.slopes[r, at.OLD_SLOPE, d] = work.slopes[r, at.NEW_SLOPE, d]


OF_STEP_ON = void(INDICES, NUMBERS, NUMBERS, float64, float64, float64, float64, int64, int64)
"""Signature of `step_on`."""
