"""What happens in one lane: where a joint with dry friction stops or breaks loose, and a motion goes on otherwise.

It is what `trajectory` does at these instants, by the same functions (`sticking`, `events`), on one lane of many: what
they work on is copied out of the lane's rows, and back into them.
"""

from cdp_ident.model.compilation import part
from cdp_ident.model.dynamics import STICKS, onto_rods, rates_at
from cdp_ident.model.equations import RODS_STATES, holding, inertia_between, torques_on_rods
from cdp_ident.model.events import instant_of, share_by_speed
from cdp_ident.model.lane_rows import (
    ANGLES,
    COUPLED,
    HERE,
    INPUT,
    LOOKS,
    MODES,
    OF_COEFFICIENTS,
    RATES,
    SIZES,
    SLOPES,
    SPEEDS,
    STAGE,
    STATE,
    TORQUES,
    TURNED,
    row,
)
from cdp_ident.model.runge_kutta import copy
from cdp_ident.model.sticking import dip, held_speeds, inertia_of_both, lateness, settle, stop, violation
from cdp_ident.model.tangents import rates as rates_of_speeds

NOT_ENDED = -1
"""No joint's mode has ended."""


@part
def copy_out(rows, first, lane, target):
    """Copy a number of each of some neighbouring rows of a lane."""
    for r in range(len(target)):
        target[r] = rows[row(first + r) + lane]


@part
def share_of_lane(motion, stages, lane, table, values, step, alone):
    """Return the largest share of a step that resolves every torque that changes fast."""
    state, rates = alone[0], alone[1]
    copy_out(motion, STATE, lane, state)
    copy_out(stages, RATES, lane, rates[0])
    return share_by_speed(state, rates, table, values, step)


@part
def settle_lane(
    motion, stages, tangents, directions, lane, time, u, coefficients, modes, dry, ended, table, values, lanes_of,
    constants, alone, scratch,
):  # fmt: skip
    """Let a lane's motion go on from where a joint's mode has ended, or begin: modes, rates and derivatives.

    Args:
        motion: rows of the motions.
        stages: of their stages; those of the first one are what follows from.
        tangents: rows of the derivatives.
        directions: how many.
        lane: which.
        time: in the trial [s].
        u: the cart's acceleration [m/s^2].
        coefficients: (7,) of this motion, like all that follow.
        modes: (2,) of the joints; takes the new ones.
        dry: (2,) which of them have dry friction.
        ended: the joint whose mode has ended, or `NOT_ENDED` at the beginning.
        table: the effects.
        values: their parameters.
        lanes_of: the lanes of these.
        constants: of the mechanism.
        alone: arrays for one motion.
        scratch: arrays for laws.
    """
    state, rates, before, sums, by_state, direct, no_direct, none = (
        alone[0], alone[1], alone[2], alone[3], alone[4], alone[5], alone[6], alone[7],
    )  # fmt: skip
    slopes, by_own, by_lane = scratch
    copy_out(motion, STATE, lane, state)
    copy_out(stages, RATES, lane, before)
    loose, crossed = -1, -1
    if ended >= 0:
        if modes[ended] == STICKS:
            loose = ended
            # Which way it breaks loose follows from the torque that held it.
            rates_at(
                state, time, u, modes, coefficients, table, values, lanes_of, constants, -1, slopes, by_own, none,
                sums, by_state, no_direct, rates, 0,
            )  # fmt: skip
        else:
            stop(state, ended)
            # A joint that sticks goes on doing so, whatever the other one does.
            if modes[1 - ended] == STICKS:
                stop(state, 1 - ended)
            crossed = ended
    settle(
        state, time, u, modes, dry, loose, coefficients, table, values, lanes_of, constants, -1, slopes, by_own,
        by_lane, sums, by_state, direct, rates, 0,
    )  # fmt: skip
    for r in range(RODS_STATES):
        motion[row(STATE + r) + lane] = state[r]
        stages[row(RATES + r) + lane] = rates[0, r]
    for joint in range(2):
        motion[row(MODES + joint) + lane] = modes[joint]
    if directions == 0:
        return
    if crossed >= 0:
        _carry_lane_across(tangents, directions, lane, crossed, before, rates)
    for joint in range(2):
        if modes[joint] == STICKS:
            m = inertia_of_both(state, coefficients, table, values)
            for d in range(directions):
                speed = row(SPEEDS + 2 * d) + lane
                tangents[speed], tangents[speed + row(1)] = held_speeds(
                    tangents[speed], tangents[speed + row(1)], joint, coefficients[1], m
                )
    matrix = (
        by_state[0, 0, 0], by_state[0, 0, 1], by_state[0, 0, 2], by_state[0, 0, 3],
        by_state[0, 1, 0], by_state[0, 1, 1], by_state[0, 1, 2], by_state[0, 1, 3],
    )  # fmt: skip
    for d in range(directions):
        angle, speed, slope = row(ANGLES + 2 * d) + lane, row(SPEEDS + 2 * d) + lane, row(SLOPES + 2 * d) + lane
        tangents[slope], tangents[slope + row(1)] = rates_of_speeds(
            matrix, (direct[0, 0, d], direct[0, 1, d]),
            tangents[angle], tangents[angle + row(1)], tangents[speed], tangents[speed + row(1)],
        )  # fmt: skip


