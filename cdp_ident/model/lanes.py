"""A step of several motions with their derivatives, the motions side by side in lanes (compiled).

What belongs to the motions is in rows of one number for each, in three arrays: of the motion itself, of the stages of a
step, and of the derivatives in pairs, one row for each rod. Within one array the compiler knows how far those rows are
from each other that a loop is about: only so does it see that they do not overlap, and vectorises the loops over lanes.
For the same reason indices are unsigned, for a negative one would count from the array's end, and the loops are handed
their length, though it is always `LANES`: those whose length is known are unrolled before they would be vectorised.
"""

import numpy as np

from cdp_ident.model.compilation import inlined, part
from cdp_ident.model.equations import RODS_STATES, acceleration_derivatives, sines_and_cosines
from cdp_ident.model.parameters import COEFFICIENTS
from cdp_ident.model.tangents import STAGES, rates, through_step

LANES = 8
"""Motions side by side: as many as fit into the widest vector register."""
_COEFFICIENTS = len(COEFFICIENTS)
_PAIRS = 2 * (RODS_STATES + _COEFFICIENTS)
"""Rows of one number for each rod and each direction: those of the initial state, then the coefficients."""

# Rows of a motion: where each kind begins.
OF_COEFFICIENTS = 0
LENGTH = OF_COEFFICIENTS + _COEFFICIENTS
"""The step's length [s]."""
ROUGHNESS = LENGTH + 1
"""The largest difference between the rates at the last stage and at the end: see `is_too_rough`."""
WEIGHTS = ROUGHNESS + 1
"""Weights of a Hermite polynomial by which a measurement is read."""
STATE = WEIGHTS + 4
"""The state at the step's beginning."""
_HERE = STATE + RODS_STATES
"""The state at a stage, and then at the step's end."""
MOTION = _HERE + RODS_STATES
"""How many rows a motion has."""

# Rows of a stage.
INPUT = 0
"""The cart's acceleration."""
_RATES = INPUT + 1
"""The state's rates."""
_MATRIX = _RATES + RODS_STATES
"""The derivatives of the accelerations by the state."""
_DIRECT = _MATRIX + 2 * RODS_STATES
"""Those by the directions themselves, zero for the initial state."""
STAGE = _DIRECT + _PAIRS
"""How many rows a stage has."""

# Rows of the derivatives.
_ANGLES, _SPEEDS, _SLOPES = 0, _PAIRS, 2 * _PAIRS
"""The derivatives of the angles, of the speeds, and the rates of these."""
TANGENTS = 3 * _PAIRS
"""How many rows the derivatives have."""

READING = RODS_STATES + _PAIRS
"""Rows of a measurement: the state, and the derivatives of both angles by each direction."""


@inlined
def row(number):
    """Return the index of a row's first lane."""
    return np.uint64(LANES) * np.uint64(number)


@inlined
def _matrix_of(stages, stage, i):
    """Return a lane's matrix at a stage."""
    first = row(stage * STAGE + _MATRIX) + i
    return (
        stages[first], stages[first + row(1)], stages[first + row(2)], stages[first + row(3)],
        stages[first + row(4)], stages[first + row(5)], stages[first + row(6)], stages[first + row(7)],
    )  # fmt: skip


@inlined
def _direct_of(stages, stage, d, i):
    """Return what a direction adds to both accelerations' derivatives at a stage, in a lane."""
    first = row(stage * STAGE + _DIRECT) + row(2 * d) + i
    return stages[first], stages[first + row(1)]


@part
def _fill_in_lanes(motion, stages, stage, width):
    """Fill in the rates at a stage and their derivatives."""
    first = row(stage * STAGE)
    for i in range(width):
        at, c = row(_HERE) + i, row(OF_COEFFICIENTS) + i
        omega1, omega2 = motion[at + row(2)], motion[at + row(3)]
        alpha1, alpha2, _, by_state, by_coefficient = acceleration_derivatives(
            sines_and_cosines(motion[at], motion[at + row(1)]), omega1, omega2, stages[first + row(INPUT) + i],
            motion[c], motion[c + row(1)], motion[c + row(2)], motion[c + row(3)], motion[c + row(4)],
            motion[c + row(5)], motion[c + row(6)], 0.0, 0.0,
        )  # fmt: skip
        rate, matrix = first + row(_RATES) + i, first + row(_MATRIX) + i
        direct = first + row(_DIRECT + 2 * RODS_STATES) + i
        stages[rate], stages[rate + row(1)] = omega1, omega2
        stages[rate + row(2)], stages[rate + row(3)] = alpha1, alpha2
        for k in range(RODS_STATES):
            stages[matrix + row(k)], stages[matrix + row(RODS_STATES + k)] = by_state[k]
        for k in range(_COEFFICIENTS):
            stages[direct + row(2 * k)], stages[direct + row(2 * k + 1)] = by_coefficient[k]


