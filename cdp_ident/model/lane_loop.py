"""The loop over the steps of several motions side by side in lanes (compiled): see `lane_rows`.

Each lane goes at its own pace: its steps are divided where its own motion asks for it, as in `trajectory`, and motions
may differ in everything but the effects that act on them.
"""

import numpy as np

from cdp_ident.model.compilation import Compilable, compiled, part
from cdp_ident.model.dynamics import COUNT_OF_SUMS
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.events import AT_ONCE, SMALLEST
from cdp_ident.model.lane_events import NOT_ENDED, look_into_lane, mark_lanes, settle_lane, share_of_lane
from cdp_ident.model.lane_rows import (
    INPUT,
    LANES,
    LENGTH,
    LOOKS,
    ROUGHNESS,
    STAGE,
    STATE,
    TIME,
    WEIGHTS,
    row,
)
from cdp_ident.model.lanes import (
    advance_lanes,
    begin_lane,
    go_on,
    hold_back,
    read_lanes,
    set_out,
    step_lanes,
    step_with_torques,
)
from cdp_ident.model.runge_kutta import hermite, input_at, is_too_rough
from cdp_ident.model.tangents import STAGES
from cdp_ident.model.trajectory import FASTEST, MOST_EVENTS


@part
def _begin_reading(of, step, first_sample, of_steps, place, of_samples, motion, k, j, done, share, width):
    """Fill in the weights of each lane's next measurement in this part of a step, and return whether there is any.

    The weights are zero in lanes where there is none.
    """
    some = False
    for lane in range(width):
        reads, m = False, np.uint64(max(of[lane], 0))
        if share[lane] > 0.0 and j[lane] < first_sample[of_steps[m] + k[lane] + 1]:
            reached, at = done[lane] + share[lane], place[of_samples[m] + j[lane]]
            reads = at <= reached or reached > 1.0 - AT_ONCE
        w0, w1, w2, w3 = 0.0, 0.0, 0.0, 0.0
        if reads:
            some = True
            w0, w1, w2, w3 = hermite((at - done[lane]) / share[lane], share[lane] * step[m])
        motion[row(WEIGHTS) + lane], motion[row(WEIGHTS + 1) + lane] = w0, w1
        motion[row(WEIGHTS + 2) + lane], motion[row(WEIGHTS + 3) + lane] = w2, w3
    return some


