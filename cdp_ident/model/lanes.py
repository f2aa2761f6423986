"""A step of several motions with their derivatives, the motions side by side in lanes (compiled): see `lane_rows`."""

from cdp_ident.model.compilation import Compilable, inlined, part
from cdp_ident.model.dynamics import COUPLING, STICKS
from cdp_ident.model.effects.effect import MOST_OF_A_LAW
from cdp_ident.model.equations import (
    RODS_STATES,
    acceleration_derivatives,
    accelerations,
    inertia_between,
    response,
    sines_and_cosines,
    solved,
    torques_on_rods,
)
from cdp_ident.model.lane_rows import (
    ANGLES,
    BEFORE_PARAMETERS,
    BY_COEFFICIENTS,
    BY_STATE,
    CONSTANTS,
    COUPLED,
    DIRECT,
    HERE,
    INPUT,
    LENGTH,
    MATRIX,
    MODES,
    OF_COEFFICIENTS,
    RATES,
    RESPONSE,
    ROUGHNESS,
    SLOPES,
    SPEEDS,
    STAGE,
    STATE,
    TORQUES,
    TURNED,
    VALUES,
    WEIGHTS,
    row,
)
from cdp_ident.model.parameters import COEFFICIENTS
from cdp_ident.model.tangents import STAGES, through_step
from cdp_ident.model.torques_in_lanes import fill_in_torques, turn

_COEFFICIENTS = len(COEFFICIENTS)
_KINDS = SPEEDS - ANGLES
"""How far kinds of derivatives are from each other."""


@inlined
def _matrix_of(stages, stage, i):
    """Return a lane's matrix at a stage."""
    first = row(stage * STAGE + MATRIX) + i
    return (
        stages[first], stages[first + row(1)], stages[first + row(2)], stages[first + row(3)],
        stages[first + row(4)], stages[first + row(5)], stages[first + row(6)], stages[first + row(7)],
    )  # fmt: skip


@inlined
def _direct_of(stages, stage, d, i):
    """Return what a direction adds to both accelerations' derivatives at a stage, in a lane."""
    first = row(stage * STAGE + DIRECT) + row(2 * d) + i
    return stages[first], stages[first + row(1)]


@part
def _fill_in_lanes(motion, stages, stage, directions, width, table, lanes_of):
    """Fill in the rates at a stage and, where there are directions, their derivatives."""
    first = row(stage * STAGE)
    if directions == 0:
        for i in range(width):
            at, c, rate = row(HERE) + i, row(OF_COEFFICIENTS) + i, first + row(RATES) + i
            omega1, omega2 = motion[at + row(2)], motion[at + row(3)]
            alpha1, alpha2 = accelerations(
                sines_and_cosines(motion[at], motion[at + row(1)]), omega1, omega2, stages[first + row(INPUT) + i],
                motion[c], motion[c + row(1)], motion[c + row(2)], motion[c + row(3)], motion[c + row(4)],
                motion[c + row(5)], motion[c + row(6)],
            )  # fmt: skip
            stages[rate], stages[rate + row(1)] = omega1, omega2
            stages[rate + row(2)], stages[rate + row(3)] = alpha1, alpha2
        return
    for i in range(width):
        at, c = row(HERE) + i, row(OF_COEFFICIENTS) + i
        omega1, omega2 = motion[at + row(2)], motion[at + row(3)]
        alpha1, alpha2, _, by_state, by_coefficient = acceleration_derivatives(
            sines_and_cosines(motion[at], motion[at + row(1)]), omega1, omega2, stages[first + row(INPUT) + i],
            motion[c], motion[c + row(1)], motion[c + row(2)], motion[c + row(3)], motion[c + row(4)],
            motion[c + row(5)], motion[c + row(6)], 0.0, 0.0,
        )  # fmt: skip
        rate, matrix = first + row(RATES) + i, first + row(MATRIX) + i
        direct = first + row(DIRECT + 2 * RODS_STATES) + i
        stages[rate], stages[rate + row(1)] = omega1, omega2
        stages[rate + row(2)], stages[rate + row(3)] = alpha1, alpha2
        for k in range(RODS_STATES):
            stages[matrix + row(k)], stages[matrix + row(RODS_STATES + k)] = by_state[k]
        for k in range(_COEFFICIENTS):
            stages[direct + row(2 * k)], stages[direct + row(2 * k + 1)] = by_coefficient[k]


