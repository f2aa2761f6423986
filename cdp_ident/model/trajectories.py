"""The motions of several windows with their derivatives, side by side in lanes where no effect acts.

Each lane goes at its own pace: its steps are divided where its own motion asks for it, as in `trajectory`, and windows
may differ in everything.
"""

from collections.abc import Sequence
from itertools import accumulate, groupby, pairwise
from typing import Literal

import numpy as np
import numpy.typing as npt

from cdp_ident.model.compilation import compiled, part
from cdp_ident.model.equations import RODS_STATES
from cdp_ident.model.events import AT_ONCE, SMALLEST
from cdp_ident.model.initial_value_problem import EndToEnd, InitialValueProblem
from cdp_ident.model.lanes import (
    INPUT,
    LANES,
    LENGTH,
    MOTION,
    OF_COEFFICIENTS,
    READING,
    ROUGHNESS,
    STAGE,
    STATE,
    TANGENTS,
    WEIGHTS,
    advance_lanes,
    begin_lanes,
    go_on,
    hold_back,
    read_lanes,
    row,
    step_lanes,
)
from cdp_ident.model.parameters import COEFFICIENTS
from cdp_ident.model.runge_kutta import hermite, input_at, is_too_rough
from cdp_ident.model.tangents import STAGES
from cdp_ident.model.trajectory import FASTEST, motions, motions_with_derivatives

Array = npt.NDArray[np.float64]
Indices = npt.NDArray[np.int64]
Derivatives = Literal["all", "start", "none"]
"""Which are wanted: by everything, by the initial state alone, or none."""


_FEWEST = 3
"""So many windows are faster side by side than one after the other, for all lanes take their time."""


def trajectories(
    problems: Sequence[InitialValueProblem], derivatives: Derivatives = "all"
) -> list[tuple[Array, Array]]:
    """Return of each problem the states (n, states), and the derivatives of theta1 and theta2 (n, 2, directions).

    They are those of `trajectory_with_derivatives`, but for rounding; by the initial state only where "start" is asked
    for, and without any direction for "none". Where no effect acts, windows are side by side, and what else is
    simulated along does not change a bit of a window.
    """
    return [
        (states[first:end], by_directions[first:end])
        for states, by_directions, bounds in _simulated(problems, derivatives)
        for first, end in pairwise(bounds.tolist())
    ]


def end_to_end(
    problems: Sequence[InitialValueProblem], derivatives: Derivatives = "all"
) -> tuple[Array, Array, Indices]:
    """Return what `trajectories` does of problems with as many directions each, their samples end to end.

    The third array (problems + 1,) says where each one's samples begin, and the last one's end.
    """
    parts = _simulated(problems, derivatives)
    if len(parts) == 1:
        return parts[0]
    states, by_directions, bounds = zip(*parts, strict=True)
    ends = np.cumsum(np.concatenate([np.diff(of_part) for of_part in bounds]))
    return np.concatenate(states), np.concatenate(by_directions), np.array([0, *ends])


def _simulated(problems: Sequence[InitialValueProblem], derivatives: Derivatives) -> list[tuple[Array, Array, Indices]]:
    """Return the motions of all problems, of those end to end that are simulated together."""
    if len(problems) < _FEWEST or any(len(problem.torques.table) for problem in problems):
        alike = groupby(problems, key=lambda problem: (id(problem.torques.table), id(problem.torques.lanes)))
        return [_one_by_one(list(part), derivatives) for _, part in alike]
    return [_side_by_side(problems[first : first + LANES], derivatives) for first in range(0, len(problems), LANES)]


def _one_by_one(problems: Sequence[InitialValueProblem], derivatives: Derivatives) -> tuple[Array, Array, Indices]:
    """Do the same for problems whose effects are laid out alike."""
    if derivatives == "none":
        return motions(problems)
    return motions_with_derivatives(problems, by_start_only=derivatives == "start", of_angles_only=True)


def _side_by_side(problems: Sequence[InitialValueProblem], derivatives: Derivatives) -> tuple[Array, Array, Indices]:
    """Do the same for no more problems without effects than there are lanes."""
    laid_out = EndToEnd(problems)
    directions = {"all": RODS_STATES + len(COEFFICIENTS), "start": RODS_STATES, "none": 0}[derivatives]
    samples = int(laid_out.grids[-1][-1])
    states, by_directions = np.empty((samples, RODS_STATES)), np.empty((samples, 2, directions))
    computed = np.empty(len(problems), dtype=np.int64)
    _trajectories_in_lanes(
        laid_out.coefficients, laid_out.starts(RODS_STATES), *laid_out.grids, np.uint64(LANES), *_rows(), states,
        by_directions, computed,
    )  # fmt: skip
    laid_out.mark_uncomputed(states, by_directions, computed)
    return states, by_directions, laid_out.grids[-1]


def _rows() -> list[Array]:
    """Return the rows of a block, each at the beginning of a line of the processor's cache."""
    lengths = [LANES * rows for rows in (MOTION, STAGES * STAGE, TANGENTS, TANGENTS, READING)]
    room = np.zeros(sum(lengths) + LANES)
    first = -room.ctypes.data // room.itemsize % LANES
    return [room[first + end - length : first + end] for length, end in zip(lengths, accumulate(lengths), strict=True)]