def _loop(acts: bool) -> Compilable:
    """Return the compiled loop that computes motions in lanes, with effects or without: these are compiled sooner."""
    make_step = step_with_torques if acts else step_lanes

    def steps(
        order, coefficients, starts, begins, step, u, of_u, first_sample, of_steps, place, of_samples, table,
        values, lanes_of, constants, width, motion, stages, old, new, reading, states, derivatives, computed, of, k,
        j, done, longest, share, moves, inputs, ends, stopped, events, located, settles, dry, modes, turns_over,
        scratch, alone,
    ):  # fmt: skip
        """Make all steps; a `part`, so that no array is counted in them."""
        directions, next_one, running = derivatives.shape[2], 0, len(starts)
        while running > 0:
            for lane in range(width):
                moves[lane], share[lane] = False, 0.0
                if of[lane] < 0 and next_one < len(order):
                    m = np.uint64(order[next_one])
                    of[lane], next_one = m, next_one + 1
                    begin_lane(motion, old, directions, lane, coefficients[m], starts[m], values[m], constants[m])
                    computed[m] = of_samples[m + 1] - of_samples[m]
                    k[lane], j[lane], done[lane], longest[lane], events[lane] = 0, 0, 0.0, 1.0, 0
                    settles[lane], stopped[lane], located[lane] = True, NOT_ENDED, False
                    modes[lane, 0], modes[lane, 1] = 1, 1
                m = np.uint64(max(of[lane], 0))
                if of[lane] >= 0:
                    fastest = max(abs(motion[row(STATE + 2) + lane]), abs(motion[row(STATE + 3) + lane]))
                    if done[lane] == 0.0 and fastest * step[m] > FASTEST:
                        computed[m] = first_sample[of_steps[m] + k[lane]]
                        of[lane] = -1
                        running -= 1
                    else:
                        first = of_u[m] + 2 * k[lane]
                        inputs[0], inputs[1], inputs[2] = u[first], u[first + 1], u[first + 2]
                        if acts:
                            time = begins[m] + (k[lane] + done[lane]) * step[m]
                            motion[row(TIME) + lane] = time
                        if settles[lane]:
                            if acts:
                                settle_lane(
                                    motion, stages, old, directions, lane, time, input_at(inputs, done[lane]),
                                    coefficients[m], modes[lane], dry, stopped[lane], table, values[m], lanes_of,
                                    constants[m], alone, scratch,
                                )  # fmt: skip
                            else:
                                set_out(motion, stages, old, directions, lane, inputs[0])
                            settles[lane], stopped[lane] = False, NOT_ENDED
                        moves[lane], share[lane] = True, min(longest[lane], 1.0 - done[lane])
                        if acts:
                            if located[lane]:
                                share[lane] = ends[lane]
                            elif turns_over:
                                finest = share_of_lane(motion, stages, lane, table, values[m], step[m], alone)
                                share[lane] = min(share[lane], finest)
                        middle = input_at(inputs, done[lane] + 0.5 * share[lane])
                        end = input_at(inputs, done[lane] + share[lane])
                        stages[row(1 * STAGE + INPUT) + lane], stages[row(2 * STAGE + INPUT) + lane] = middle, middle
                        stages[row(3 * STAGE + INPUT) + lane], stages[row(4 * STAGE + INPUT) + lane] = end, end
                motion[row(LENGTH) + lane] = share[lane] * step[m]
            make_step(motion, stages, directions, width, table, lanes_of)
            advance_lanes(motion, stages, old, new, directions, width)
            if acts:
                mark_lanes(motion, stages, dry, width)
            for lane in range(width):
                if moves[lane] and not (acts and located[lane]):
                    rough = is_too_rough(motion[row(ROUGHNESS) + lane], motion[row(LENGTH) + lane])
                    if share[lane] > SMALLEST and rough:
                        longest[lane], moves[lane] = 0.5 * share[lane], False
                    elif acts and motion[row(LOOKS) + lane] > 0.0 and events[lane] < MOST_EVENTS:
                        m = np.uint64(of[lane])
                        first = of_u[m] + 2 * k[lane]
                        inputs[0], inputs[1], inputs[2] = u[first], u[first + 1], u[first + 2]
                        ends[lane], stopped[lane] = look_into_lane(
                            motion, stages, lane, begins[m] + k[lane] * step[m], done[lane], share[lane], step[m],
                            inputs, coefficients[m], modes[lane], dry, table, values[m], lanes_of, constants[m], alone,
                            scratch,
                        )  # fmt: skip
                        events[lane] += 1
                        # The step is repeated, up to that instant.
                        located[lane] = stopped[lane] >= 0 and ends[lane] < share[lane]
                        moves[lane] = not located[lane]
                if not moves[lane]:
                    share[lane] = 0.0
                    hold_back(motion, stages, old, new, directions, lane)
            while _begin_reading(of, step, first_sample, of_steps, place, of_samples, motion, k, j, done, share, width):
                read_lanes(motion, stages, old, new, reading, directions, width)
                for lane in range(width):
                    if motion[row(WEIGHTS) + lane] + motion[row(WEIGHTS + 1) + lane] > 0.5:
                        sample = np.uint64(of_samples[np.uint64(of[lane])] + j[lane])
                        for r in range(RODS_STATES):
                            states[sample, r] = reading[row(r) + lane]
                        for r in range(2):
                            for d in range(directions):
                                derivatives[sample, r, d] = reading[row(RODS_STATES + r) + row(2 * d) + lane]
                        j[lane] += 1
            go_on(motion, stages)
            old, new = new, old
            for lane in range(width):
                if moves[lane]:
                    longest[lane], done[lane] = min(1.0, 2.0 * longest[lane]), done[lane] + share[lane]
                    if acts:
                        located[lane], settles[lane] = False, stopped[lane] >= 0
                    if done[lane] > 1.0 - AT_ONCE:
                        m = np.uint64(of[lane])
                        k[lane], done[lane], events[lane] = k[lane] + 1, 0.0, 0
                        if k[lane] == of_steps[m + 1] - of_steps[m] - 1:
                            of[lane] = -1
                            running -= 1

    steps.__name__ = steps.__qualname__ = "steps_in_lanes_with_torques" if acts else "steps_in_lanes_alone"
    all_steps = part(steps)

    def in_lanes(
        order, coefficients, starts, begins, step, u, of_u, first_sample, of_steps, place, of_samples, table, values,
        lanes_of, constants, width, motion, stages, old, new, reading, states, derivatives, computed,
    ):  # fmt: skip
        """Compute motions, and fill in how many measurements each reaches.

        Args:
            order: (motions,) in which they are begun.
            coefficients: (motions, 7) `COEFFICIENTS` of each.
            starts: (motions, 4) state at the beginning.
            begins: (motions,) time in the trial then [s].
            step: (motions,) the grid's step [s].
            u: the cart's accelerations at the half steps of all motions, one after the other.
            of_u: (motions + 1,) where those of each begin.
            first_sample: of all their grids, likewise.
            of_steps: where those of each begin.
            place: of all their grids, likewise.
            of_samples: where those of each begin.
            table: the effects, as `Torques` has them.
            values: (motions, effects, p) their parameters.
            lanes_of: the lanes of these, as `Torques` has them.
            constants: (motions, …) of the mechanism.
            width: `LANES`.
            motion: rows of `lane_rows.MOTION`.
            stages: rows of all stages.
            old: rows of the derivatives at a step's beginning.
            new: at its end.
            reading: rows of a measurement.
            states: (samples, 4) takes the states at the measurements of all motions.
            derivatives: (samples, 2, directions) takes the derivatives of the angles.
            computed: (motions,) takes how many measurements are reached.
        """
        # Where each lane is: its motion, the step of its grid, the next measurement, how much of the step is done, of
        # how much the next part may be and is. A lane without a motion goes on with steps of no length.
        of, k, j, done, longest, share, moves, inputs = (
            np.full(LANES, -1), np.zeros(LANES, dtype=np.int64), np.zeros(LANES, dtype=np.int64), np.zeros(LANES),
            np.ones(LANES), np.zeros(LANES), np.zeros(LANES, dtype=np.bool_), np.empty(3),
        )  # fmt: skip
        # Where a joint's mode ends in the next part: how much of the step that part is, and in which joint; how often
        # that was looked for in this step. A lane whose motion does not go on as it did is to be settled.
        ends, stopped, events, located, settles = (
            np.zeros(LANES), np.full(LANES, NOT_ENDED), np.zeros(LANES, dtype=np.int64),
            np.zeros(LANES, dtype=np.bool_), np.zeros(LANES, dtype=np.bool_),
        )  # fmt: skip
        dry, modes, turns_over = np.zeros(2, dtype=np.bool_), np.ones((LANES, 2), dtype=np.int64), False
        for e in range(len(table)):
            turns_over = turns_over or table[e, 4] >= 0
            if table[e, 3]:
                dry[table[e, 2]] = True
        directions = derivatives.shape[2]
        none, no_direct, by_state = np.zeros((2, 0)), np.zeros((1, 2, 0)), np.zeros((1, 2, RODS_STATES))
        scratch = np.zeros((2, 2 + values.shape[2])), np.zeros((2, RODS_STATES)), np.zeros((2, directions))
        alone = (
            np.empty(RODS_STATES), np.zeros((STAGES, RODS_STATES)), np.empty(RODS_STATES), np.zeros(COUNT_OF_SUMS),
            by_state, np.zeros((1, 2, directions)), no_direct, none, np.empty(RODS_STATES), np.empty(RODS_STATES),
            np.empty(2),
        )  # fmt: skip
        for lane in range(width):
            # Lanes that are left over stay at the first motion's beginning.
            m = np.uint64(order[0])
            begin_lane(motion, old, directions, lane, coefficients[m], starts[m], values[m], constants[m])
        all_steps(
            order, coefficients, starts, begins, step, u, of_u, first_sample, of_steps, place, of_samples, table,
            values, lanes_of, constants, width, motion, stages, old, new, reading, states, derivatives, computed, of, k,
            j, done, longest, share, moves, inputs, ends, stopped, events, located, settles, dry, modes, turns_over,
            scratch, alone,
        )  # fmt: skip

    in_lanes.__name__ = in_lanes.__qualname__ = "in_lanes_with_torques" if acts else "in_lanes_alone"
    return compiled(in_lanes)


in_lanes_alone, in_lanes_with_torques = _loop(acts=False), _loop(acts=True)