@part
def _carry_lane_across(tangents, directions, lane, joint, before, after):
    """Do in a lane what `sticking.carry_across` does."""
    towards = before[2] if joint == 0 else before[3] - before[2]
    if towards == 0.0:
        return
    for d in range(directions):
        speed = row(SPEEDS + 2 * d) + lane
        late = lateness(tangents[speed], tangents[speed + row(1)], joint, towards)
        tangents[speed] += (before[2] - after[0, 2]) * late
        tangents[speed + row(1)] += (before[3] - after[0, 3]) * late


@part
def mark_lanes(motion, stages, dry, width):
    """Mark the lanes in which a joint's mode may have ended in the step: it stopped, turned round or broke loose."""
    for i in range(width):
        # What holds the joints that stick, by the torques at the step's end.
        c, end, t, torques = row(OF_COEFFICIENTS) + i, row(HERE) + i, row(TURNED) + i, row(TORQUES) + i
        turned = motion[t], motion[t + row(1)], motion[t + row(2)], motion[t + row(3)]
        n1, n2 = torques_on_rods(
            turned, motion[end + row(2)], motion[end + row(3)], stages[row(4 * STAGE + INPUT) + i], motion[c],
            motion[c + row(2)], motion[c + row(3)], motion[c + row(4)], motion[c + row(5)], motion[c + row(6)],
            motion[torques], motion[torques + row(1)],
        )  # fmt: skip
        m = inertia_between(turned, motion[c], motion[row(COUPLED) + i])
        inner, outer = motion[row(MODES) + i] == STICKS, motion[row(MODES + 1) + i] == STICKS
        held1, held2 = holding(n1, n2, motion[c + row(1)], m, inner, outer)
        size1, size2 = max(motion[row(SIZES) + i], 0.0), max(motion[row(SIZES + 1) + i], 0.0)
        loose = (inner and abs(held1) > size1) or (outer and abs(held2) > size2)
        motion[row(LOOKS) + i] = 1.0 if loose else 0.0
    for joint in range(2):
        if dry[joint]:
            onto1, onto2 = onto_rods(joint)
            for i in range(width):
                mode, end = motion[row(MODES + joint) + i], row(HERE) + i
                first, last = row(RATES) + i, row(4 * STAGE + RATES) + i
                speed = mode * (onto1 * motion[end + row(2)] + onto2 * motion[end + row(3)])
                slows = mode * (onto1 * stages[first + row(2)] + onto2 * stages[first + row(3)])
                speeds_up = mode * (onto1 * stages[last + row(2)] + onto2 * stages[last + row(3)])
                dips = slows < 0.0 and speeds_up > 0.0
                motion[row(LOOKS) + i] += 1.0 if speed < 0.0 or dips else 0.0


@part
def look_into_lane(
    motion, stages, lane, begin, done, share, step, inputs, coefficients, modes, dry, table, values, lanes_of,
    constants, alone, scratch,
):  # fmt: skip
    """Return after which share of a step, up to the one it has made, a joint's mode ends, and in which joint.

    That is `NOT_ENDED` where none ends.

    Args:
        motion: rows of the motions.
        stages: of their stages.
        lane: which.
        begin: time in the trial at the beginning of the grid's step [s].
        done: share of it from which the lane's step was made.
        share: of it that this was long.
        step: length of the grid's step [s].
        inputs: (3,) the cart's acceleration at its beginning, middle and end [m/s^2].
        coefficients: (7,) of this motion; what follows is as in `settle_lane`.
        modes: likewise.
        dry: likewise.
        table: likewise.
        values: likewise.
        lanes_of: likewise.
        constants: likewise.
        alone: likewise.
        scratch: likewise.
    """
    state, rates, last, sums, by_state, no_direct, none, at, end, violations = (
        alone[0], alone[1], alone[2], alone[3], alone[4], alone[6], alone[7], alone[8], alone[9], alone[10],
    )  # fmt: skip
    slopes, by_own, _ = scratch
    copy_out(motion, HERE, lane, end)
    copy_out(stages, RATES, lane, rates[0])
    copy_out(stages, 4 * STAGE + RATES, lane, last)
    if modes[0] == STICKS or modes[1] == STICKS:
        reached = done + share
        rates_at(
            end, begin + reached * step, stages[row(4 * STAGE) + lane], modes, coefficients, table, values, lanes_of,
            constants, -1, slopes, by_own, none, sums, by_state, no_direct, rates, 4,
        )  # fmt: skip
    copy(last, rates[4])
    for joint in range(2):
        violations[joint] = violation(end, joint, modes, sums) if dry[joint] else -1.0
    ends, stopped = share, NOT_ENDED
    copy_out(motion, STATE, lane, state)
    for joint in range(2):
        # The search for the first one has overwritten the rates.
        copy(last, rates[4])
        dips = dry[joint] and modes[joint] != STICKS and dip(joint, modes, rates) > 0.0
        if violations[joint] > 0.0 or dips:
            instant = instant_of(
                joint, violations[joint], state, done, share, step, begin, inputs, modes, coefficients, table, values,
                lanes_of, constants, -1, slopes, by_own, none, sums, by_state, no_direct, at, rates, end,
            )  # fmt: skip
            if instant <= ends:
                ends, stopped = instant, joint
    return ends, stopped