@part
def begin_lanes(motion, stages, tangents, directions, width):
    """Begin a motion in each lane: fill in the derivatives at its beginning, and all rates there."""
    for i in range(row(RODS_STATES)):
        motion[row(_HERE) + i] = motion[row(STATE) + i]
    _fill_in_lanes(motion, stages, 0, width)
    for d in range(directions):
        t1, t2 = 1.0 if d == 0 else 0.0, 1.0 if d == 1 else 0.0
        w1, w2 = 1.0 if d == 2 else 0.0, 1.0 if d == 3 else 0.0
        for i in range(width):
            first = row(2 * d) + i
            angle, speed, slope = first + row(_ANGLES), first + row(_SPEEDS), first + row(_SLOPES)
            a1, a2 = rates(_matrix_of(stages, 0, i), _direct_of(stages, 0, d, i), t1, t2, w1, w2)
            tangents[angle], tangents[angle + row(1)] = t1, t2
            tangents[speed], tangents[speed + row(1)] = w1, w2
            tangents[slope], tangents[slope + row(1)] = a1, a2


@inlined
def _rate_of(stages, stage, r, i):
    """Return the rate of a number of a lane's state at a stage."""
    return stages[row(stage * STAGE) + row(_RATES + r) + i]


@part
def step_lanes(motion, stages, width):
    """Make one Runge-Kutta step in each lane; the rates at its beginning are there already."""
    for stage in range(1, STAGES - 1):
        share = 1.0 if stage == 3 else 0.5
        for i in range(width):
            h = share * motion[row(LENGTH) + i]
            for r in range(RODS_STATES):
                motion[row(_HERE + r) + i] = motion[row(STATE + r) + i] + h * _rate_of(stages, stage - 1, r, i)
        _fill_in_lanes(motion, stages, stage, width)
    for i in range(width):
        sixth = motion[row(LENGTH) + i] / 6.0
        for r in range(RODS_STATES):
            motion[row(_HERE + r) + i] = motion[row(STATE + r) + i] + sixth * (
                _rate_of(stages, 0, r, i)
                + 2.0 * _rate_of(stages, 1, r, i)
                + 2.0 * _rate_of(stages, 2, r, i)
                + _rate_of(stages, 3, r, i)
            )
    _fill_in_lanes(motion, stages, 4, width)
    for i in range(width):
        largest = 0.0
        for r in range(RODS_STATES):
            largest = max(largest, abs(_rate_of(stages, 4, r, i) - _rate_of(stages, 3, r, i)))
        motion[row(ROUGHNESS) + i] = largest


@part
def advance_lanes(motion, stages, old, new, directions, width):
    """Carry the derivatives through the step, from those at its beginning to those at its end."""
    for d in range(directions):
        for i in range(width):
            first = row(2 * d) + i
            angle, speed, slope = first + row(_ANGLES), first + row(_SPEEDS), first + row(_SLOPES)
            t1, t2, w1, w2, a1, a2 = through_step(
                motion[row(LENGTH) + i],
                _matrix_of(stages, 1, i), _matrix_of(stages, 2, i), _matrix_of(stages, 3, i), _matrix_of(stages, 4, i),
                _direct_of(stages, 1, d, i), _direct_of(stages, 2, d, i),
                _direct_of(stages, 3, d, i), _direct_of(stages, 4, d, i),
                old[angle], old[angle + row(1)], old[speed], old[speed + row(1)], old[slope], old[slope + row(1)],
            )  # fmt: skip
            new[angle], new[angle + row(1)] = t1, t2
            new[speed], new[speed + row(1)] = w1, w2
            new[slope], new[slope + row(1)] = a1, a2


@inlined
def _read_lane(motion, i, old, new, first, last):
    """Return a lane's measurement, by the weights and what they are of."""
    w = row(WEIGHTS) + i
    return motion[w] * old + motion[w + row(1)] * new + motion[w + row(2)] * first + motion[w + row(3)] * last


@part
def read_lanes(motion, stages, old, new, reading, directions, width):
    """Fill in a measurement within the step, by the weights that are there."""
    for i in range(width):
        for r in range(RODS_STATES):
            reading[row(r) + i] = _read_lane(
                motion, i, motion[row(STATE + r) + i], motion[row(_HERE + r) + i], _rate_of(stages, 0, r, i),
                _rate_of(stages, 4, r, i),
            )  # fmt: skip
    for k in range(2 * directions):
        for i in range(width):
            # The angles' derivatives change by those of the speeds.
            angle, speed = row(k) + row(_ANGLES) + i, row(k) + row(_SPEEDS) + i
            weighted = _read_lane(motion, i, old[angle], new[angle], old[speed], new[speed])
            reading[row(k) + row(RODS_STATES) + i] = weighted


@part
def hold_back(motion, stages, old, new, directions, lane):
    """Let a lane be at the step's end where it was at its beginning."""
    for r in range(RODS_STATES):
        motion[row(_HERE + r) + lane] = motion[row(STATE + r) + lane]
        stages[row(4 * STAGE + _RATES + r) + lane] = stages[row(_RATES + r) + lane]
    for k in range(2 * directions):
        for kind in range(3):
            place = row(kind * _PAIRS) + row(k) + lane
            new[place] = old[place]


@part
def go_on(motion, stages):
    """Let the motions' end of the step be the next one's beginning; the derivatives at either change their places."""
    for i in range(row(RODS_STATES)):
        motion[row(STATE) + i] = motion[row(_HERE) + i]
        stages[row(_RATES) + i] = stages[row(4 * STAGE + _RATES) + i]