@part
def _fill_in_with_torques(motion, stages, stage, directions, width, table, lanes_of):
    """Fill in the rates at a stage and their derivatives, where effects act."""
    turn(motion, width)
    fill_in_torques(motion, stages, stage, directions, width, table, lanes_of)
    first = row(stage * STAGE)
    if directions == 0:
        for i in range(width):
            at, c, t, torques = row(HERE) + i, row(OF_COEFFICIENTS) + i, row(TURNED) + i, row(TORQUES) + i
            turned = motion[t], motion[t + row(1)], motion[t + row(2)], motion[t + row(3)]
            omega1, omega2 = motion[at + row(2)], motion[at + row(3)]
            n1, n2 = torques_on_rods(
                turned, omega1, omega2, stages[first + row(INPUT) + i], motion[c], motion[c + row(2)],
                motion[c + row(3)], motion[c + row(4)], motion[c + row(5)], motion[c + row(6)], motion[torques],
                motion[torques + row(1)],
            )  # fmt: skip
            by_torques = response(
                motion[c + row(1)], inertia_between(turned, motion[c], motion[row(COUPLED) + i]),
                motion[row(MODES) + i] == STICKS, motion[row(MODES + 1) + i] == STICKS,
            )  # fmt: skip
            rate = first + row(RATES) + i
            stages[rate], stages[rate + row(1)] = omega1, omega2
            stages[rate + row(2)], stages[rate + row(3)] = solved(by_torques, n1, n2)
        return
    for i in range(width):
        at, c, t, torques = row(HERE) + i, row(OF_COEFFICIENTS) + i, row(TURNED) + i, row(TORQUES) + i
        omega1, omega2 = motion[at + row(2)], motion[at + row(3)]
        alpha1, alpha2, by_torques, by_state, by_coefficient = acceleration_derivatives(
            (motion[t], motion[t + row(1)], motion[t + row(2)], motion[t + row(3)]),
            omega1, omega2, stages[first + row(INPUT) + i], motion[c], motion[c + row(1)], motion[c + row(2)],
            motion[c + row(3)], motion[c + row(4)], motion[c + row(5)], motion[c + row(6)],
            motion[torques], motion[torques + row(1)], motion[row(COUPLED) + i],
            motion[row(MODES) + i] == STICKS, motion[row(MODES + 1) + i] == STICKS,
        )  # fmt: skip
        rate, matrix = first + row(RATES) + i, first + row(MATRIX) + i
        direct = first + row(DIRECT + 2 * RODS_STATES) + i
        stages[rate], stages[rate + row(1)] = omega1, omega2
        stages[rate + row(2)], stages[rate + row(3)] = alpha1, alpha2
        for k in range(RODS_STATES):
            by = row(BY_STATE + k) + i
            e1, e2 = solved(by_torques, motion[by], motion[by + row(RODS_STATES)])
            stages[matrix + row(k)], stages[matrix + row(RODS_STATES + k)] = by_state[k][0] + e1, by_state[k][1] + e2
        for k in range(_COEFFICIENTS):
            by = row(BY_COEFFICIENTS + k) + i
            e1, e2 = solved(by_torques, motion[by], motion[by + row(_COEFFICIENTS)])
            stages[direct + row(2 * k)] = by_coefficient[k][0] + e1
            stages[direct + row(2 * k + 1)] = by_coefficient[k][1] + e2
        at = row(RESPONSE) + i
        motion[at], motion[at + row(1)], motion[at + row(2)], motion[at + row(3)] = by_torques
    for d in range(BEFORE_PARAMETERS, directions):
        for i in range(width):
            direct = first + row(DIRECT + 2 * d) + i
            e1, e2 = solved(_response_of(motion, i), stages[direct], stages[direct + row(1)])
            stages[direct], stages[direct + row(1)] = e1, e2
    for e in range(len(table)):
        if table[e, 1] == COUPLING and lanes_of[e, 0] >= 0 and directions > BEFORE_PARAMETERS:
            of_direction = first + row(DIRECT + 2 * (BEFORE_PARAMETERS + lanes_of[e, 0]))
            for i in range(width):
                rate, direct = first + row(RATES) + i, of_direction + i
                e1, e2 = solved(_response_of(motion, i), -stages[rate + row(3)], -stages[rate + row(2)])
                stages[direct], stages[direct + row(1)] = e1, e2