@compiled
def _trajectories_in_lanes(
    coefficients, starts, step, u, of_u, first_sample, of_steps, place, of_samples, width, motion, stages, old, new,
    reading, states, derivatives, computed,
):  # fmt: skip
    """Compute the motions, and fill in how many measurements each reaches.

    Args:
        coefficients: (motions, 7) `COEFFICIENTS` of each.
        starts: (motions, 4) state at the beginning.
        step: (motions,) the grid's step [s].
        u: the cart's accelerations at the half steps of all motions, one after the other.
        of_u: (motions + 1,) where those of each begin.
        first_sample: of all their grids, likewise.
        of_steps: where those of each begin.
        place: of all their grids, likewise.
        of_samples: where those of each begin.
        width: `LANES`.
        motion: rows of `lanes.MOTION`.
        stages: rows of all stages.
        old: rows of the derivatives at a step's beginning.
        new: at its end.
        reading: rows of a measurement.
        states: (samples, 4) takes the states at the measurements of all motions.
        derivatives: (samples, 2, directions) takes the derivatives of the angles.
        computed: (motions,) takes how many measurements are reached.
    """
    # Where each lane is: the step of its grid, the next measurement, how much of the step is done, of how much the next
    # part may be and is. A lane that has come to its end goes on with steps of no length.
    k, j, done, longest, share, inputs = (
        np.zeros(LANES, dtype=np.int64), np.zeros(LANES, dtype=np.int64), np.zeros(LANES), np.ones(LANES),
        np.zeros(LANES), np.empty(3),
    )  # fmt: skip
    motions, directions, running = np.uint64(len(starts)), derivatives.shape[2], len(starts)
    for lane in range(np.uint64(LANES)):
        # Lanes that are left over repeat the last motion's beginning.
        source = min(lane, motions - np.uint64(1))
        for r in range(coefficients.shape[1]):
            motion[row(OF_COEFFICIENTS + r) + lane] = coefficients[source, r]
        for r in range(RODS_STATES):
            motion[row(STATE + r) + lane] = starts[source, r]
        stages[row(INPUT) + lane] = u[of_u[source]]
    begin_lanes(motion, stages, old, directions, width)
    for lane in range(motions):
        computed[lane] = of_samples[lane + 1] - of_samples[lane]
    while running > 0:
        for lane in range(motions):
            share[lane] = 0.0
            if k[lane] >= 0:
                fastest = max(abs(motion[row(STATE + 2) + lane]), abs(motion[row(STATE + 3) + lane]))
                if done[lane] == 0.0 and fastest * step[lane] > FASTEST:
                    computed[lane] = first_sample[of_steps[lane] + k[lane]]
                    k[lane] = -1
                    running -= 1
                else:
                    share[lane] = min(longest[lane], 1.0 - done[lane])
                    first = of_u[lane] + 2 * k[lane]
                    inputs[0], inputs[1], inputs[2] = u[first], u[first + 1], u[first + 2]
                    middle = input_at(inputs, done[lane] + 0.5 * share[lane])
                    end = input_at(inputs, done[lane] + share[lane])
                    stages[row(1 * STAGE + INPUT) + lane], stages[row(2 * STAGE + INPUT) + lane] = middle, middle
                    stages[row(3 * STAGE + INPUT) + lane], stages[row(4 * STAGE + INPUT) + lane] = end, end
            motion[row(LENGTH) + lane] = share[lane] * step[lane]
        step_lanes(motion, stages, width)
        advance_lanes(motion, stages, old, new, directions, width)
        for lane in range(motions):
            if share[lane] > SMALLEST and is_too_rough(motion[row(ROUGHNESS) + lane], motion[row(LENGTH) + lane]):
                longest[lane], share[lane] = 0.5 * share[lane], 0.0
                hold_back(motion, stages, old, new, directions, lane)
        while _begin_reading(motions, step, first_sample, of_steps, place, of_samples, motion, k, j, done, share):
            read_lanes(motion, stages, old, new, reading, directions, width)
            for lane in range(motions):
                if motion[row(WEIGHTS) + lane] + motion[row(WEIGHTS + 1) + lane] > 0.5:
                    sample = np.uint64(of_samples[lane] + j[lane])
                    for r in range(RODS_STATES):
                        states[sample, r] = reading[row(r) + lane]
                    for r in range(2):
                        for d in range(directions):
                            derivatives[sample, r, d] = reading[row(RODS_STATES + r) + row(2 * d) + lane]
                    j[lane] += 1
        go_on(motion, stages)
        old, new = new, old
        for lane in range(motions):
            if share[lane] > 0.0:
                longest[lane], done[lane] = min(1.0, 2.0 * longest[lane]), done[lane] + share[lane]
                if done[lane] > 1.0 - AT_ONCE:
                    k[lane], done[lane] = k[lane] + 1, 0.0
                    if k[lane] == of_steps[lane + 1] - of_steps[lane] - 1:
                        k[lane] = -1
                        running -= 1


@part
def _begin_reading(motions, step, first_sample, of_steps, place, of_samples, motion, k, j, done, share):
    """Fill in the weights of each lane's next measurement in this part of a step, and return whether there is any.

    The weights are zero in lanes where there is none.
    """
    some = False
    for lane in range(motions):
        reads = False
        if share[lane] > 0.0 and j[lane] < first_sample[of_steps[lane] + k[lane] + 1]:
            reached, at = done[lane] + share[lane], place[of_samples[lane] + j[lane]]
            reads = at <= reached or reached > 1.0 - AT_ONCE
        w0, w1, w2, w3 = 0.0, 0.0, 0.0, 0.0
        if reads:
            some = True
            w0, w1, w2, w3 = hermite((at - done[lane]) / share[lane], share[lane] * step[lane])
        motion[row(WEIGHTS) + lane], motion[row(WEIGHTS + 1) + lane] = w0, w1
        motion[row(WEIGHTS + 2) + lane], motion[row(WEIGHTS + 3) + lane] = w2, w3
    return some
