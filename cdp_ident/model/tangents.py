"""The derivatives of a motion's state, carried through the steps of the integrator (compiled).

They are side by side in lanes, in blocks of `LANES`. A block has for each number of the state some rows of lanes: see
`OLD` and what follows. All rows are in one array, and the compiler knows how far they are from each other: only so does
it see that they do not overlap, and vectorises the loops over lanes. For the same reason indices are unsigned: a
negative one would count from the array's end.
"""

import numpy as np

from cdp_ident.model.compilation import inlined, part

VECTOR = 8
"""Lanes of the widest vector register; so many directions or a multiple of them are carried."""
LANES = 72
"""Lanes of a block, most of which are used: an odd number of cache lines, so that rows do not displace each other."""
OLD, _HERE, SLOPE, NEW, FIRST, _AT = (np.uint64(LANES * row) for row in range(6))
"""Rows of a number of the state: its derivatives at the step's beginning, where a stage sets out from, their slopes at
the last stage, their values at the step's end, their slopes at its beginning, and their values at a stage."""
_ROWS = _AT + np.uint64(LANES)
"""How far numbers of the state are from each other: their rows, the last of which is `_AT`."""


@inlined
def row_of(states, block, number, row):
    """Return the index of the first lane of a row, of a number of the state in a block."""
    return (np.uint64(block) * np.uint64(states) + np.uint64(number)) * _ROWS + row


@inlined
def blocks_of(lanes):
    """Return how many blocks so many lanes are in."""
    return (lanes + LANES - 1) // LANES


@inlined
def width_of(block, lanes):
    """Return how many of a block's lanes are used."""
    return np.uint64(min(LANES, lanes - block * LANES))


@part
def tangents_of(states, lanes):
    """Return the derivatives at the beginning, by the state itself and by what has no part in it yet."""
    tangents = np.zeros(row_of(states, blocks_of(lanes), 0, OLD))
    for k in range(min(states, lanes)):
        tangents[row_of(states, 0, k, OLD) + np.uint64(k)] = 1.0
    return tangents


@part
def begin(tangents, states, lanes, weight):
    """Begin a step: the slopes there, times a weight, are the first part of what the step adds."""
    for block in range(blocks_of(lanes)):
        for k in range(states):
            first = row_of(states, block, k, OLD)
            for i in range(width_of(block, lanes)):
                old, slope = tangents[first + OLD + i], tangents[first + FIRST + i]
                tangents[first + _HERE + i] = old
                tangents[first + SLOPE + i] = slope
                tangents[first + NEW + i] = old + weight * slope


@part
def advance(tangents, offset, weight, by_state, direct):
    """Fill in the slopes at a stage, and add them times a weight to what will be at the step's end.

    Args:
        tangents: the derivatives.
        offset: for how long the last slopes are followed to the stage [s].
        weight: of the stage [s].
        by_state: (states - 2, states) derivatives of the rates of all but the angles by the state.
        direct: (states - 2, lanes) those by what each lane is a derivative by.
    """
    states, lanes = by_state.shape[1], direct.shape[1]
    s00, s01, s02, s03 = by_state[0, 0], by_state[0, 1], by_state[0, 2], by_state[0, 3]
    s10, s11, s12, s13 = by_state[1, 0], by_state[1, 1], by_state[1, 2], by_state[1, 3]
    for block in range(blocks_of(lanes)):
        lane, width = np.uint64(block * LANES), width_of(block, lanes)
        theta1 = row_of(states, block, 0, OLD)
        theta2, omega1, omega2 = theta1 + _ROWS, theta1 + np.uint64(2) * _ROWS, theta1 + np.uint64(3) * _ROWS
        if states > 4:
            for k in range(states):
                first = row_of(states, block, k, OLD)
                for i in range(width):
                    tangents[first + _AT + i] = tangents[first + _HERE + i] + offset * tangents[first + SLOPE + i]
        for i in range(width):
            t1 = tangents[theta1 + _HERE + i] + offset * tangents[theta1 + SLOPE + i]
            t2 = tangents[theta2 + _HERE + i] + offset * tangents[theta2 + SLOPE + i]
            w1 = tangents[omega1 + _HERE + i] + offset * tangents[omega1 + SLOPE + i]
            w2 = tangents[omega2 + _HERE + i] + offset * tangents[omega2 + SLOPE + i]
            a1 = s00 * t1 + s01 * t2 + s02 * w1 + s03 * w2 + direct[0, lane + i]
            a2 = s10 * t1 + s11 * t2 + s12 * w1 + s13 * w2 + direct[1, lane + i]
            tangents[theta1 + SLOPE + i] = w1
            tangents[theta2 + SLOPE + i] = w2
            tangents[omega1 + SLOPE + i] = a1
            tangents[omega2 + SLOPE + i] = a2
            tangents[theta1 + NEW + i] += weight * w1
            tangents[theta2 + NEW + i] += weight * w2
            tangents[omega1 + NEW + i] += weight * a1
            tangents[omega2 + NEW + i] += weight * a2
        if states > 4:
            _advance_own_states(tangents, block, width, weight, by_state, direct)


@part
def _advance_own_states(tangents, block, width, weight, by_state, direct):
    """Do the same for the states that effects bring: what they do to the rods, and their own rates."""
    states, lane = by_state.shape[1], np.uint64(block * LANES)
    for k in range(4, states):
        own = row_of(states, block, k, OLD)
        for rod in range(2):
            omega, factor = row_of(states, block, 2 + rod, OLD), by_state[rod, k]
            for i in range(width):
                more = factor * tangents[own + _AT + i]
                tangents[omega + SLOPE + i] += more
                tangents[omega + NEW + i] += weight * more
        for i in range(width):
            tangents[own + SLOPE + i] = direct[k - 2, lane + i]
        for other in range(states):
            at, factor = row_of(states, block, other, _AT), by_state[k - 2, other]
            if factor != 0.0:
                for i in range(width):
                    tangents[own + SLOPE + i] += factor * tangents[at + i]
        for i in range(width):
            tangents[own + NEW + i] += weight * tangents[own + SLOPE + i]


@part
def finish(tangents, by_state, direct):
    """Fill in the slopes at a step's end."""
    states, lanes = by_state.shape[1], direct.shape[1]
    for block in range(blocks_of(lanes)):
        for k in range(states):
            first = row_of(states, block, k, OLD)
            for i in range(width_of(block, lanes)):
                tangents[first + _HERE + i] = tangents[first + NEW + i]
    advance(tangents, 0.0, 0.0, by_state, direct)


@part
def accept(tangents, states, lanes):
    """Let a step's end be the next one's beginning."""
    for block in range(blocks_of(lanes)):
        for k in range(states):
            first = row_of(states, block, k, OLD)
            for i in range(width_of(block, lanes)):
                tangents[first + OLD + i] = tangents[first + NEW + i]
                tangents[first + FIRST + i] = tangents[first + SLOPE + i]


@part
def restart(tangents, by_state, direct):
    """Fill in the slopes at a step's beginning, where the motion does not go on as it did before."""
    states, lanes = by_state.shape[1], direct.shape[1]
    begin(tangents, states, lanes, 0.0)
    finish(tangents, by_state, direct)
    accept(tangents, states, lanes)


@inlined
def reading(tangents, first, lane, w_old, w_new, w_first, w_slope):
    """Return a derivative within a step, by the weights of a Hermite polynomial; `first` is the number's first row."""
    return (
        w_old * tangents[first + OLD + lane]
        + w_new * tangents[first + NEW + lane]
        + w_first * tangents[first + FIRST + lane]
        + w_slope * tangents[first + SLOPE + lane]
    )
