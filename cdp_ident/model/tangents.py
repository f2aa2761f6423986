"""The derivatives of a motion's state, carried through the steps of the integrator (compiled).

They are side by side in lanes, in blocks of `BLOCK`. A block has for each number of the state some rows of lanes: see
`OLD` and what follows. All rows are in one array, and the compiler knows how far they are from each other: only so does
it see that they do not overlap, and vectorises the loops over lanes. For the same reason indices are unsigned: a
negative one would count from the array's end.

A step of the motion comes first, and leaves the matrices of the linearised equations at its four stages and its end;
when it is accepted, the derivatives follow it at once.
"""

import numpy as np

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.equations import RODS_STATES

VECTOR = 8
"""Lanes of the widest vector register; so many directions or a multiple of them are carried."""
BLOCK = 72
"""Lanes of a block, one for each direction, most of which are used: an odd number of cache lines, so that rows do not
displace each other."""
OLD, FIRST, NEW, SLOPE, _HERE = (np.uint64(BLOCK * row) for row in range(5))
"""Rows of a number of the state: its derivatives and their slopes at the step's beginning, both at its end, and the
derivatives at a stage, where there are more numbers than the processor has registers for."""
_ROWS = np.uint64(5 * BLOCK)
"""How far numbers of the state are from each other."""
MOST_STATES = 8
"""Numbers of a state, at most, with those that effects bring."""
STAGES = 5
"""Where a step's rates are computed: at its beginning, at three stages on the way, and at its end."""


@inlined
def row_of(states, block, number, row):
    """Return the index of the first lane of a row, of a number of the state in a block."""
    return (np.uint64(block) * np.uint64(room_for(states)) + np.uint64(number)) * _ROWS + row


@inlined
def room_for(states):
    """Return for how many numbers of the state there is room: for the rods' alone, or for as many as there can be."""
    return RODS_STATES if states == RODS_STATES else MOST_STATES


@inlined
def blocks_of(lanes):
    """Return how many blocks so many lanes are in."""
    return (lanes + BLOCK - 1) // BLOCK


@inlined
def width_of(block, lanes):
    """Return how many of a block's lanes are used."""
    return np.uint64(min(BLOCK, lanes - block * BLOCK))


@inlined
def size_of(states, lanes):
    """Return how many numbers all rows of so many lanes are."""
    return row_of(states, blocks_of(lanes), 0, OLD)


@part
def begin_tangents(tangents, states, lanes):
    """Fill in the derivatives at the beginning, by the state itself; what else there may be has no part in it yet."""
    for k in range(min(states, lanes)):
        tangents[row_of(states, 0, k, OLD) + np.uint64(k)] = 1.0


@inlined
def _matrix(by_state, stage):
    """Return the derivatives by the rods' state at a stage, which then do not lie in an array that might change."""
    return (
        by_state[stage, 0, 0], by_state[stage, 0, 1], by_state[stage, 0, 2], by_state[stage, 0, 3],
        by_state[stage, 1, 0], by_state[stage, 1, 1], by_state[stage, 1, 2], by_state[stage, 1, 3],
    )  # fmt: skip


@inlined
def rates(m, d, t1, t2, w1, w2):
    """Return the rates of change of the derivatives of the rods' speeds, by a stage's matrix and what adds to it."""
    return m[0] * t1 + m[1] * t2 + m[2] * w1 + m[3] * w2 + d[0], m[4] * t1 + m[5] * t2 + m[6] * w1 + m[7] * w2 + d[1]


@inlined
def through_step(h, m1, m2, m3, m4, d1, d2, d3, d4, t1, t2, w1, w2, a1, a2):
    """Return the derivatives of the rods' state by one direction at a step's end, and the rates of their speeds there.

    Args:
        h: length of the step [s].
        m1: (8 numbers) matrix of the rods' accelerations by their state at the first stage after the beginning.
        m2: at the second stage.
        m3: at the third.
        m4: at the end.
        d1: (2 numbers) what adds to the derivatives of the accelerations at the first stage, by the direction itself.
        d2: at the second stage.
        d3: at the third.
        d4: at the end.
        t1: derivative of theta1 at the beginning.
        t2: of theta2.
        w1: of omega1.
        w2: of omega2.
        a1: rate of that of omega1.
        a2: of that of omega2.
    """
    half, third, sixth = 0.5 * h, h / 3.0, h / 6.0
    q1, q2 = w1 + half * a1, w2 + half * a2
    b1, b2 = rates(m1, d1, t1 + half * w1, t2 + half * w2, q1, q2)
    r1, r2 = w1 + half * b1, w2 + half * b2
    c1, c2 = rates(m2, d2, t1 + half * q1, t2 + half * q2, r1, r2)
    s1, s2 = w1 + h * c1, w2 + h * c2
    e1, e2 = rates(m3, d3, t1 + h * r1, t2 + h * r2, s1, s2)
    t1 += sixth * (w1 + s1) + third * (q1 + r1)
    t2 += sixth * (w2 + s2) + third * (q2 + r2)
    w1 += sixth * (a1 + e1) + third * (b1 + c1)
    w2 += sixth * (a2 + e2) + third * (b2 + c2)
    a1, a2 = rates(m4, d4, t1, t2, w1, w2)
    return t1, t2, w1, w2, a1, a2