@inlined
def _response_of(motion, i):
    """Return a lane's response to torques."""
    at = row(RESPONSE) + i
    return motion[at], motion[at + row(1)], motion[at + row(2)], motion[at + row(3)]


@part
def begin_lane(motion, tangents, directions, lane, coefficients, start, values, constants):
    """Begin a motion in a lane: fill in what is its own, its state, and the derivatives at its beginning.

    Args:
        motion: rows of the motions.
        tangents: rows of the derivatives.
        directions: of derivatives.
        lane: which.
        coefficients: (7,) of the motion.
        start: (4,) its state at the beginning.
        values: (effects, p) the effects' parameters.
        constants: of the mechanism.
    """
    for r in range(_COEFFICIENTS):
        motion[row(OF_COEFFICIENTS + r) + lane] = coefficients[r]
    for r in range(RODS_STATES):
        motion[row(STATE + r) + lane] = start[r]
    for c in range(len(constants)):
        motion[row(CONSTANTS + c) + lane] = constants[c]
    for e in range(len(values)):
        for p in range(MOST_OF_A_LAW):
            motion[row(VALUES + MOST_OF_A_LAW * e + p) + lane] = values[e, p]
    for d in range(directions):
        angle, speed = row(ANGLES + 2 * d) + lane, row(SPEEDS + 2 * d) + lane
        tangents[angle], tangents[angle + row(1)] = 1.0 if d == 0 else 0.0, 1.0 if d == 1 else 0.0
        tangents[speed], tangents[speed + row(1)] = 1.0 if d == 2 else 0.0, 1.0 if d == 3 else 0.0


@part
def set_out(motion, stages, tangents, directions, lane, u):
    """Let a motion set out in a lane where no effect acts: fill in its rates at the beginning, the cart's being u."""
    at, c = row(STATE) + lane, row(OF_COEFFICIENTS) + lane
    omega1, omega2 = motion[at + row(2)], motion[at + row(3)]
    alpha1, alpha2, _, by_state, by_coefficient = acceleration_derivatives(
        sines_and_cosines(motion[at], motion[at + row(1)]), omega1, omega2, u, motion[c], motion[c + row(1)],
        motion[c + row(2)], motion[c + row(3)], motion[c + row(4)], motion[c + row(5)], motion[c + row(6)], 0.0, 0.0,
    )  # fmt: skip
    rate = row(RATES) + lane
    stages[rate], stages[rate + row(1)] = omega1, omega2
    stages[rate + row(2)], stages[rate + row(3)] = alpha1, alpha2
    for d in range(directions):
        # By the state the speeds' derivatives are one or zero, and by coefficients nothing has changed yet.
        slope = row(SLOPES + 2 * d) + lane
        tangents[slope], tangents[slope + row(1)] = by_state[d] if d < RODS_STATES else by_coefficient[d - RODS_STATES]


@inlined
def _rate_of(stages, stage, r, i):
    """Return the rate of a number of a lane's state at a stage."""
    return stages[row(stage * STAGE) + row(RATES + r) + i]


def _step(fill_in: Compilable, acts: bool) -> Compilable:
    """Return a Runge-Kutta step in each lane, by what fills in the rates at a stage."""

    def step(motion, stages, directions, width, table, lanes_of):
        for stage in range(1, STAGES - 1):
            share = 1.0 if stage == 3 else 0.5
            for i in range(width):
                h = share * motion[row(LENGTH) + i]
                for r in range(RODS_STATES):
                    motion[row(HERE + r) + i] = motion[row(STATE + r) + i] + h * _rate_of(stages, stage - 1, r, i)
            fill_in(motion, stages, stage, directions, width, table, lanes_of)
        for i in range(width):
            sixth = motion[row(LENGTH) + i] / 6.0
            for r in range(RODS_STATES):
                motion[row(HERE + r) + i] = motion[row(STATE + r) + i] + sixth * (
                    _rate_of(stages, 0, r, i)
                    + 2.0 * _rate_of(stages, 1, r, i)
                    + 2.0 * _rate_of(stages, 2, r, i)
                    + _rate_of(stages, 3, r, i)
                )
        if acts:
            # What sticks is held exactly, not but for rounding.
            for i in range(width):
                omega1, omega2 = motion[row(HERE + 2) + i], motion[row(HERE + 3) + i]
                omega1 = 0.0 if motion[row(MODES) + i] == STICKS else omega1
                motion[row(HERE + 2) + i] = omega1
                motion[row(HERE + 3) + i] = omega1 if motion[row(MODES + 1) + i] == STICKS else omega2
        fill_in(motion, stages, 4, directions, width, table, lanes_of)
        for i in range(width):
            largest = 0.0
            for r in range(RODS_STATES):
                largest = max(largest, abs(_rate_of(stages, 4, r, i) - _rate_of(stages, 3, r, i)))
            motion[row(ROUGHNESS) + i] = largest

    step.__name__ = step.__qualname__ = "step_with_torques" if acts else "step_alone"
    return part(step)


step_lanes = _step(_fill_in_lanes, acts=False)
"""Make one Runge-Kutta step in each lane, where no effect acts; the rates at its beginning are there already.

`step_lanes(motion, stages, directions, width, table, lanes_of)` takes the rows of the motions and of their stages, how
many directions there are, `LANES`, and the effects and the lanes of their parameters, as `Torques` has them.
"""
step_with_torques = _step(_fill_in_with_torques, acts=True)
"""Do the same where effects act."""


@part
def advance_lanes(motion, stages, old, new, directions, width):
    """Carry the derivatives through the step, from those at its beginning to those at its end."""
    for d in range(directions):
        for i in range(width):
            first = row(2 * d) + i
            angle, speed, slope = first + row(ANGLES), first + row(SPEEDS), first + row(SLOPES)
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
                motion, i, motion[row(STATE + r) + i], motion[row(HERE + r) + i], _rate_of(stages, 0, r, i),
                _rate_of(stages, 4, r, i),
            )  # fmt: skip
    for k in range(2 * directions):
        for i in range(width):
            # The angles' derivatives change by those of the speeds.
            angle, speed = row(k) + row(ANGLES) + i, row(k) + row(SPEEDS) + i
            weighted = _read_lane(motion, i, old[angle], new[angle], old[speed], new[speed])
            reading[row(k) + row(RODS_STATES) + i] = weighted


@part
def hold_back(motion, stages, old, new, directions, lane):
    """Let a lane be at the step's end where it was at its beginning."""
    for r in range(RODS_STATES):
        motion[row(HERE + r) + lane] = motion[row(STATE + r) + lane]
        stages[row(4 * STAGE + RATES + r) + lane] = stages[row(RATES + r) + lane]
    for k in range(2 * directions):
        for kind in range(3):
            place = row(kind * _KINDS) + row(k) + lane
            new[place] = old[place]


@part
def go_on(motion, stages):
    """Let the motions' end of the step be the next one's beginning; the derivatives at either change their places."""
    for i in range(row(RODS_STATES)):
        motion[row(STATE) + i] = motion[row(HERE) + i]
        stages[row(RATES) + i] = stages[row(4 * STAGE + RATES) + i]