@inlined
def _whole_row(by_state, stage, k):
    """Return a row of a stage's matrix, where effects bring states of their own."""
    return (
        by_state[stage, k, 0], by_state[stage, k, 1], by_state[stage, k, 2], by_state[stage, k, 3],
        by_state[stage, k, 4], by_state[stage, k, 5], by_state[stage, k, 6], by_state[stage, k, 7],
    )  # fmt: skip


@inlined
def _rate(m, d, t1, t2, w1, w2, own1, own2, own3, own4):
    """Return the rate of change of one number's derivatives by its row of a stage's matrix, and what adds to it."""
    of_rods = m[0] * t1 + m[1] * t2 + m[2] * w1 + m[3] * w2
    return of_rods + (m[4] * own1 + m[5] * own2 + m[6] * own3 + m[7] * own4 + d)


@part
def advance(tangents, states, h, by_state, direct):
    """Carry the derivatives through a step: fill in those at its end, and their slopes there.

    Args:
        tangents: the derivatives.
        states: numbers of the state.
        h: length of the step [s].
        by_state: (stages, room - 2, room) derivatives of the rates of all but the angles by the state.
        direct: (stages, room - 2, lanes) those by what each lane is a derivative by.
    """
    lanes = direct.shape[2]
    if states > RODS_STATES:
        _advance_by_stages(tangents, states, h, by_state, direct)
        return
    m1, m2, m3, m4 = _matrix(by_state, 1), _matrix(by_state, 2), _matrix(by_state, 3), _matrix(by_state, 4)
    for block in range(blocks_of(lanes)):
        lane = np.uint64(block * BLOCK)
        theta1 = row_of(RODS_STATES, block, 0, OLD)
        theta2, omega1, omega2 = theta1 + _ROWS, theta1 + np.uint64(2) * _ROWS, theta1 + np.uint64(3) * _ROWS
        for i in range(width_of(block, lanes)):
            t1, t2, w1, w2, a1, a2 = through_step(
                h, m1, m2, m3, m4,
                (direct[1, 0, lane + i], direct[1, 1, lane + i]), (direct[2, 0, lane + i], direct[2, 1, lane + i]),
                (direct[3, 0, lane + i], direct[3, 1, lane + i]), (direct[4, 0, lane + i], direct[4, 1, lane + i]),
                tangents[theta1 + OLD + i], tangents[theta2 + OLD + i],
                tangents[omega1 + OLD + i], tangents[omega2 + OLD + i],
                tangents[omega1 + FIRST + i], tangents[omega2 + FIRST + i],
            )  # fmt: skip
            tangents[theta1 + NEW + i], tangents[theta2 + NEW + i] = t1, t2
            tangents[omega1 + NEW + i], tangents[omega2 + NEW + i] = w1, w2
            tangents[theta1 + SLOPE + i], tangents[theta2 + SLOPE + i] = w1, w2
            tangents[omega1 + SLOPE + i], tangents[omega2 + SLOPE + i] = a1, a2


@part
def _advance_by_stages(tangents, states, h, by_state, direct):
    """Do the same where effects bring states of their own: stage by stage, for there are not registers enough."""
    lanes = direct.shape[2]
    for block in range(blocks_of(lanes)):
        width = width_of(block, lanes)
        for k in range(states):
            row = row_of(states, block, k, OLD)
            for i in range(width):
                old, rate = tangents[row + OLD + i], tangents[row + FIRST + i]
                tangents[row + NEW + i] = old + h / 6.0 * rate
                tangents[row + _HERE + i] = old + 0.5 * h * rate
        for stage in range(1, 4):
            _fill_in_rates(tangents, states, block, stage, by_state, direct)
            weight, ahead = (h / 6.0 if stage == 3 else h / 3.0), (0.5 * h if stage == 1 else h)
            for k in range(states):
                row = row_of(states, block, k, OLD)
                for i in range(width):
                    rate = tangents[row + SLOPE + i]
                    new = tangents[row + NEW + i] + weight * rate
                    tangents[row + NEW + i] = new
                    tangents[row + _HERE + i] = new if stage == 3 else tangents[row + OLD + i] + ahead * rate
        _fill_in_rates(tangents, states, block, 4, by_state, direct)


@part
def _fill_in_rates(tangents, states, block, stage, by_state, direct):
    """Fill in the slopes at a stage, of as many numbers of the state as there is room for."""
    t1, lane = row_of(states, block, 0, OLD), np.uint64(block * BLOCK)
    t2, w1, w2, own1 = t1 + _ROWS, t1 + np.uint64(2) * _ROWS, t1 + np.uint64(3) * _ROWS, t1 + np.uint64(4) * _ROWS
    own2, own3, own4 = own1 + _ROWS, own1 + np.uint64(2) * _ROWS, own1 + np.uint64(3) * _ROWS
    m1, m2, m3 = _whole_row(by_state, stage, 0), _whole_row(by_state, stage, 1), _whole_row(by_state, stage, 2)
    m4, m5, m6 = _whole_row(by_state, stage, 3), _whole_row(by_state, stage, 4), _whole_row(by_state, stage, 5)
    for i in range(width_of(block, direct.shape[2])):
        at1, at2, at3, at4 = (
            tangents[t1 + _HERE + i], tangents[t2 + _HERE + i], tangents[w1 + _HERE + i], tangents[w2 + _HERE + i]
        )  # fmt: skip
        at5, at6, at7, at8 = (
            tangents[own1 + _HERE + i], tangents[own2 + _HERE + i], tangents[own3 + _HERE + i],
            tangents[own4 + _HERE + i],
        )  # fmt: skip
        tangents[t1 + SLOPE + i] = at3
        tangents[t2 + SLOPE + i] = at4
        tangents[w1 + SLOPE + i] = _rate(m1, direct[stage, 0, lane + i], at1, at2, at3, at4, at5, at6, at7, at8)
        tangents[w2 + SLOPE + i] = _rate(m2, direct[stage, 1, lane + i], at1, at2, at3, at4, at5, at6, at7, at8)
        tangents[own1 + SLOPE + i] = _rate(m3, direct[stage, 2, lane + i], at1, at2, at3, at4, at5, at6, at7, at8)
        tangents[own2 + SLOPE + i] = _rate(m4, direct[stage, 3, lane + i], at1, at2, at3, at4, at5, at6, at7, at8)
        tangents[own3 + SLOPE + i] = _rate(m5, direct[stage, 4, lane + i], at1, at2, at3, at4, at5, at6, at7, at8)
        tangents[own4 + SLOPE + i] = _rate(m6, direct[stage, 5, lane + i], at1, at2, at3, at4, at5, at6, at7, at8)


@part
def restart(tangents, states, by_state, direct):
    """Fill in the slopes at a step's beginning, where the motion does not go on as it did before.

    Args:
        tangents: the derivatives.
        states: numbers of the state.
        by_state: as `advance` takes them; those at the beginning are used.
        direct: likewise.
    """
    lanes = direct.shape[2]
    m = _matrix(by_state, 0)
    for block in range(blocks_of(lanes)):
        width, lane = width_of(block, lanes), np.uint64(block * BLOCK)
        t1 = row_of(states, block, 0, OLD)
        t2, w1, w2 = t1 + _ROWS, t1 + np.uint64(2) * _ROWS, t1 + np.uint64(3) * _ROWS
        if states == RODS_STATES:
            for i in range(width):
                a1, a2 = rates(m, (direct[0, 0, lane + i], direct[0, 1, lane + i]), tangents[t1 + i], tangents[t2 + i],
                               tangents[w1 + i], tangents[w2 + i])  # fmt: skip
                tangents[t1 + FIRST + i], tangents[t2 + FIRST + i] = tangents[w1 + i], tangents[w2 + i]
                tangents[w1 + FIRST + i], tangents[w2 + FIRST + i] = a1, a2
        else:
            for k in range(states):
                row = row_of(states, block, k, OLD)
                for i in range(width):
                    tangents[row + _HERE + i] = tangents[row + i]
            _fill_in_rates(tangents, states, block, 0, by_state, direct)
            for k in range(states):
                row = row_of(states, block, k, OLD)
                for i in range(width):
                    tangents[row + FIRST + i] = tangents[row + SLOPE + i]


@part
def accept(tangents, states, lanes):
    """Let a step's end be the next one's beginning."""
    for block in range(blocks_of(lanes)):
        for k in range(states):
            first = row_of(states, block, k, OLD)
            for i in range(width_of(block, lanes)):
                tangents[first + OLD + i] = tangents[first + NEW + i]
                tangents[first + FIRST + i] = tangents[first + SLOPE + i]


@inlined
def reading(tangents, first, lane, w_old, w_new, w_first, w_slope):
    """Return a derivative within a step, by the weights of a Hermite polynomial; `first` is the number's first row."""
    return (
        w_old * tangents[first + OLD + lane]
        + w_new * tangents[first + NEW + lane]
        + w_first * tangents[first + FIRST + lane]
        + w_slope * tangents[first + SLOPE + lane]
    )
